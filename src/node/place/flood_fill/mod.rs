//! Flood fill: every closed area of a mask by itself.

mod components;
#[cfg(test)]
mod tests;

use std::ops::Range;

use rayon::prelude::*;

use crate::base::Domain;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Finds every connected area of a mask, over the seams too, and says of each texel which area it is in and where.
///
/// Its outputs feed `flood_fill_random` and `flood_fill_gradient`. Areas are ordered, and their random numbers drawn,
/// by their coarse place and size, so that another grid size gives (nearly) all of them the same.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloodFill {
    /// Texels of at least this value are inside.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub threshold: f32,
    /// Which neighbours belong together.
    pub connectivity: Connectivity,
}

/// Which neighbours of a texel belong to its area.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Connectivity {
    /// The four that share a side: a line one texel wide parts areas even where it runs diagonally.
    #[default]
    Four,
    /// Also the four that share a corner.
    Eight,
}

impl Default for FloodFill {
    fn default() -> Self {
        Self { threshold: 0.5, connectivity: Connectivity::Four }
    }
}

/// Outputs.
const COUNT: usize = 9;

impl Operation for FloodFill {
    const SPEC: Spec = Spec {
        name: "flood_fill",
        category: Category::Place,
        summary: "Finds every connected area of a mask: a random number, number, place and size for each.",
        inputs: &[InputSpec::plane("mask", "", "Areas are where it is high, parted by where it is low.")],
        outputs: &[
            OutputSpec::scalar("id", "", "A random number in (0, 1] for each area, 0 outside."),
            OutputSpec::scalar("index", "", "1 + the area's number, from v = 0 on; 0 outside."),
            OutputSpec::scalar("s", "", "Place in the box around the area, around the body, 0 to 1."),
            OutputSpec::scalar("t", "", "Place in the box around the area, along the body, 0 to 1."),
            OutputSpec::scalar("size_u", "tile", "Width of the box; 1 where the area goes round the tile."),
            OutputSpec::scalar("size_v", "tile", "Height of the box; 1 where the area goes round the tile."),
            OutputSpec::scalar("center_u", "tile", "The area's centre of mass around the body, 0 to 1."),
            OutputSpec::scalar("center_v", "tile", "The area's centre of mass along the body, 0 to 1."),
            OutputSpec::scalar("area", "mm²", "How large the area is."),
        ],
        random: true,
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        8.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let (width, height) = (domain.width, domain.height);
        debug_assert_eq!(rows, 0..height as i64, "a whole node gets all rows");
        let diagonal = self.connectivity == Connectivity::Eight;
        let mut runs = components::Runs::new(ins.scalar(0), height, self.threshold, diagonal);
        let (areas, owners) = runs.areas(width, height, cx.seed);
        let texel_mm2 = domain.texel_u_mm() * domain.texel_v_mm();

        let mut parts: Vec<[Option<&mut [f32]>; COUNT]> =
            (0..height).map(|_| [const { None }; COUNT]).collect();
        for (k, lane) in outs.bands().iter_mut().enumerate() {
            if let Some(lane) = lane {
                for (part, row) in parts.iter_mut().zip(lane.chunks_mut(width)) {
                    part[k] = Some(row);
                }
            }
        }
        parts.into_par_iter().enumerate().for_each(|(y, mut lanes)| {
            lanes.iter_mut().flatten().for_each(|lane| lane.fill(0.0));
            for i in runs.row(y) {
                let (number, tiles) = owners[i];
                let area = &areas[number as usize];
                let span = runs.span(i);
                let inside = |axis: usize, at: usize, n: usize| {
                    let place = (at as f64 + 0.5) / n as f64;
                    let place = if area.winds[axis] {
                        (place - area.corner[axis]).rem_euclid(1.0)
                    } else {
                        (place + f64::from(tiles[axis]) - area.corner[axis]) / area.size[axis]
                    };
                    place as f32
                };
                if let Some(s) = &mut lanes[2] {
                    span.clone().for_each(|x| s[x] = inside(0, x, width));
                }
                let flat = [
                    (0, area.id),
                    (1, (number + 1) as f32),
                    (3, inside(1, y, height)),
                    (4, area.size[0] as f32),
                    (5, area.size[1] as f32),
                    (6, area.center[0] as f32),
                    (7, area.center[1] as f32),
                    (8, area.texels as f32 * texel_mm2),
                ];
                for (k, value) in flat {
                    if let Some(lane) = &mut lanes[k] {
                        lane[span.clone()].fill(value);
                    }
                }
            }
        });
    }
}
