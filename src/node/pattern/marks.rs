//! A series of marks along the body: saddles, blotches, diamonds, ocelli, rings.

mod lay;
mod series;

use std::ops::Range;

use self::lay::{Places, ellipses, find, padded, push, quads};
use self::series::Series;
use crate::base::kept::Kept;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Prepared, Spec};

/// Outline of a mark.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MarkShape {
    /// Four-sided; `taper` makes it a rectangle, a rhomb, a saddle or an hourglass.
    #[default]
    Quad,
    /// An ellipse.
    Ellipse,
}

/// Which side of the mid-back the marks lie on.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// One series on the mid-back.
    #[default]
    Middle,
    /// A series on each side, mirrored.
    Both,
    /// A series on each side, half a period apart.
    Alternate,
}

/// A series of marks along the body, evenly spaced but for jitter, on the mid-back or on both sides.
///
/// Lateral lengths are in flanks: 0 is the mid-back, 1 the edge of the belly scutes; above 1 lies the belly. Lengths
/// along the body are shares of the period, the tile's length over `count`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Marks {
    /// Marks along the tile, on one side.
    #[schemars(range(min = 1, max = 10_000))]
    pub count: u32,
    /// Outline of a mark.
    pub shape: MarkShape,
    /// On the mid-back, on both sides, or in turn.
    pub sides: Sides,
    /// Where the series lies, from the mid-back; only for `both` and `alternate`.
    #[schemars(range(min = 0.0, max = 3.0), extend("x-unit" = "flank"))]
    pub position: f32,
    /// How far a mark reaches to each side of its centre. 3 goes all the way round: a ring.
    #[schemars(range(min = 0.0, max = 4.0), extend("x-unit" = "flank"))]
    pub reach: f32,
    /// Length of a mark along the body. 0.5 leaves gaps as long as the marks.
    #[schemars(range(min = 0.0, max = 3.0), extend("x-unit" = "period"))]
    pub length: f32,
    /// Length at the far end against the middle: 1 rectangle, 0 rhomb, 0.5 saddle, above 1 hourglass.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub taper: f32,
    /// Bends the mark into a V: its ends lie so far tail-ward (or head-ward).
    #[schemars(range(min = -4.0, max = 4.0), extend("x-unit" = "lengths"))]
    pub chevron: f32,
    /// Rounding of corners: 0 sharp, 1 round.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roundness: f32,
    /// Moves the series along the body.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "period"))]
    pub offset: f32,
    /// Random shift of each mark along the body, plus or minus. 0.1 is natural.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "period"))]
    pub jitter: f32,
    /// Random size of each mark, plus or minus.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub jitter_size: f32,
    /// Random shift of a mark's left half against its right.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "period"))]
    pub slip: f32,
    /// Neighbouring marks melt together over this distance; 0 keeps them apart.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "period"))]
    pub blend: f32,
    /// Share of the girth that the belly scutes span: what a flank is measured from.
    #[schemars(range(min = 0.0, max = 0.8))]
    pub belly: f32,
    /// Outside the marks distances end here: what is farther away costs little.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-unit" = "mm"))]
    pub farthest: f32,
}

impl Default for Marks {
    fn default() -> Self {
        Self {
            count: 4,
            shape: MarkShape::Quad,
            sides: Sides::Middle,
            position: 0.5,
            reach: 0.5,
            length: 0.5,
            taper: 1.0,
            chevron: 0.0,
            roundness: 0.3,
            offset: 0.0,
            jitter: 0.05,
            jitter_size: 0.08,
            slip: 0.0,
            blend: 0.0,
            belly: 0.3,
            farthest: 1e6,
        }
    }
}

const DISTORT: usize = 0;
const DU: usize = 1;
const DV: usize = 2;
const DISTANCE: usize = 0;
const RANDOM: usize = 1;

