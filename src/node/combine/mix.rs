//! Linear mix with a mask.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// `a` where the mask is 0, `b` where it is 1, linear between.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Mix {}

const A: usize = 0;
const B: usize = 1;
const MASK: usize = 2;

impl Operation for Mix {
    const SPEC: Spec = Spec {
        name: "mix",
        category: Category::Combine,
        summary: "Mixes two images by a mask.",
        inputs: &[
            InputSpec::image("a", "Shown where the mask is 0."),
            InputSpec::image("b", "Shown where the mask is 1."),
            InputSpec::drive(
                "mask",
                0.5,
                (0.0, 1.0),
                "",
                "How much of `b`: 0 none, 1 all; values outside are clamped.",
            ),
        ],
        outputs: &[OutputSpec::same("result", "The mix.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.3
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(A, y), ins.row(B, y), ins.row(MASK, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(a: &[f32], b: &[f32], mask: &[f32], out: &mut [f32]) {
        for (((o, a), b), m) in out.iter_mut().zip(a).zip(b).zip(mask) {
            *o = num::lerp(*a, *b, num::saturate(*m));
        }
    }
}
