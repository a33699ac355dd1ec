//! Channels of a colour.

use std::ops::Range;

use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// The channels of a colour (or vector), as three scalars.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Split {}

impl Operation for Split {
    const SPEC: Spec = Spec {
        name: "split",
        category: Category::Color,
        summary: "Takes a colour apart into its channels.",
        inputs: &[InputSpec::color("color", "The colour, linear RGB, or a vector.")],
        outputs: &[
            OutputSpec::scalar("r", "", "Red, or x."),
            OutputSpec::scalar("g", "", "Green, or y."),
            OutputSpec::scalar("b", "", "Blue, or z."),
        ],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.8
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            for (k, lane) in ins.color_row(0, y).into_iter().enumerate() {
                if let Some(out) = outs.row(k, y) {
                    out.copy_from_slice(lane);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::color::texel;

    #[test]
    fn the_channels_come_out_in_order() {
        assert_eq!(texel(&Split::default(), 0, &[&[1.0, -2.0, 3.0]]), [1.0, -2.0, 3.0]);
    }
}
