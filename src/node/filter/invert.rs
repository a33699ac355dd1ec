//! One minus.

use std::ops::Range;

use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// `1 - x`: masks swap inside and outside, heights turn over.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Invert {}

impl Operation for Invert {
    const SPEC: Spec = Spec {
        name: "invert",
        summary: "One minus the value.",
        inputs: &[InputSpec::image("image", "What is inverted.")],
        outputs: &[OutputSpec::same("result", "`1 - image`; not limited.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.2
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(0, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(image: &[f32], out: &mut [f32]) {
        for (o, x) in out.iter_mut().zip(image) {
            *o = 1.0 - *x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, run, square};
    use super::*;
    use crate::eval::Input::Plane as P;

    #[test]
    fn twice_is_the_input() {
        let a = noise(7, 7, 1);
        let once = run(&Invert::default(), &square(7), &[P(&a)]);
        let twice = run(&Invert::default(), &square(7), &[P(&once)]);
        for ((a, b), c) in a.data().iter().zip(once.data()).zip(twice.data()) {
            assert_eq!(a + b, 1.0);
            assert!((a - c).abs() < 1e-7);
        }
    }
}
