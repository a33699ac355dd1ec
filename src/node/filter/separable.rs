//! Separable convolution on the torus: the core of the Gaussian and the box blur.
//!
//! The vertical pass comes first: it reads the window's halo rows directly, so a band costs no more than its share,
//! whatever its height. Sums run over the taps in order, from the first, for every texel: bands, block widths and
//! SIMD levels change no bit.

use std::ops::Range;

use super::finite;
use crate::base::{Domain, Rows};
use crate::multiversion;
use crate::node::{Inputs, Outputs, Reach};

/// Weights of a one-dimensional kernel at the offsets `first ..`; never more than the torus has texels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Taps {
    pub(super) first: i64,
    pub(super) weights: Vec<f32>,
}

impl Taps {
    /// The symmetric kernel `half[|k|] / sum` on a torus of `n` texels; a kernel wider than the torus wraps onto it.
    pub(super) fn symmetric(half: &[f64], n: usize) -> Self {
        let radius = half.len() as i64 - 1;
        let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
        let length = (2 * radius + 1).min(n as i64);
        let first = if length < n as i64 { -radius } else { -(n as i64 / 2) };
        let mut weights = vec![0.0; length as usize];
        for k in -radius..=radius {
            let slot = if length < n as i64 { k - first } else { (k - first).rem_euclid(n as i64) };
            weights[slot as usize] += half[k.unsigned_abs() as usize] / sum;
        }
        Self { first, weights: weights.iter().map(|&w| w as f32).collect() }
    }

    /// How many texels to each side it reads.
    pub(super) fn reach(&self) -> usize {
        (-self.first).max(self.first + self.weights.len() as i64 - 1).max(0) as usize
    }

    /// It returns its input.
    fn is_identity(&self) -> bool {
        self.first == 0 && self.weights == [1.0]
    }
}

/// A length in fractions of the tile's shorter side, as texels around and along the body.
pub(super) fn texels(domain: &Domain, tile: f32) -> (f64, f64) {
    let mm = f64::from(tile) * f64::from(domain.shorter_mm());
    let per = |side: f32, count: usize| mm / f64::from(side) * count as f64;
    (per(domain.girth_mm, domain.width), per(domain.length_mm, domain.height))
}

/// The row with `left` and `right` texels of itself, wrapped, at its ends.
pub(super) fn pad_row(row: &[f32], left: usize, right: usize, out: &mut Vec<f32>) {
    let n = row.len();
    out.clear();
    out.reserve(left + n + right);
    let start = left.next_multiple_of(n) - left;
    let mut rest = left + n + right;
    let head = &row[start..(start + rest).min(n)];
    out.extend_from_slice(head);
    rest -= head.len();
    while rest > 0 {
        let part = &row[..rest.min(n)];
        out.extend_from_slice(part);
        rest -= part.len();
    }
}

/// The reach of [`convolve`] with these kernels.
pub(super) fn reach(u: &Taps, v: &Taps) -> Reach {
    if u.is_identity() && v.is_identity() {
        return Reach::Point;
    }
    Reach::Around { x: u.reach(), y: v.reach() }
}

/// Rows that the vertical pass makes at once, so that each row it reads serves as many sums.
const GROUP: usize = 4;

/// Convolve input 0 with `u` around and `v` along the body into output 0.
pub(super) fn convolve(rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>, u: &Taps, v: &Taps) {
    let image = ins.scalar(0);
    if let Some(value) = image.constant() {
        // Exactly: rounded weights sum to 1 only within 1e-6.
        if let Some(band) = outs.band(0) {
            band.fill(value);
        }
        return;
    }
    let width = outs.width();
    let mut tall = vec![0.0; GROUP * width];
    let mut padded = Vec::new();
    let mut y = rows.start;
    while y < rows.end {
        let group = (rows.end - y).min(GROUP as i64);
        let group = if group < GROUP as i64 { 1 } else { GROUP };
        vertical(image, y, v, &mut tall[..group * width]);
        for (i, row) in tall.chunks_exact(width).take(group).enumerate() {
            let out = outs.only(y + i as i64);
            if u.is_identity() {
                out.copy_from_slice(row);
            } else {
                let right = u.weights.len() - 1;
                // Texel x reads padded[x ..][..taps]: the padding starts at the first offset.
                let left = (-u.first).max(0) as usize;
                pad_row(row, left, right - left.min(right), &mut padded);
                horizontal(&padded, &u.weights, out);
            }
        }
        y += group as i64;
    }
}

/// `out.len() / width` rows (1 or [`GROUP`]) of the vertical pass, from row `y`.
fn vertical(image: Rows<'_>, y: i64, taps: &Taps, out: &mut [f32]) {
    let width = image.width();
    let group = out.len() / width;
    if taps.is_identity() {
        for (i, out) in out.chunks_exact_mut(width).enumerate() {
            out.copy_from_slice(image.row(y + i as i64));
        }
        return;
    }
    let sources: Vec<&[f32]> =
        (0..taps.weights.len() + group - 1).map(|j| image.row(y + taps.first + j as i64)).collect();
    if group == 1 {
        vertical_one(&sources, &taps.weights, out);
    } else {
        // Zero weights around: adding 0 * x to a sum that started at +0 changes no bit of it.
        let mut weights = vec![0.0; GROUP - 1];
        weights.extend_from_slice(&taps.weights);
        weights.resize(weights.len() + GROUP - 1, 0.0);
        vertical_group(&sources, &weights, width, out);
    }
}

