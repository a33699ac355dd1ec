//! Blue noise of cells.

use std::ops::Range;

use super::lattice::Coords;
use crate::base::{hash, num};
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Prepared, Spec};

/// Even grain without clumps: a grid of flat cells in which every grey occurs equally often and near cells differ.
///
/// The cells belong to the tile, not to the map's texels; a map with fewer texels than cells shows a sample of them,
/// which is no longer blue. Thresholding it at t scatters dots evenly over the share t of the tile.
///
/// Made by repeating five times: subtract a blur (sigma 1.4 cells) from the grid, then replace values by their rank.
/// That removes low frequencies while the histogram stays exactly uniform.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BlueNoise {
    /// Cells around the body: 64 to 512.
    #[schemars(range(min = 1, max = 2048))]
    pub cells_u: u32,
    /// Cells along the body.
    #[schemars(range(min = 1, max = 2048))]
    pub cells_v: u32,
}

impl Default for BlueNoise {
    fn default() -> Self {
        Self { cells_u: 64, cells_v: 64 }
    }
}

/// How often the grid is filtered and ranked; more changes little.
const ROUNDS: usize = 5;
/// The blur's standard deviation, cells.
const SIGMA: f32 = 1.4;
/// The blur reaches so many cells to each side: 3 sigma.
const RADIUS: i64 = 4;
const MAX_CELLS: u32 = 2048;

struct Tile {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Operation for BlueNoise {
    const SPEC: Spec = Spec {
        name: "blue_noise",
        summary: "Even grain without clumps: a grid of random greys in which near cells differ.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar(
            "value",
            "",
            "The cell's value, in (0, 1), mean 0.5; every value occurs once.",
        )],
        random: true,
        // A cell may be as small as a texel of a coarse grid.
        scale_tolerance: 0.12,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        1.5
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        let side = |n: u32| n.clamp(1, MAX_CELLS) as usize;
        Some(Box::new(tile(side(self.cells_u), side(self.cells_v), hash::pcg(cx.seed))))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let tile: &Tile = cx.prepared();
        let mut at = Coords::new(cx.domain.width);
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            for ((o, u), v) in outs.only(y).iter_mut().zip(at.all().us()).zip(&*at.all().vs()) {
                // u and v may round to exactly 1, which is cell 0 again.
                let cell = |t: f32, n: usize| (t * n as f32) as usize % n;
                *o = tile.values[cell(*v, tile.height) * tile.width + cell(*u, tile.width)];
            }
        }
    }
}

fn tile(width: usize, height: usize, seed: u32) -> Tile {
    let mut values: Vec<f32> = (0..height)
        .flat_map(|y| (0..width).map(move |x| hash::unit(hash::hash2(seed, y as u32, x as u32))))
        .collect();
    let mut order: Vec<u32> = (0..values.len() as u32).collect();
    rank(&mut values, &mut order);
    let taps: Vec<f32> =
        (-RADIUS..=RADIUS).map(|d| num::exp(-0.5 * (d * d) as f32 / (SIGMA * SIGMA))).collect();
    let sum: f32 = taps.iter().sum();
    let taps: Vec<f32> = taps.iter().map(|t| t / sum).collect();
    let mut across = vec![0.0; values.len()];
    for _ in 0..ROUNDS {
        for y in 0..height {
            let row = &values[y * width..(y + 1) * width];
            for x in 0..width {
                across[y * width + x] = blur_at(&taps, x, width, |x| row[x]);
            }
        }
        for y in 0..height {
            for x in 0..width {
                values[y * width + x] -= blur_at(&taps, y, height, |y| across[y * width + x]);
            }
        }
        rank(&mut values, &mut order);
    }
    Tile { width, height, values }
}

/// The blur along one axis, around the torus.
fn blur_at(taps: &[f32], at: usize, n: usize, read: impl Fn(usize) -> f32) -> f32 {
    let mut sum = 0.0;
    for (k, tap) in taps.iter().enumerate() {
        sum += tap * read((at as i64 + k as i64 - RADIUS).rem_euclid(n as i64) as usize);
    }
    sum
}

/// Replace each value by its rank, scaled to (0, 1); equal values by their place.
fn rank(values: &mut [f32], order: &mut [u32]) {
    order.sort_unstable_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]).then(a.cmp(&b)));
    let scale = 1.0 / values.len() as f32;
    for (rank, &at) in order.iter().enumerate() {
        values[at as usize] = (rank as f32 + 0.5) * scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power of the discrete Fourier transform at (kx, ky) by its definition.
    fn power(tile: &Tile, kx: usize, ky: usize) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let turns = (kx * x) as f64 / tile.width as f64 + (ky * y) as f64 / tile.height as f64;
                let a = turns * std::f64::consts::TAU;
                let v = f64::from(tile.values[y * tile.width + x]);
                re += v * a.cos();
                im += v * a.sin();
            }
        }
        (re * re + im * im) / (tile.width * tile.height) as f64
    }

    #[test]
    fn every_rank_occurs_once() {
        let mut values = tile(33, 21, 5).values;
        values.sort_by(f32::total_cmp);
        for (i, v) in values.iter().enumerate() {
            assert_eq!(*v, (i as f32 + 0.5) * (1.0 / 693.0));
        }
    }

    #[test]
    fn low_frequencies_hold_little_power_and_white_noise_fails_this() {
        let blue = tile(64, 64, 3);
        let mut white = tile(64, 64, 3);
        for (i, v) in white.values.iter_mut().enumerate() {
            *v = hash::unit(hash::hash1(9, i as u32));
        }
        // Mean power of white noise is its variance, 1/12. Low: below a tenth of the sampling rate.
        let low = |t: &Tile| {
            let mut bins = Vec::new();
            for ky in 0..=6 {
                for kx in 0..=6 {
                    if (1..=36).contains(&(kx * kx + ky * ky)) {
                        bins.push(power(t, kx, ky));
                    }
                }
            }
            bins.iter().sum::<f64>() / bins.len() as f64 * 12.0
        };
        let (blue, white) = (low(&blue), low(&white));
        assert!(blue < 0.02, "{blue}");
        assert!(white > 0.5, "{white}");
    }

    #[test]
    fn tiny_tiles_are_made() {
        for (w, h) in [(1, 1), (1, 7), (2, 3)] {
            assert!(tile(w, h, 0).values.iter().all(|v| (0.0..1.0).contains(v)));
        }
    }
}
