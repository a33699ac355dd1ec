//! Smooth maximum.

use std::ops::Range;

use super::blend::{AMOUNT, show};
use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// The larger of `a` and `b`, with a round ridge where they cross. Joins heights softly.
///
/// Source: Inigo Quilez, "Smooth minimum", quadratic form.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SmoothMax {}

impl Operation for SmoothMax {
    const SPEC: Spec = Spec {
        name: "smooth_max",
        category: Category::Combine,
        summary: "Keeps the larger of two images, with a round ridge where they cross.",
        inputs: &[
            InputSpec::image("a", "First image."),
            InputSpec::image("b", "Second image."),
            InputSpec::drive(
                "k",
                0.1,
                (0.0, 1e6),
                "",
                "How round: they blend where they differ by less than this, in their own unit; 0 is the plain maximum.",
            ),
            AMOUNT,
        ],
        outputs: &[OutputSpec::same("result", "The larger, rounded by at most `k` / 4.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.4
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(0, y), ins.row(1, y), ins.row(2, y), ins.row(3, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(a: &[f32], b: &[f32], k: &[f32], amount: &[f32], out: &mut [f32]) {
        for ((((o, a), b), k), m) in out.iter_mut().zip(a).zip(b).zip(k).zip(amount) {
            *o = show(*a, num::smooth_max(*a, *b, k.max(0.0)), *m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_is_the_max_beyond_k_and_k_over_4_off_where_they_cross() {
        let at = |a: f32, b: f32, k: f32| texel(&SmoothMax::default(), &[a, b, k]);
        assert_eq!(at(0.3, 0.7, 0.0), 0.3f32.max(0.7));
        assert_eq!(at(0.3, 0.7, 0.39), 0.3f32.max(0.7));
        assert_eq!(at(0.5, 0.5, 0.4), 0.5 + 0.1);
        assert_eq!(at(0.3, 0.7, -1.0), 0.3f32.max(0.7));
    }
}