impl Operation for Marks {
    const SPEC: Spec = Spec {
        name: "marks",
        category: Category::Pattern,
        summary: "A series of marks along the body: saddles, blotches, diamonds, ocelli or rings.",
        inputs: &[
            InputSpec::drive(
                "distort",
                0.0,
                (-1e6, 1e6),
                "mm",
                "Pushes the outline outward where positive: wire noise for ragged edges.",
            ),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[
            OutputSpec::scalar("distance", "mm", "Distance to the nearest mark's outline, positive inside."),
            OutputSpec::scalar(
                "random",
                "",
                "A random number of the nearest mark, in [0, 1); 0 beyond `farthest`.",
            ),
        ],
        random: true,
        scale_tolerance: 0.1,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        if self.sides == Sides::Middle { 12.0 } else { 24.0 }
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(Laid { series: Series::new(self, cx), room: Kept::new() }))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let Laid { series, room } = cx.prepared();
        let kernel = if self.shape == MarkShape::Ellipse { ellipses } else { quads };
        let row = |y: i64, outs: &mut Outputs<'_>, Room { place, distance, random }: &mut Room| {
            let v = cx.domain.v(y);
            distance.fill(-self.farthest);
            random.fill(0.0);
            for side in &series.sides {
                find(series, side, v, ins.row(DU, y), ins.row(DV, y), place);
                kernel(series, side, place, distance, random);
            }
            if let Some(out) = outs.row(DISTANCE, y) {
                push(distance, ins.row(DISTORT, y), out);
            }
            if let Some(out) = outs.row(RANDOM, y) {
                out.copy_from_slice(&random[..out.len()]);
            }
        };
        room.lend(|| Room::new(cx.domain.width), |room| rows.for_each(|y| row(y, outs, room)));
    }
}

/// What all bands share.
struct Laid {
    series: Series,
    room: Kept<Room>,
}

/// What a row of texels takes.
struct Room {
    place: Places,
    distance: Vec<f32>,
    random: Vec<f32>,
}

impl Room {
    fn new(width: usize) -> Self {
        Self {
            place: Places::new(width),
            distance: vec![0.0; padded(width)],
            random: vec![0.0; padded(width)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::eval::run_node;

    fn still() -> Marks {
        Marks { jitter: 0.0, jitter_size: 0.0, roundness: 0.0, ..Marks::default() }
    }

    #[test]
    fn a_rectangular_mark_has_the_area_its_settings_say() {
        // 4 marks, each 0.5 flank to both sides of 0.7 girth and half a period long: 0.5 * 0.7 * 0.5 of the tile.
        let planes = run_node(&still(), &Domain::square(400), 1, &[], &Default::default(), 0);
        let inside = planes[0].data().iter().filter(|&&d| d > 0.0).count() as f32 / 160_000.0;
        assert!((inside - 0.175).abs() < 0.005, "{inside}");
    }

    #[test]
    fn an_ellipse_is_pi_over_four_of_its_rectangle() {
        let marks = Marks { shape: MarkShape::Ellipse, ..still() };
        let planes = run_node(&marks, &Domain::square(400), 1, &[], &Default::default(), 0);
        let inside = planes[0].data().iter().filter(|&&d| d > 0.0).count() as f32 / 160_000.0;
        assert!((inside - 0.175 * std::f32::consts::FRAC_PI_4).abs() < 0.004, "{inside}");
    }

    #[test]
    fn sides_mirror_about_the_mid_back() {
        let marks = Marks { sides: Sides::Both, jitter: 0.0, jitter_size: 0.0, ..Marks::default() };
        let p = &run_node(&marks, &Domain::square(64), 1, &[], &Default::default(), 0)[0];
        for y in 0..64 {
            for x in 0..64 {
                assert!((p.at(x, y) - p.at(63 - x, y)).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn distances_end_at_the_farthest_and_are_the_same_before() {
        let domain = Domain::square(97);
        for shape in [MarkShape::Quad, MarkShape::Ellipse] {
            let all = Marks { shape, reach: 0.2, length: 0.3, sides: Sides::Both, ..Marks::default() };
            let near = Marks { farthest: 3.0, ..all.clone() };
            let run = |marks: &Marks| run_node(marks, &domain, 1, &[], &Default::default(), 0).remove(0);
            let (all, near) = (run(&all), run(&near));
            assert!(all.data().iter().any(|d| *d < -10.0) && all.data().iter().any(|d| *d > 0.0));
            for (a, n) in all.data().iter().zip(near.data()) {
                assert_eq!(*n, a.max(-3.0));
            }
        }
    }
}
