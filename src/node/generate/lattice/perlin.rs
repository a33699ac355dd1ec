//! Perlin's gradient noise.
//!
//! Of a cell it needs eight bits: two signs for the gradient of each corner. Hashing them at every texel would be most
//! of the noise's cost, so a cell is hashed once and its bits are looked up.

use std::sync::OnceLock;

use super::square::{axis, bilinear, corners};
use super::{Cells, Coords, fade};
use crate::base::hash;
use crate::multiversion;

/// Cells of a lattice whose bits are kept whole, for texels that may lie anywhere: 64 KiB.
const TABLE: usize = 1 << 14;

/// Perlin's gradient noise with the gradients (+-1, +-1) and the quintic fade: in [-1, 1], 0 at lattice points.
///
/// Source: Ken Perlin, "Improving Noise" (2002), in two dimensions. The bound is attained: at a cell's centre
/// with all four gradients towards it.
#[derive(Debug)]
pub(in super::super) struct Perlin {
    cells: Cells,
    /// Bits of every cell, row by row; made when first a texel asks for it.
    table: OnceLock<Box<[u32; TABLE]>>,
}

/// What a row of texels needs of the lattice: it is kept for the rows that lie in the same row of cells.
#[derive(Debug, Default)]
pub(in super::super) struct PerlinRow {
    /// The row of cells.
    row: Option<u32>,
    /// The offset around the body for which `columns` hold.
    du: Option<f32>,
    /// Bits of its cells; a power of two of them, so that no bound need be checked.
    cells: Vec<u32>,
    /// Column of each texel's cell.
    columns: Vec<u32>,
    /// Bits of each texel's cell.
    bits: Vec<u32>,
}

impl Perlin {
    /// The noise on these cells.
    pub(in super::super) fn new(cells: Cells) -> Self {
        Self { cells, table: OnceLock::new() }
    }

    /// The noise along a row of texels. `kept` belongs to this noise and the columns of this `at`.
    pub(in super::super) fn sample(&self, at: &Coords, kept: &mut PerlinRow, out: &mut [f32]) {
        let cells = self.cells;
        let (columns, rows) = (cells.u as usize, cells.v as usize);
        match at.row_v() {
            // With more cells than texels, texels are hashed faster than cells.
            Some(v) if at.du().is_some() && columns <= out.len() => {
                let (_, t) = cells.at(0.0, v);
                let (row, _, y) = axis(t, cells.v);
                kept.set(at, cells, row);
                along_row(at.us(), &kept.bits, y, cells, out);
            }
            Some(v) => hashed_row(at.us(), v, cells, out),
            None if columns * rows <= TABLE => {
                let table = self.table.get_or_init(|| table(cells));
                anywhere(at.us(), at.vs(), table, cells, out);
            }
            None => hashed(at.us(), at.vs(), cells, out),
        }
    }
}

impl PerlinRow {
    fn set(&mut self, at: &Coords, cells: Cells, row: u32) {
        if self.du != at.du() {
            self.cells.resize((cells.u as usize).next_power_of_two(), 0);
            self.columns.resize(at.us().len(), 0);
            self.bits.resize(at.us().len(), 0);
            find_columns(at.us(), cells, &mut self.columns);
            (self.du, self.row) = (at.du(), None);
        }
        if self.row == Some(row) {
            return;
        }
        self.row = Some(row);
        row_bits(cells, row, &mut self.cells[..cells.u as usize]);
        look_up(&self.cells, &self.columns, &mut self.bits);
    }
}

/// Bits of every cell.
fn table(cells: Cells) -> Box<[u32; TABLE]> {
    let mut table = Box::new([0; TABLE]);
    for (row, bits) in table.chunks_exact_mut(cells.u as usize).take(cells.v as usize).enumerate() {
        row_bits(cells, row as u32, bits);
    }
    table
}

