//! Simplex-type gradient noise that tiles: on a lattice of triangles sheared by a rational.
//!
//! Perlin's skewed simplex lattice has irrational coordinates and tiles only where its skew happens to fit. Here the
//! lattice points are (i + s j, j) in cells, with the shear `s = k / cells_v` nearest to 1/2: after `cells_v` rows the
//! shear has moved the lattice by the whole number k, so any counts tile. For even `cells_v` the triangles are
//! isosceles with sides 1, 1.118, 1.118; for odd counts the shear is (n +- 1) / 2n (for n = 1 they are right-angled).

use super::{Cells, Part, floor, to_u32};
use crate::base::hash;
use crate::multiversion;

/// What the shear of a lattice with `cells_v` rows fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Shear {
    /// Cells that `cells_v` rows move the lattice.
    turn: f32,
    /// Shear per row.
    s: f32,
    /// Squared radius of a point's influence: the least altitude of the triangles, so that it ends on their sides.
    r2: f32,
    /// Scales the sum to [-1, 1].
    gain: f32,
}

impl Shear {
    pub(in super::super) fn new(cells_v: u32) -> Self {
        let turn = cells_v / 2;
        let s = turn as f32 / cells_v as f32;
        // The area of a unit parallelogram is 1, so each altitude is 1 / side.
        let r2 = 1.0 / (1.0 + s.max(1.0 - s) * s.max(1.0 - s));
        // The greatest sum possible at a point is the sum of w(d) |d| over the three corners; greatest over a grid
        // of points in both triangles, and a little more for the points between.
        let mut peak = 0.0f32;
        for a in 0..=32 {
            for b in 0..=32 {
                let (x, y) = (a as f32 / 32.0, b as f32 / 32.0);
                let far = if a + b > 32 { 1.0 } else { 0.0 };
                let at = |i: f32, j: f32| {
                    let (dx, dy) = (x - i + s * (y - j), y - j);
                    let d2 = dx * dx + dy * dy;
                    weight(r2, d2) * d2.sqrt()
                };
                peak = peak.max(at(1.0, 0.0) + at(0.0, 1.0) + at(far, far));
            }
        }
        Self { turn: turn as f32, s, r2, gain: 0.995 / peak }
    }
}

/// Influence of a lattice point at squared distance `d2`: (r^2 - d^2)^4, zero with three derivatives at its end.
#[inline(always)]
fn weight(r2: f32, d2: f32) -> f32 {
    let t = (r2 - d2).max(0.0);
    let t = t * t;
    t * t
}

/// The slope of one of eight unit gradients, 45 degrees apart, none along an axis.
#[inline(always)]
fn slope(h: u32, dx: f32, dy: f32) -> f32 {
    const LONG: f32 = 0.923_879_5;
    const SHORT: f32 = 0.382_683_43;
    let (gx, gy) = if h & 4 == 0 { (LONG, SHORT) } else { (SHORT, LONG) };
    let x = f32::from_bits((gx * dx).to_bits() ^ (h << 31));
    let y = f32::from_bits((gy * dy).to_bits() ^ ((h >> 1) << 31));
    x + y
}

#[inline(always)]
fn simplex_at(u: f32, v: f32, cells: Cells, shear: Shear) -> f32 {
    let (width, height) = (cells.u as f32, cells.v as f32);
    let (x, y) = cells.at(u, v);
    let p = x - shear.s * y;
    let (i, j) = (floor(p), floor(y));
    let (fx, fy) = (p - i, y - j);
    let far = if fx + fy >= 1.0 { 1.0 } else { 0.0 };
    // Row j is row j - cells_v moved by the turn. The rows' hashes come first: a row of texels has two of them.
    let row = |j: f32| {
        let over = if j >= height { 1.0 } else { 0.0 };
        let over = if j >= 2.0 * height { 2.0 } else { over };
        (hash::pcg(cells.seed ^ to_u32(j - over * height)), over * shear.turn)
    };
    let (low, high) = (row(j), row(j + 1.0));
    let last = if far > 0.0 { high } else { low };
    let per_width = 1.0 / width;
    let corner = |di: f32, dj: f32, (row, turn): (u32, f32)| {
        let (dx, dy) = (fx - di + shear.s * (fy - dj), fy - dj);
        // The column modulo cells_u; the quotient may be one off.
        let i = i + di + turn;
        let column = i - width * floor(i * per_width);
        let column = if column < 0.0 { column + width } else { column };
        let column = if column >= width { column - width } else { column };
        let h = hash::pcg(row.wrapping_add(to_u32(column)));
        weight(shear.r2, dx * dx + dy * dy) * slope(h, dx, dy)
    };
    let sum = corner(1.0, 0.0, low) + corner(0.0, 1.0, high) + corner(far, far, last);
    (sum * shear.gain).max(-1.0).min(1.0)
}

/// Simplex-type noise, in [-1, 1], 0 at lattice points. `shear` is `Shear::new(cells.v)`.
pub(in super::super) fn simplex(at: &Part<'_>, cells: Cells, shear: Shear, out: &mut [f32]) {
    match at.row_v() {
        Some(v) => row(at.us(), v, cells, shear, out),
        None => free(at.us(), &at.vs(), cells, shear, out),
    }
}

multiversion! {
    /// A row with one `v`: what depends on it is hoisted.
    fn row(us: &[f32], v: f32, cells: Cells, shear: Shear, out: &mut [f32]) {
        for (o, u) in out.iter_mut().zip(us) { *o = simplex_at(*u, v, cells, shear); }
    }
}

multiversion! {
    fn free(us: &[f32], vs: &[f32], cells: Cells, shear: Shear, out: &mut [f32]) {
        for ((o, u), v) in out.iter_mut().zip(us).zip(vs) { *o = simplex_at(*u, *v, cells, shear); }
    }
}
