//! A colour from channels.

use std::ops::Range;

use crate::node::{Category, Cx, Fallback, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A colour (or vector) from three scalars; what is not set is 0.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Merge {}

/// A channel that may stay unset.
const fn channel(name: &'static str, doc: &'static str) -> InputSpec {
    InputSpec::plane(name, "", doc).or(Fallback::Scalar(0.0))
}

impl Operation for Merge {
    const SPEC: Spec = Spec {
        name: "merge",
        category: Category::Color,
        summary: "Puts a colour together from its channels.",
        inputs: &[channel("r", "Red, or x."), channel("g", "Green, or y."), channel("b", "Blue, or z.")],
        outputs: &[OutputSpec::color("color", "The colour, linear RGB, or a vector.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.8
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let Some(lanes) = outs.color_row(0, y) else { return };
            for (k, out) in lanes.into_iter().enumerate() {
                out.copy_from_slice(ins.row(k, y));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::color::texel;

    #[test]
    fn channels_go_in_in_order_and_an_unset_one_is_0() {
        assert_eq!(texel(&Merge::default(), 0, &[&[1.0], &[-2.0], &[3.0]]), [1.0, -2.0, 3.0]);
        assert_eq!(texel(&Merge::default(), 0, &[&[1.0]]), [1.0, 0.0, 0.0]);
    }
}