multiversion! {
    /// Bits of one row of cells: two for each corner, in the order 00, 01, 10, 11 (first u, then v).
    fn row_bits(cells: Cells, row: u32, bits: &mut [u32]) {
        let next = if row + 1 == cells.v { 0 } else { row + 1 };
        for (i, b) in bits.iter_mut().enumerate() {
            let (low, high) =
                (hash::hash2(cells.seed, row, i as u32), hash::hash2(cells.seed, next, i as u32));
            *b = (low & 3) | ((high & 3) << 2);
        }
        let Some(&first) = bits.first() else { return };
        for i in 0..bits.len() - 1 { bits[i] |= (bits[i + 1] & 15) << 4; }
        let last = bits.len() - 1;
        bits[last] |= (first & 15) << 4;
    }
}

multiversion! {
    fn find_columns(us: &[f32], cells: Cells, columns: &mut [u32]) {
        for (c, u) in columns.iter_mut().zip(us) { *c = axis(cells.at(*u, 0.0).0, cells.u).0; }
    }
}

multiversion! {
    fn look_up(cells: &[u32], columns: &[u32], bits: &mut [u32]) {
        for (b, c) in bits.iter_mut().zip(columns) { *b = cells.get(*c as usize).copied().unwrap_or(0); }
    }
}

/// `x` with the sign flipped where the lowest bit of `bit` is set.
#[inline(always)]
fn flip(x: f32, bit: u32) -> f32 {
    f32::from_bits(x.to_bits() ^ (bit << 31))
}

/// The dot product of the corner's gradient, one of (+-1, +-1), and the vector from the corner.
#[inline(always)]
fn slope(h: u32, x: f32, y: f32) -> f32 {
    flip(x, h) + flip(y, h >> 1)
}

/// The noise at (`x`, `y`) in a cell, from the bits of its corners.
#[inline(always)]
fn in_cell(h: [u32; 4], x: f32, y: f32) -> f32 {
    let g =
        [slope(h[0], x, y), slope(h[1], x - 1.0, y), slope(h[2], x, y - 1.0), slope(h[3], x - 1.0, y - 1.0)];
    bilinear(g, fade(x), fade(y))
}

/// Bits of the corners 00, 10, 01, 11 from those of the cell.
#[inline(always)]
fn corner_bits(cell: u32) -> [u32; 4] {
    [cell, cell >> 4, cell >> 2, cell >> 6]
}

#[inline(always)]
fn hashed_at(u: f32, v: f32, cells: Cells) -> f32 {
    let (s, t) = cells.at(u, v);
    let (i0, i1, x) = axis(s, cells.u);
    let (j0, j1, y) = axis(t, cells.v);
    in_cell(corners(cells.seed, (i0, i1), (j0, j1)), x, y)
}

multiversion! {
    /// Texels whose cells' bits are known, `y` from the cells' first line.
    fn along_row(us: &[f32], bits: &[u32], y: f32, cells: Cells, out: &mut [f32]) {
        for ((o, u), b) in out.iter_mut().zip(us).zip(bits) {
            let (_, _, x) = axis(cells.at(*u, 0.0).0, cells.u);
            *o = in_cell(corner_bits(*b), x, y);
        }
    }
}

multiversion! {
    fn anywhere(us: &[f32], vs: &[f32], table: &[u32; TABLE], cells: Cells, out: &mut [f32]) {
        for ((o, u), v) in out.iter_mut().zip(us).zip(vs) {
            let (s, t) = cells.at(*u, *v);
            let ((i, _, x), (j, _, y)) = (axis(s, cells.u), axis(t, cells.v));
            let cell = table[(j * cells.u + i) as usize % TABLE];
            *o = in_cell(corner_bits(cell), x, y);
        }
    }
}

multiversion! {
    fn hashed_row(us: &[f32], v: f32, cells: Cells, out: &mut [f32]) {
        for (o, u) in out.iter_mut().zip(us) { *o = hashed_at(*u, v, cells); }
    }
}

multiversion! {
    fn hashed(us: &[f32], vs: &[f32], cells: Cells, out: &mut [f32]) {
        for ((o, u), v) in out.iter_mut().zip(us).zip(vs) { *o = hashed_at(*u, *v, cells); }
    }
}
