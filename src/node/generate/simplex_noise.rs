//! Simplex-type gradient noise that tiles.

use std::ops::Range;

use super::lattice::{Cells, Coords, Shear, simplex};
use super::to_unit;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Random hills and hollows with less of a grid than Perlin's: gradient noise on a lattice of triangles.
///
/// Each row of the lattice is moved by half a cell against the one before. An odd `cells_v` moves them by
/// (n - 1) / 2n cells instead, so that the tile always closes: prefer even counts below 8.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimplexNoise {
    /// Cells around the body: more makes the noise finer. 4 to 64 are usual.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells along the body. For round features choose it so that a cell is as long as it is wide.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
}

impl Default for SimplexNoise {
    fn default() -> Self {
        Self { cells_u: 8, cells_v: 8 }
    }
}

impl Operation for SimplexNoise {
    const SPEC: Spec = Spec {
        name: "simplex_noise",
        summary: "Random hills and hollows without a square grid: gradient noise on triangles.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar(
            "value",
            "",
            "The noise, in [0, 1], mean 0.5, and 0.5 at lattice points.",
        )],
        random: true,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        2.5
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let cells = Cells::new(self.cells_u, self.cells_v, cx.seed);
        let shear = Shear::new(cells.v);
        let mut at = Coords::new(cx.domain.width);
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            let out = outs.only(y);
            simplex(&at.all(), cells, shear, out);
            to_unit(out);
        }
    }
}
