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

    fn overwrites(&self) -> Option<usize> {
        Some(A)
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let is_output = ins.is_output(A);
        for y in rows {
            let (b, mask) = (ins.row(B, y), ins.row(MASK, y));
            if is_output {
                over(b, mask, outs.only(y));
            } else {
                kernel(ins.row(A, y), b, mask, outs.only(y));
            }
        }
    }
}

/// `a` itself where the mask is 0, also the sign of its zeros.
#[inline(always)]
fn mixed(a: f32, b: f32, mask: f32) -> f32 {
    let mix = num::lerp(a, b, num::saturate(mask));
    if mask > 0.0 { mix } else { a }
}

multiversion! {
    fn kernel(a: &[f32], b: &[f32], mask: &[f32], out: &mut [f32]) {
        for (((o, a), b), m) in out.iter_mut().zip(a).zip(b).zip(mask) { *o = mixed(*a, *b, *m); }
    }
}

/// Texels that are left as they are where the mask is 0 all over them.
const BLOCK: usize = 64;

multiversion! {
    /// `a` is in `out`.
    fn over(b: &[f32], mask: &[f32], out: &mut [f32]) {
        for ((o, b), m) in out.chunks_mut(BLOCK).zip(b.chunks(BLOCK)).zip(mask.chunks(BLOCK)) {
            let mut any = false;
            for m in m { any |= *m > 0.0; }
            if any {
                for ((o, b), m) in o.iter_mut().zip(b).zip(m) { *o = mixed(*o, *b, *m); }
            }
        }
    }
}
