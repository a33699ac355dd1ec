//! Stripes and bands by period.

use std::ops::Range;

use super::shape;
use crate::base::num;
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Parallel bands, a whole number of them in the tile.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Stripes {
    /// Bands in the tile; 0 is one band without borders.
    #[schemars(range(min = 0, max = 4096))]
    pub count: u32,
    /// Which way the bands follow each other.
    pub direction: Direction,
    /// Bands by which a band has climbed when it comes round to itself; makes spirals and slanted bands.
    #[schemars(range(min = -4096, max = 4096))]
    pub slant: i32,
    /// Width of the edges from 0 to 1, as a fraction of the period; 0 is as sharp as the texels allow.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub softness: f32,
}

/// Which way bands follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Around the body: longitudinal stripes.
    U,
    /// Along the body: rings and cross bands.
    V,
}

impl Default for Stripes {
    fn default() -> Self {
        Self { count: 8, direction: Direction::V, slant: 0, softness: 0.0 }
    }
}

impl Stripes {
    /// Bands that do not join up with each other across the seams: all of them, or fewer where they are slanted.
    fn bands(&self) -> u32 {
        let (mut a, mut b) = (self.count, self.slant.unsigned_abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a.max(1)
    }

    /// Periods per tile in u and v.
    fn periods(&self) -> [f32; 2] {
        let (count, slant) = (self.count as f32, self.slant as f32);
        match self.direction {
            Direction::U => [count, slant],
            Direction::V => [slant, count],
        }
    }
}

const DUTY: usize = 0;
const OFFSET: usize = 1;
const DU: usize = 2;

impl Operation for Stripes {
    const SPEC: Spec = Spec {
        name: "stripes",
        summary: "Stripes or bands, a whole number in the tile, straight or slanted.",
        inputs: &[
            InputSpec::drive(
                "duty",
                0.5,
                (0.0, 1.0),
                "",
                "Part of the period that a band takes: 0 none, 1 everything.",
            ),
            InputSpec::drive("offset", 0.0, (-1.0, 1.0), "period", "Moves the bands; 1 is a whole period."),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[
            OutputSpec::scalar(
                "mask",
                "",
                "Coverage by bands, 1 inside, exact for bands thinner than a texel.",
            ),
            OutputSpec::scalar("distance", "mm", "Distance to the nearest edge of a band, positive inside."),
            OutputSpec::scalar("phase", "", "Place in the period, 0 to 1; the band lies in the middle."),
            OutputSpec::scalar(
                "index",
                "",
                "Number of the band from 0; bands that join up across a seam have one number.",
            ),
        ],
        // The phase jumps from 1 to 0, sharp at every size.
        scale_tolerance: 0.08,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        3.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let n = domain.width;
        let periods = self.periods();
        // Periods per mm across the bands, and per texel; a tile without periods is one period per tile.
        let slope = [periods[0] / domain.girth_mm, periods[1] / domain.length_mm];
        let per_mm = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        let period_mm = if per_mm > 0.0 { 1.0 / per_mm } else { domain.shorter_mm() };
        let texel = domain.texel_mm() * per_mm;
        let edge = texel.max(self.softness).max(1e-6);
        let mut buffers: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; n]);
        let [u, v, phase] = &mut buffers;
        for row in rows {
            shape::place(ins.row(DU, row), 0.0, 1.0 / n as f32, 0.5, 1.0, u);
            shape::place(ins.row(DU + 1, row), domain.v(row), 0.0, 0.5, 1.0, v);
            let (duty, offset) = (ins.row(DUTY, row), ins.row(OFFSET, row));
            phases(u, v, offset, periods, phase);
            if let Some(mask) = outs.row(0, row) {
                cover(phase, duty, edge, mask);
            }
            if let Some(distance) = outs.row(1, row) {
                distances(phase, duty, period_mm, distance);
            }
            if let Some(out) = outs.row(2, row) {
                for (out, phase) in out.iter_mut().zip(phase.iter()) {
                    *out = num::fract(*phase).min(1.0);
                }
            }
            if let Some(out) = outs.row(3, row) {
                let count = self.bands() as f32;
                for (out, phase) in out.iter_mut().zip(phase.iter()) {
                    let band = phase.floor();
                    *out = (band - (band / count).floor() * count).max(0.0).min(count - 1.0);
                }
            }
        }
    }
}

