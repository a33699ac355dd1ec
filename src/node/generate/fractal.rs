//! Fractal sums of noise.

use std::ops::Range;

use super::lattice::{Bands, Cells, Coords, Metric, Shear, perlin, simplex, value, worley};
use crate::base::{hash, num};
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// The noise that is summed.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Value noise: soft and blotchy.
    Value,
    /// Perlin's gradient noise.
    #[default]
    Perlin,
    /// Gradient noise on triangles: less of a grid.
    Simplex,
    /// Distance to the nearest point, Euclidean, held at 1: round pits.
    WorleyF1,
    /// Distance from the borders of cells (f2 - f1), held at 1: cracks.
    WorleyEdge,
}

/// How the octaves are summed. `n` is an octave's noise, in [-1, 1]; sums are divided by the sum of the gains.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Sum {
    /// `0.5 + 0.5 n`: clouds, mean 0.5.
    #[default]
    Fbm,
    /// `|n|`: lumps parted by sharp dark creases; mean near 0.25 for Perlin. (libnoise calls `2 |n| - 1` billow.)
    Turbulence,
    /// `1 - (1 - |n|)^2`: pillows, rounder than turbulence, with narrow creases; mean near 0.4 for Perlin.
    Billow,
    /// `(1 - |n|)^2`, each octave weighted by the one before: sharp light ridges, smooth valleys (Musgrave 1994).
    Ridged,
}

/// Noise with detail at every size: octaves of a noise, each finer and weaker than the one before.
///
/// Octave k has `round(cells * lacunarity^k)` cells in each direction (65536 at most), so it tiles for any
/// lacunarity, and a seed and a phase of its own. Octaves finer than the map's texels are sampled, not averaged: keep
/// `cells * lacunarity^(octaves - 1)` below the map's size.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fractal {
    /// The noise that is summed.
    pub basis: Basis,
    /// How the octaves are summed.
    pub sum: Sum,
    /// Cells of the first octave around the body: more makes the whole finer.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells of the first octave along the body.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
    /// How many sizes of detail: 1 is the plain noise, 4 to 6 look natural.
    #[schemars(range(min = 1, max = 12))]
    pub octaves: u32,
    /// How much finer each octave is: 2 is usual, slightly odd values such as 1.9 hide the doubling.
    #[schemars(range(min = 1.0, max = 4.0))]
    pub lacunarity: f32,
}

impl Default for Fractal {
    fn default() -> Self {
        Self { basis: Basis::Perlin, sum: Sum::Fbm, cells_u: 4, cells_v: 4, octaves: 5, lacunarity: 2.0 }
    }
}

const GAIN: usize = 0;
const DU: usize = 1;

/// Of Musgrave's feedback: the weight of an octave is the one before times this.
const RIDGED_FEEDBACK: f32 = 2.0;

impl Fractal {
    /// Cells and shear of every octave.
    fn octaves(&self, seed: u32) -> Vec<(Cells, Shear)> {
        // Lacunarity may be anything in a struct made by hand.
        let lacunarity = f64::from(self.lacunarity.max(1.0).min(4.0));
        let mut factor = 1.0f64;
        (0..self.octaves.clamp(1, 12))
            .map(|k| {
                // f64 to u32 saturates.
                let side = |n: u32| (f64::from(n) * factor).round() as u32;
                let cells =
                    Cells::new(side(self.cells_u), side(self.cells_v), hash::hash1(seed, k)).out_of_phase();
                factor *= lacunarity;
                (cells, Shear::new(cells.v))
            })
            .collect()
    }

    /// One octave's signed noise.
    fn octave(&self, at: &Coords, (cells, shear): (Cells, Shear), out: &mut [f32]) {
        let mut bands = Bands { f1: &mut [], f2: &mut [], edge: &mut [], id: &mut [] };
        match self.basis {
            Basis::Value => value(at, cells, out),
            Basis::Perlin => perlin(at, cells, out),
            Basis::Simplex => simplex(at, cells, shear, out),
            Basis::WorleyF1 => {
                bands.f1 = &mut *out;
                worley(at.us(), at.vs(), cells, Metric::Euclidean, 1.0, &mut bands);
                signed_distance(out);
            }
            Basis::WorleyEdge => {
                bands.edge = &mut *out;
                worley(at.us(), at.vs(), cells, Metric::Euclidean, 1.0, &mut bands);
                signed_distance(out);
            }
        }
    }
}

