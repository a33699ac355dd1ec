//! A series of marks along the body: saddles, blotches, diamonds, ocelli, rings.

use std::ops::Range;

use crate::base::{hash, num};
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

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
        }
    }
}

const DISTORT: usize = 0;
const DU: usize = 1;
const DV: usize = 2;
const DISTANCE: usize = 0;
const RANDOM: usize = 1;

/// Hash channels.
const SHIFT: u32 = 1;
const SIZE: u32 = 2;
const SLIP: u32 = 3;
const VALUE: u32 = 4;

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
            OutputSpec::scalar("random", "", "A random number of the nearest mark, in [0, 1)."),
        ],
        random: true,
        scale_tolerance: 0.1,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        if self.sides == Sides::Middle { 12.0 } else { 24.0 }
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let series = Series::new(self, cx);
        let kernel = if self.shape == MarkShape::Ellipse { ellipses } else { quads };
        let mut random = vec![0.0; outs.width()];
        let mut distance = vec![0.0; outs.width()];
        for y in rows {
            let v = cx.domain.v(y);
            distance.fill(-1e6);
            random.fill(0.0);
            for side in 0..series.sides {
                kernel(&series, side, v, ins.row(DU, y), ins.row(DV, y), &mut distance, &mut random);
            }
            if let Some(out) = outs.row(DISTANCE, y) {
                for ((o, d), push) in out.iter_mut().zip(&distance).zip(ins.row(DISTORT, y)) {
                    *o = (d + push).max(-1e9).min(1e9);
                }
            }
            if let Some(out) = outs.row(RANDOM, y) {
                out.copy_from_slice(&random);
            }
        }
    }
}

/// A series with every length in mm.
#[derive(Clone, Copy)]
struct Series {
    seed: u32,
    count: f32,
    period_mm: f32,
    girth_mm: f32,
    sides: u32,
    stagger: f32,
    position_mm: f32,
    half_width: f32,
    half_length: f32,
    taper: f32,
    chevron: f32,
    roundness: f32,
    offset: f32,
    jitter: f32,
    jitter_size: f32,
    slip: f32,
    /// 1 / the width over which the slip sets in, 1/mm.
    per_slip: f32,
    blend_mm: f32,
    texel_u: f32,
}

impl Series {
    fn new(marks: &Marks, cx: &Cx<'_>) -> Self {
        let domain = &cx.domain;
        let period_mm = domain.length_mm / marks.count as f32;
        let flank_mm = 0.5 * domain.girth_mm * (1.0 - marks.belly);
        Self {
            seed: cx.seed,
            count: marks.count as f32,
            period_mm,
            girth_mm: domain.girth_mm,
            sides: if marks.sides == Sides::Middle { 1 } else { 2 },
            stagger: if marks.sides == Sides::Alternate { 0.5 } else { 0.0 },
            position_mm: if marks.sides == Sides::Middle { 0.0 } else { marks.position * flank_mm },
            half_width: (marks.reach * flank_mm).max(1e-6),
            half_length: (0.5 * marks.length * period_mm).max(1e-6),
            taper: marks.taper,
            chevron: marks.chevron,
            roundness: marks.roundness,
            offset: marks.offset,
            jitter: marks.jitter,
            jitter_size: marks.jitter_size,
            slip: marks.slip,
            per_slip: 1.0 / (0.8 * marks.reach * flank_mm).max(1e-6),
            blend_mm: marks.blend * period_mm,
            texel_u: 1.0 / domain.width as f32,
        }
    }
}

/// Distance to one four-sided mark's outline at (`x` >= 0, `y`) from its centre, mm, positive inside.
///
/// It is bounded by its ends (|x| = half width) and by sides that lean by the taper; distances to those lines are exact,
/// corners are rounded by a smooth minimum.
#[inline(always)]
fn quad(s: &Series, x: f32, y: f32, hx: f32, hy: f32) -> f32 {
    let lean = hy * (s.taper - 1.0) / hx;
    let side = (hy + lean * x.min(hx) - y.abs()) / (1.0 + lean * lean).sqrt();
    num::smooth_min(hx - x, side, 2.0 * s.roundness * hx.min(hy))
}

/// Distance to one ellipse's outline: r (1 - r) / |grad r|, exact to first order at the outline.
#[inline(always)]
fn ellipse(_: &Series, x: f32, y: f32, hx: f32, hy: f32) -> f32 {
    let (nx, ny) = (x / hx, y / hy);
    let r = (nx * nx + ny * ny).sqrt();
    let (gx, gy) = (nx / hx, ny / hy);
    let d = (r * (1.0 - r) / (gx * gx + gy * gy).sqrt().max(1e-12)).max(-1e6);
    if r > 1e-3 { d } else { hx.min(hy) }
}

macro_rules! kernel {
    ($(#[$doc:meta])* $name:ident, $mark:ident) => {
        multiversion! {
            $(#[$doc])*
            fn $name(
                s: &Series,
                side: u32,
                v: f32,
                du: &[f32],
                dv: &[f32],
                distance: &mut [f32],
                random: &mut [f32],
            ) {
                let n = distance.len();
                let (du, dv, random) = (&du[..n], &dv[..n], &mut random[..n]);
                let mirror = if side == 1 { -1.0 } else { 1.0 };
                // On the mid-back the slip moves the left half only, sheared across the mark's middle.
                let slip = if s.sides == 1 { s.slip } else { 0.0 };
                let offset = s.offset + s.stagger * side as f32;
                for i in 0..n {
                    let u = (i as f32 + 0.5) * s.texel_u + du[i];
                    let x = num::wrap_half(u - 0.5) * s.girth_mm;
                    let p = num::fract(v + dv[i]) * s.count - offset;
                    let nearest = p.floor();
                    // Around the body the mark's centre is met both ways.
                    let across = (num::wrap_half((x * mirror - s.position_mm) / s.girth_mm) * s.girth_mm).abs();
                    let left = slip * num::saturate(0.5 - x * s.per_slip);
                    let (mut best, mut value) = (distance[i], random[i]);
                    for step in [-1.0f32, 0.0, 1.0] {
                        let k = nearest + step;
                        // The mark's number, modulo the count; whole numbers below 2^24 are exact.
                        let cell = k - s.count * (k / s.count).floor();
                        let h = hash::hash2(s.seed, cell as i32 as u32, side);
                        let shift = s.jitter * hash::signed(hash::hash1(h, SHIFT));
                        let size = 1.0 + s.jitter_size * hash::signed(hash::hash1(h, SIZE));
                        let slipped = left * hash::signed(hash::hash1(h, SLIP));
                        let (hx, hy) = (s.half_width * size, s.half_length * size);
                        let along = (p - k - 0.5 - shift - slipped) * s.period_mm;
                        let bend = s.chevron * 2.0 * hy * (across / hx).min(1.0);
                        let d = $mark(s, across, along - bend, hx, hy);
                        value = if d > best { hash::unit(hash::hash1(h, VALUE)) } else { value };
                        best = num::smooth_max(best, d, s.blend_mm);
                    }
                    distance[i] = best;
                    random[i] = value;
                }
            }
        }
    };
}

kernel! {
    /// Lay one side's four-sided marks over the distances so far.
    quads, quad
}

kernel! {
    /// Lay one side's ellipses over the distances so far.
    ellipses, ellipse
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
}
