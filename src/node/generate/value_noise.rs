//! Value noise.

use std::ops::Range;

use super::lattice::{Cells, Coords, value};
use super::to_unit;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Soft random blotches with a visible grid: random values at lattice points, joined by a quintic fade.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ValueNoise {
    /// Cells around the body: more makes the noise finer. 4 to 64 are usual.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells along the body. For round features choose it so that a cell is as long as it is wide.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
}

impl Default for ValueNoise {
    fn default() -> Self {
        Self { cells_u: 8, cells_v: 8 }
    }
}

impl Operation for ValueNoise {
    const SPEC: Spec = Spec {
        name: "value_noise",
        summary: "Soft random blotches: random values on a grid, joined smoothly.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar("value", "", "The noise, in [0, 1), mean 0.5.")],
        random: true,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        1.5
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let cells = Cells::new(self.cells_u, self.cells_v, cx.seed);
        let mut at = Coords::new(cx.domain.width);
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            let out = outs.only(y);
            value(&at.all(), cells, out);
            to_unit(out);
        }
    }
}