/// Texels summed at once along a row, and of each of [`GROUP`] rows: as many as vector registers hold.
const BLOCK: usize = 64;
const NARROW: usize = 32;

/// `sum += w * row`, over arrays: with lengths known, LLVM keeps the sums in registers (measured 4 times faster).
#[inline(always)]
fn add<const N: usize>(sum: &mut [f32; N], w: f32, row: &[f32]) {
    if let Some(row) = row.first_chunk::<N>() {
        for i in 0..N {
            sum[i] += w * row[i];
        }
    }
}

/// Write the sums. Limited in a copy, then copied as a whole: written one by one, they would live in memory (6 times
/// slower).
#[inline(always)]
fn store<const N: usize>(sum: &[f32; N], out: &mut [f32]) {
    let mut limited = *sum;
    for v in &mut limited {
        *v = finite(*v);
    }
    out[..N].copy_from_slice(&limited);
}

/// The start of the block that follows the one at `start`: the last one overlaps its neighbour (and repeats its sums).
#[inline(always)]
fn next_block(start: usize, block: usize, width: usize) -> usize {
    if start + block == width { width } else { (start + block).min(width - block) }
}

multiversion! {
    fn vertical_one(sources: &[&[f32]], weights: &[f32], out: &mut [f32]) {
        let width = out.len();
        if width < BLOCK {
            for x in 0..width {
                let mut sum = 0.0;
                for (row, w) in sources.iter().zip(weights) { sum += *w * row[x]; }
                out[x] = finite(sum);
            }
            return;
        }
        let mut start = 0;
        while start < width {
            let mut sum = [0.0; BLOCK];
            for (row, w) in sources.iter().zip(weights) { add(&mut sum, *w, &row[start..start + BLOCK]); }
            store(&sum, &mut out[start..]);
            start = next_block(start, BLOCK, width);
        }
    }
}

multiversion! {
    fn vertical_group(sources: &[&[f32]], weights: &[f32], width: usize, out: &mut [f32]) {
        if width < NARROW {
            for g in 0..GROUP {
                for x in 0..width {
                    let mut sum = 0.0;
                    for (row, w) in sources.iter().zip(&weights[GROUP - 1 - g..]) { sum += *w * row[x]; }
                    out[g * width + x] = finite(sum);
                }
            }
            return;
        }
        let mut start = 0;
        while start < width {
            let (mut a, mut b, mut c, mut d) = ([0.0; NARROW], [0.0; NARROW], [0.0; NARROW], [0.0; NARROW]);
            for (row, w) in sources.iter().zip(weights.windows(GROUP)) {
                let row = &row[start..start + NARROW];
                add(&mut a, w[3], row);
                add(&mut b, w[2], row);
                add(&mut c, w[1], row);
                add(&mut d, w[0], row);
            }
            store(&a, &mut out[start..]);
            store(&b, &mut out[width + start..]);
            store(&c, &mut out[2 * width + start..]);
            store(&d, &mut out[3 * width + start..]);
            start = next_block(start, NARROW, width);
        }
    }
}

multiversion! {
    fn horizontal(padded: &[f32], weights: &[f32], out: &mut [f32]) {
        let width = out.len();
        if width < BLOCK {
            for x in 0..width {
                let mut sum = 0.0;
                for (v, w) in padded[x..].iter().zip(weights) { sum += *w * *v; }
                out[x] = finite(sum);
            }
            return;
        }
        let mut start = 0;
        while start < width {
            let mut sum = [0.0; BLOCK];
            let span = &padded[start..start + BLOCK + weights.len() - 1];
            for (row, w) in span.windows(BLOCK).zip(weights) { add(&mut sum, *w, row); }
            store(&sum, &mut out[start..]);
            start = next_block(start, BLOCK, width);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_wraps_any_number_of_times() {
        let mut out = Vec::new();
        for (left, right) in [(0, 0), (1, 2), (3, 3), (7, 0), (0, 8), (11, 4)] {
            pad_row(&[0.0, 1.0, 2.0], left, right, &mut out);
            let expected: Vec<f32> =
                (-(left as i64)..3 + right as i64).map(|i| i.rem_euclid(3) as f32).collect();
            assert_eq!(out, expected, "{left} {right}");
        }
    }

    #[test]
    fn folded_kernels_hold_the_whole_weight_once() {
        let half = [1.0, 0.8, 0.5, 0.2, 0.1];
        for n in 1..12 {
            let taps = Taps::symmetric(&half, n);
            assert!(taps.weights.len() <= n && taps.reach() <= n / 2, "{n}");
            assert!((taps.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let mut torus = vec![0.0; n];
            for k in -4i64..=4 {
                torus[k.rem_euclid(n as i64) as usize] += half[k.unsigned_abs() as usize] / 4.2;
            }
            for (i, w) in taps.weights.iter().enumerate() {
                let slot = (taps.first + i as i64).rem_euclid(n as i64) as usize;
                assert!((f64::from(*w) - torus[slot]).abs() < 1e-6, "{n} {i}");
            }
        }
    }
}
