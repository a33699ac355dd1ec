//! The square lattice, and noise of values on it: value noise, and white noise of cells.

use super::{Cells, Part, fade, floor, to_u32};
use crate::base::{hash, num};
use crate::multiversion;

/// One axis of the lattice at a point: the indices of the two lattice lines around it, and the way between them.
///
/// `t` in [0, cells + 1]; `t == cells` is the lattice line 0 again.
#[inline(always)]
pub(super) fn axis(t: f32, cells: u32) -> (u32, u32, f32) {
    let low = floor(t);
    let i = to_u32(low);
    let i0 = if i >= cells { i - cells } else { i };
    let i1 = if i0 + 1 >= cells { 0 } else { i0 + 1 };
    (i0, i1, t - low)
}

/// The hashes of the four corners around a cell: 00, 10, 01, 11 (first u, then v).
///
/// The row is hashed first, so that a row of texels with one `v` hashes it once.
#[inline(always)]
pub(super) fn corners(seed: u32, (i0, i1): (u32, u32), (j0, j1): (u32, u32)) -> [u32; 4] {
    [
        hash::hash2(seed, j0, i0),
        hash::hash2(seed, j0, i1),
        hash::hash2(seed, j1, i0),
        hash::hash2(seed, j1, i1),
    ]
}

#[inline(always)]
pub(super) fn bilinear(f: [f32; 4], x: f32, y: f32) -> f32 {
    num::lerp(num::lerp(f[0], f[1], x), num::lerp(f[2], f[3], x), y)
}

#[inline(always)]
fn value_at(u: f32, v: f32, cells: Cells) -> f32 {
    let (s, t) = cells.at(u, v);
    let (i0, i1, x) = axis(s, cells.u);
    let (j0, j1, y) = axis(t, cells.v);
    let h = corners(cells.seed, (i0, i1), (j0, j1));
    bilinear(h.map(signed), fade(x), fade(y))
}

/// [`hash::signed`] through a signed integer, whose conversion is one instruction everywhere.
#[inline(always)]
fn signed(h: u32) -> f32 {
    (h >> 8) as i32 as f32 * (1.0 / 8_388_608.0) - 1.0
}

#[inline(always)]
fn white_at(u: f32, v: f32, cells: Cells) -> f32 {
    let (s, t) = cells.at(u, v);
    let (i, _, _) = axis(s, cells.u);
    let (j, _, _) = axis(t, cells.v);
    signed(hash::hash2(cells.seed, j, i))
}

/// A kernel over a row from its formula at a point; rows with one `v` get a loop that hoists what depends on it.
macro_rules! row_kernel {
    ($(#[$doc:meta])* $name:ident = $at:ident) => {
        $(#[$doc])*
        pub(in super::super) fn $name(at: &Part<'_>, cells: Cells, out: &mut [f32]) {
            multiversion! {
                fn row(us: &[f32], v: f32, cells: Cells, out: &mut [f32]) {
                    for (o, u) in out.iter_mut().zip(us) { *o = $at(*u, v, cells); }
                }
            }
            multiversion! {
                fn free(us: &[f32], vs: &[f32], cells: Cells, out: &mut [f32]) {
                    for ((o, u), v) in out.iter_mut().zip(us).zip(vs) { *o = $at(*u, *v, cells); }
                }
            }
            match at.row_v() {
                Some(v) => row(at.us(), v, cells, out),
                None => free(at.us(), &at.vs(), cells, out),
            }
        }
    };
}

row_kernel! {
    /// Value noise: uniform random values in [-1, 1) at lattice points, joined by the quintic fade.
    value = value_at
}

row_kernel! {
    /// White noise of cells: one uniform random value in [-1, 1) per cell.
    white = white_at
}