impl Operation for Fractal {
    const SPEC: Spec = Spec {
        name: "fractal",
        summary: "Noise with detail at every size: clouds, creases, pillows or ridges.",
        inputs: &[
            InputSpec::drive(
                "gain",
                0.5,
                (0.0, 1.0),
                "",
                "Strength of each octave against the one before: 0 smooth, 0.5 natural, 0.8 rough.",
            ),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("value", "", "The sum, in [0, 1]; mean 0.5 for fbm.")],
        random: true,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        let octave = match self.basis {
            Basis::Value => 1.5,
            Basis::Perlin => 2.0,
            Basis::Simplex => 2.5,
            Basis::WorleyF1 | Basis::WorleyEdge => 6.0,
        };
        0.5 + self.octaves as f32 * (octave + 0.4)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let octaves = self.octaves(cx.seed);
        let width = cx.domain.width;
        let mut at = Coords::new(width);
        let (mut noise, mut amp, mut total, mut weight) =
            (vec![0.0; width], vec![0.0; width], vec![0.0; width], vec![0.0; width]);
        for y in rows {
            at.set(&cx.domain, ins, DU, y);
            let (gain, out) = (ins.row(GAIN, y), outs.only(y));
            out.fill(0.0);
            amp.fill(1.0);
            total.fill(0.0);
            weight.fill(1.0);
            for &octave in &octaves {
                self.octave(&at, octave, &mut noise);
                add(self.sum, &noise, gain, &mut amp, &mut total, &mut weight, out);
            }
            normalise(&total, out);
        }
    }
}

multiversion! {
    /// A distance in cells to [-1, 1], held at 1.
    fn signed_distance(out: &mut [f32]) {
        for o in out { *o = o.min(1.0) * 2.0 - 1.0; }
    }
}

#[inline(always)]
fn add_octave(
    noise: &[f32],
    gain: &[f32],
    amp: &mut [f32],
    total: &mut [f32],
    out: &mut [f32],
    f: impl Fn(f32, usize) -> f32,
) {
    let n = out.len();
    let (noise, gain, amp, total) = (&noise[..n], &gain[..n], &mut amp[..n], &mut total[..n]);
    for i in 0..n {
        out[i] += amp[i] * f(noise[i], i);
        total[i] += amp[i];
        amp[i] *= num::saturate(gain[i]);
    }
}

multiversion! {
    /// Add one octave to the sum and step its amplitude.
    fn add(
        sum: Sum,
        noise: &[f32],
        gain: &[f32],
        amp: &mut [f32],
        total: &mut [f32],
        weight: &mut [f32],
        out: &mut [f32],
    ) {
        match sum {
            Sum::Fbm => add_octave(noise, gain, amp, total, out, |n, _| 0.5 + 0.5 * n),
            Sum::Turbulence => add_octave(noise, gain, amp, total, out, |n, _| n.abs()),
            Sum::Billow => add_octave(noise, gain, amp, total, out, |n, _| n.abs() * (2.0 - n.abs())),
            Sum::Ridged => {
                let n = out.len();
                let (noise, gain) = (&noise[..n], &gain[..n]);
                let (amp, total, weight) = (&mut amp[..n], &mut total[..n], &mut weight[..n]);
                for i in 0..n {
                    let ridge = 1.0 - noise[i].abs();
                    let signal = ridge * ridge * weight[i];
                    weight[i] = num::saturate(signal * RIDGED_FEEDBACK);
                    out[i] += amp[i] * signal;
                    total[i] += amp[i];
                    amp[i] *= num::saturate(gain[i]);
                }
            }
        }
    }
}

multiversion! {
    fn normalise(total: &[f32], out: &mut [f32]) {
        for (o, t) in out.iter_mut().zip(total) { *o = num::saturate(*o / *t); }
    }
}
