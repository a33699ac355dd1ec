//! Histogram scan: a threshold that slides from nothing to everything.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A linear step of width `1 - contrast` slides over an image with values in [0, 1], so that `position` 0 gives
/// 0 everywhere below 1 and `position` 1 gives 1 everywhere.
///
/// The step runs from `low = (1 - position)(1 + w) - w` to `low + w`, `w = 1 - contrast`; position 0.5 at contrast 0
/// is the identity on [0, 1].
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HistogramScan {}

const IMAGE: usize = 0;
const POSITION: usize = 1;
const CONTRAST: usize = 2;

impl Operation for HistogramScan {
    const SPEC: Spec = Spec {
        name: "histogram_scan",
        summary: "Grows a mask out of a grey image: a step of chosen softness slides over its values.",
        inputs: &[
            InputSpec::image("image", "Grey image in [0, 1]."),
            InputSpec::drive(
                "position",
                0.5,
                (0.0, 1.0),
                "",
                "How much of the image becomes white: 0 none, 1 all; values outside are clamped.",
            ),
            InputSpec::drive(
                "contrast",
                0.5,
                (0.0, 1.0),
                "",
                "How hard the step is: 0 a ramp over all greys, 1 a hard step; values outside are clamped.",
            ),
        ],
        outputs: &[OutputSpec::same("mask", "The mask, in [0, 1].")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.5
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(IMAGE, y), ins.row(POSITION, y), ins.row(CONTRAST, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(image: &[f32], position: &[f32], contrast: &[f32], out: &mut [f32]) {
        for (((o, x), p), c) in out.iter_mut().zip(image).zip(position).zip(contrast) {
            let w = 1.0 - num::saturate(*c);
            let low = (1.0 - num::saturate(*p)) * (1.0 + w) - w;
            *o = num::linear_step(low, low + w, *x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, run, square};
    use super::*;
    use crate::eval::Input::{Plane as P, Value};

    #[test]
    fn position_sweeps_from_none_to_all_at_any_contrast() {
        let a = noise(32, 32, 1);
        let node = HistogramScan::default();
        for c in [0.0, 0.4, 1.0] {
            let mean = |p| num::mean(run(&node, &square(32), &[P(&a), Value(p), Value(c)]).data());
            assert_eq!(mean(0.0), 0.0);
            assert!((mean(1.0) - 1.0).abs() < 1e-6);
            let sweep: Vec<f64> = (0..=20).map(|i| mean(i as f32 / 20.0)).collect();
            assert!(sweep.windows(2).all(|w| w[0] <= w[1]), "{sweep:?}");
            assert!((mean(0.5) - 0.5).abs() < 0.05);
        }
    }

    #[test]
    fn the_middle_at_no_contrast_is_the_identity() {
        let a = noise(8, 8, 2);
        let out = run(&HistogramScan::default(), &square(8), &[P(&a), Value(0.5), Value(0.0)]);
        assert_eq!(out, a);
    }
}
