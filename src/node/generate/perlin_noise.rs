//! Perlin's gradient noise.

use std::ops::Range;

use super::lattice::{Cells, Coords, Perlin, PerlinRow};
use super::to_unit;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Prepared, Spec};

/// Random hills and hollows of even size: Perlin's gradient noise (2002), `0.5 + 0.5 n`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PerlinNoise {
    /// Cells around the body: more makes the noise finer. 4 to 64 are usual.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells along the body. For round features choose it so that a cell is as long as it is wide.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
}

impl Default for PerlinNoise {
    fn default() -> Self {
        Self { cells_u: 8, cells_v: 8 }
    }
}

impl Operation for PerlinNoise {
    const SPEC: Spec = Spec {
        name: "perlin_noise",
        summary: "Random hills and hollows of even size: Perlin's gradient noise.",
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
        2.0
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(Perlin::new(Cells::new(self.cells_u, self.cells_v, cx.seed))))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let noise: &Perlin = cx.prepared();
        let mut at = Coords::new(cx.domain.width);
        let mut kept = PerlinRow::default();
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            let out = outs.only(y);
            noise.sample(&at.all(), &mut kept, out);
            to_unit(out);
        }
    }
}
