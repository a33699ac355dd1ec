//! A constant.

use std::ops::Range;

use crate::node::{Category, Cx, Fallback, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// The same value everywhere: a number or a colour. Kept as one texel by the planner.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Constant {}

impl Operation for Constant {
    const SPEC: Spec = Spec {
        name: "constant",
        category: Category::Generate,
        summary: "The same value everywhere: a number or a colour.",
        inputs: &[InputSpec::image("value", "The value: a number or a colour \"#rrggbb\".")
            .or(Fallback::Scalar(0.0))],
        outputs: &[OutputSpec::same("value", "The value.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.1
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            outs.only(y).copy_from_slice(ins.row(0, y));
        }
    }
}
