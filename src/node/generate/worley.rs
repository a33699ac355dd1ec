//! Cellular noise.

use std::ops::Range;

use super::lattice::{Bands, Cells, Coords, Metric, worley};
use crate::base::num;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Irregular cells, like granules of skin: distances to one random point per cell of a grid.
///
/// Distances are in cells, exact for each metric, not clamped. Where cells are longer than wide (in mm), so are the
/// shapes. Source: Worley (1996), with one point per cell, so that no place is crowded.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Worley {
    /// Cells around the body: more makes them smaller.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells along the body. For round cells choose it so that a cell is as long as it is wide.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
    /// Shape of the cells, by the way distance is measured.
    pub metric: Metric,
    /// How irregular: 0 is a square grid, 1 puts a point anywhere in its cell; 0.7 to 1 looks grown.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub jitter: f32,
}

impl Default for Worley {
    fn default() -> Self {
        Self { cells_u: 8, cells_v: 8, metric: Metric::Euclidean, jitter: 1.0 }
    }
}

impl Operation for Worley {
    const SPEC: Spec = Spec {
        name: "worley",
        summary: "Irregular cells: distances to random points, and a random grey per cell.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[
            OutputSpec::scalar(
                "f1",
                "cell",
                "Distance to the nearest point: 0 at it, seldom above 1; at most 1.42 (euclidean), 2 (manhattan), 1 (chebyshev).",
            ),
            OutputSpec::scalar("f2", "cell", "Distance to the second nearest point; at most 2."),
            OutputSpec::scalar(
                "f2_f1",
                "cell",
                "f2 - f1: 0 on the borders of cells, growing inwards; at most 2.",
            ),
            OutputSpec::scalar("cell", "", "A random value per cell, uniform in [0, 1)."),
        ],
        random: true,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        6.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let cells = Cells::new(self.cells_u, self.cells_v, cx.seed);
        let jitter = num::saturate(self.jitter);
        let width = cx.domain.width;
        let mut at = Coords::new(width);
        let mut bands = outs.bands().iter_mut();
        let mut next = || bands.next().and_then(|lane| lane.as_deref_mut()).unwrap_or_default();
        let (mut f1, mut f2, mut edge, mut id) = (next(), next(), next(), next());
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            let mut row = Bands {
                f1: take_row(&mut f1, width),
                f2: take_row(&mut f2, width),
                edge: take_row(&mut edge, width),
                id: take_row(&mut id, width),
            };
            worley(&at.all(), cells, self.metric, jitter, &mut row);
        }
    }
}

/// The next row of a band; nothing where the band is empty.
fn take_row<'a>(band: &mut &'a mut [f32], width: usize) -> &'a mut [f32] {
    let n = width.min(band.len());
    band.split_off_mut(..n).unwrap_or_default()
}
