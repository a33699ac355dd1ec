//! Power.

use std::ops::Range;

use super::blend::{AMOUNT, show};
use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// `a ^ exponent`, with negative `a` read as 0. `0 ^ 0` is 1; 0 to any other power is 0.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Power {}

impl Operation for Power {
    const SPEC: Spec = Spec {
        name: "power",
        category: Category::Combine,
        summary: "Raises an image to a power: above 1 sharpens a mask towards its peaks, below 1 fattens it.",
        inputs: &[
            InputSpec::image("a", "The base; negative values read as 0."),
            InputSpec::drive(
                "exponent",
                2.0,
                (-64.0, 64.0),
                "",
                "2 squares, 0.5 is the root, 1 changes nothing (but clears what is negative).",
            ),
            AMOUNT,
        ],
        outputs: &[OutputSpec::same("result", "The power.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        3.0
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(0, y), ins.row(1, y), ins.row(2, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(a: &[f32], exponent: &[f32], amount: &[f32], out: &mut [f32]) {
        for (((o, a), p), m) in out.iter_mut().zip(a).zip(exponent).zip(amount) {
            let base = a.max(0.0);
            let power = num::powf(base, *p);
            // The polynomial is exact to a few ulp only; 1 must change nothing.
            *o = show(*a, if *p == 1.0 { base } else { power }, *m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_is_the_power_with_its_limits() {
        let at = |a: f32, p: f32| texel(&Power::default(), &[a, p]);
        for (a, p, expected) in [(0.3f32, 2.0, 0.09), (9.0, 0.5, 3.0), (4.0, -1.0, 0.25), (1.0, 64.0, 1.0)] {
            assert!((at(a, p) - expected).abs() < 1e-5 * expected, "{a} ^ {p}");
        }
        assert_eq!(at(0.3, 1.0), 0.3);
        assert_eq!(at(0.0, 0.0), 1.0);
        assert_eq!(at(-2.0, 2.0), 0.0);
        assert_eq!(at(0.0, -1.0), 0.0);
    }
}
