//! One of eight.

use std::ops::Range;

use crate::node::{Category, Cx, Fallback, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Passes one of its inputs on. The others are not evaluated at all.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Switch {
    /// Which input shows: 0 is `a`, 1 is `b`, up to 7, `h`.
    #[schemars(range(min = 0, max = 7), extend("x-unit" = ""))]
    pub select: u8,
}

/// An input that may stay unset: then it is 0.
const fn option(name: &'static str, doc: &'static str) -> InputSpec {
    InputSpec::image(name, doc).or(Fallback::Scalar(0.0))
}

impl Switch {
    /// The input that shows; a selection beyond the last (refused when a preset is read) shows the last.
    fn selected(&self) -> usize {
        usize::from(self.select).min(Self::SPEC.inputs.len() - 1)
    }
}

impl Operation for Switch {
    const SPEC: Spec = Spec {
        name: "switch",
        category: Category::Combine,
        summary: "Passes one of up to eight images on; the others cost nothing.",
        inputs: &[
            option("a", "Shown where `select` is 0."),
            option("b", "Shown where `select` is 1."),
            option("c", "Shown where `select` is 2."),
            option("d", "Shown where `select` is 3."),
            option("e", "Shown where `select` is 4."),
            option("f", "Shown where `select` is 5."),
            option("g", "Shown where `select` is 6."),
            option("h", "Shown where `select` is 7."),
        ],
        outputs: &[OutputSpec::same("result", "The selected image.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        0.1
    }

    fn forwards(&self) -> Option<usize> {
        Some(self.selected())
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            outs.only(y).copy_from_slice(ins.row(self.selected(), y));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_passes_the_selected_input_and_says_so() {
        let inputs: Vec<f32> = (0..8).map(|i| 10.0 + i as f32).collect();
        for select in 0..8 {
            let node = Switch { select };
            assert_eq!(texel(&node, &inputs), 10.0 + f32::from(select));
            assert_eq!(Operation::forwards(&node), Some(usize::from(select)));
        }
        assert_eq!(texel(&Switch { select: 5 }, &[1.0]), 0.0);
        assert_eq!(texel(&Switch { select: 200 }, &inputs), 17.0);
    }
}
