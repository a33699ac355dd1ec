//! Where a texel lies on the body.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Where a texel lies around and along the body; ramps over it make countershading.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyPosition {}

const LATERAL: usize = 0;
const SIDE: usize = 1;
const ALONG: usize = 2;

impl Operation for BodyPosition {
    const SPEC: Spec = Spec {
        name: "body_position",
        category: Category::Pattern,
        summary: "Where a texel lies around and along the body.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[
            OutputSpec::scalar(
                "lateral",
                "",
                "0 on the mid-back, 1 on the belly's middle, the same on both sides.",
            ),
            OutputSpec::scalar(
                "side",
                "",
                "0 on the mid-back, -1 and 1 on the belly's middle, left negative.",
            ),
            OutputSpec::scalar("along", "", "0 to 1 along the tile, head to tail."),
        ],
        // `side` and `along` jump at the seam by definition.
        scale_tolerance: 0.1,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        0.5
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let (du, dv) = (ins.row(0, y), ins.row(1, y));
            if let Some(out) = outs.row(LATERAL, y) {
                lateral(du, out);
                for value in out {
                    *value = value.abs();
                }
            }
            if let Some(out) = outs.row(SIDE, y) {
                lateral(du, out);
            }
            if let Some(out) = outs.row(ALONG, y) {
                let v = cx.domain.v(y);
                for (o, dv) in out.iter_mut().zip(dv) {
                    *o = num::fract(v + dv);
                }
            }
        }
    }
}

multiversion! {
    fn lateral(du: &[f32], out: &mut [f32]) {
        let texel = 1.0 / out.len() as f32;
        for (i, (o, du)) in out.iter_mut().zip(du).enumerate() {
            *o = 2.0 * num::wrap_half((i as f32 + 0.5) * texel + du - 0.5);
        }
    }
}
