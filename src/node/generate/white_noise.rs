//! White noise of cells.

use std::ops::Range;

use super::lattice::{Cells, Coords, white};
use super::to_unit;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A grid of flat cells, each with a random grey of its own: grain.
///
/// The cells belong to the tile, not to the map's texels, so the grain keeps its size at every resolution; a map
/// with fewer texels than cells shows a sample of them.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WhiteNoise {
    /// Cells around the body: 256 and more make grain, few make a chequer of greys.
    #[schemars(range(min = 1, max = 65536))]
    pub cells_u: u32,
    /// Cells along the body.
    #[schemars(range(min = 1, max = 65536))]
    pub cells_v: u32,
}

impl Default for WhiteNoise {
    fn default() -> Self {
        Self { cells_u: 64, cells_v: 64 }
    }
}

impl Operation for WhiteNoise {
    const SPEC: Spec = Spec {
        name: "white_noise",
        summary: "Grain: a grid of cells, each with a random grey of its own.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar("value", "", "The cell's value, uniform in [0, 1).")],
        random: true,
        // A cell may be as small as a texel of a coarse grid.
        scale_tolerance: 0.12,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        0.8
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let cells = Cells::new(self.cells_u, self.cells_v, cx.seed);
        let mut at = Coords::new(cx.domain.width);
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            let out = outs.only(y);
            white(&at.all(), cells, out);
            to_unit(out);
        }
    }
}