multiversion! {
    /// Periods passed since u = v = 0; u and v come as distance to the tile's middle.
    fn phases(u: &[f32], v: &[f32], offset: &[f32], periods: [f32; 2], out: &mut [f32]) {
        for (((out, u), v), offset) in out.iter_mut().zip(u).zip(v).zip(offset) {
            let moved = num::wrap_half(*offset);
            *out = (u + 0.5) * periods[0] + (v + 0.5) * periods[1] - moved;
        }
    }
}

/// Integral from 0 to `x` of a train of pulses of width `duty` in the middle of each period.
#[inline(always)]
fn integral(x: f32, duty: f32) -> f32 {
    let whole = x.floor();
    whole * duty + (x - whole - 0.5 * (1.0 - duty)).max(0.0).min(duty)
}

multiversion! {
    /// Mean of the pulses over `edge` periods: the exact coverage of an edge of any width.
    fn cover(phase: &[f32], duty: &[f32], edge: f32, out: &mut [f32]) {
        for ((out, phase), duty) in out.iter_mut().zip(phase).zip(duty) {
            let (x, duty) = (num::fract(*phase), num::saturate(*duty));
            *out = num::saturate((integral(x + 0.5 * edge, duty) - integral(x - 0.5 * edge, duty)) / edge);
        }
    }
}

multiversion! {
    fn distances(phase: &[f32], duty: &[f32], period_mm: f32, out: &mut [f32]) {
        for ((out, phase), duty) in out.iter_mut().zip(phase).zip(duty) {
            let from_middle = (num::fract(*phase) - 0.5).abs();
            *out = (0.5 * num::saturate(*duty) - from_middle) * period_mm;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(node: &Stripes, side: usize, duty: f32) -> Vec<crate::base::Plane> {
        run_node(node, &Domain::square(side), 1, &[Input::Value(duty)], &Assets::new(), 0)
    }

    #[test]
    fn the_mean_is_the_duty_even_where_periods_are_thinner_than_texels() {
        for (count, side) in [(3, 64), (8, 64), (100, 64), (64, 64), (5, 1)] {
            for slant in [0, 2] {
                let node = Stripes { count, slant, ..Stripes::default() };
                let mean = num::mean(run(&node, side, 0.3)[0].data());
                assert!((mean - 0.3).abs() < 0.025, "{count} {side} {slant}: {mean}");
            }
        }
    }

    #[test]
    fn bands_have_their_width_in_mm_and_their_number() {
        let node = Stripes { count: 4, direction: Direction::U, ..Stripes::default() };
        let out = run(&node, 256, 0.5);
        // 100 mm / 4 bands: the middle of a band is 6.25 mm from its edges.
        assert!((num::min_max(out[1].data()).1 - 6.25).abs() < 0.3);
        assert_eq!(num::min_max(out[3].data()), (0.0, 3.0));
        assert_eq!(out[0].at(32, 5), 1.0);
        assert_eq!(out[0].at(0, 5), 0.0);
    }

    #[test]
    fn a_whole_tile_of_offset_changes_nothing() {
        let node = Stripes { count: 3, slant: 1, ..Stripes::default() };
        let domain = Domain::square(48);
        let run = |du: f32| {
            let ins = [Input::Value(0.4), Input::Value(0.0), Input::Value(du)];
            run_node(&node, &domain, 1, &ins, &Assets::new(), 0)[0].clone()
        };
        let (zero, one, half) = (run(0.0), run(1.0), run(0.5));
        let differ = |a: &crate::base::Plane, b: &crate::base::Plane| {
            a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(differ(&zero, &one) < 1e-4);
        assert!(differ(&zero, &half) > 0.5);
        assert!(differ(&zero.shifted(-24, 0), &half) < 1e-4);
    }
}
