//! Limits.

use std::ops::Range;

use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Values below `low` become `low`, values above `high` become `high`; where `low > high`, `high` wins.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Clamp {}

const IMAGE: usize = 0;
const LOW: usize = 1;
const HIGH: usize = 2;

impl Operation for Clamp {
    const SPEC: Spec = Spec {
        name: "clamp",
        summary: "Limits values to a range.",
        inputs: &[
            InputSpec::image("image", "What is limited."),
            InputSpec::drive("low", 0.0, (-1e6, 1e6), "", "Nothing is left below this."),
            InputSpec::drive("high", 1.0, (-1e6, 1e6), "", "Nothing is left above this; it wins over `low`."),
        ],
        outputs: &[OutputSpec::same("result", "Values between `low` and `high`.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.3
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(IMAGE, y), ins.row(LOW, y), ins.row(HIGH, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(image: &[f32], low: &[f32], high: &[f32], out: &mut [f32]) {
        for (((o, x), lo), hi) in out.iter_mut().zip(image).zip(low).zip(high) {
            *o = x.max(*lo).min(*hi);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, run, square};
    use super::*;
    use crate::eval::Input::{Plane as P, Value};

    #[test]
    fn values_end_up_between_the_limits_and_high_wins() {
        let a = noise(8, 8, 1);
        let out = run(&Clamp::default(), &square(8), &[P(&a), Value(0.3), Value(0.6)]);
        for (o, x) in out.data().iter().zip(a.data()) {
            assert_eq!(*o, x.clamp(0.3, 0.6));
        }
        let out = run(&Clamp::default(), &square(8), &[P(&a), Value(0.9), Value(0.2)]);
        assert!(out.data().iter().all(|&x| x == 0.2));
    }
}
