//! Perlin's gradient noise.
//!
//! Of a cell it needs eight bits: two signs for the gradient of each corner. Hashing them at every texel would be most
//! of the noise's cost, so a cell is hashed once and its bits are looked up.

use std::sync::OnceLock;

use super::square::{axis, bilinear, corners};
use super::{Cells, Part, fade, near};
use crate::base::hash;
use crate::multiversion;

/// Cells of a texel at most, in a row whose cells are kept: each is hashed twice, and four times for a texel by itself.
const DENSEST: usize = 2;
/// Texels worked on at once where it matters whether they share a cell.
const LANES: usize = 16;
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
    /// Bits of its cells, and of the first ones again.
    cells: Vec<u32>,
    /// Column of each texel's cell.
    columns: Vec<u16>,
    /// Where the texel lies in it. Its fade is computed again: so many arrays would take more of the second cache than they save.
    x: Vec<f32>,
    /// Bits of each texel's cell.
    bits: Vec<u8>,
}

impl Perlin {
    /// The noise on these cells.
    pub(in super::super) fn new(cells: Cells) -> Self {
        Self { cells, table: OnceLock::new() }
    }

    /// Add `amp (0.5 + 0.5 n)` for the noise n at some texels, `kept` as in [`Perlin::sample`], where the cells' bits are or can be
    /// kept; else it does nothing, and says so.
    pub(in super::super) fn add(
        &self,
        at: &Part<'_>,
        kept: &mut PerlinRow,
        amp: f32,
        out: &mut [f32],
    ) -> bool {
        if let Some(y) = self.along(at, kept) {
            let (x, bits) = kept.at(at);
            add_along_row(x, bits, y, amp, out);
            return true;
        }
        let table = at.row_v().is_none().then(|| self.table()).flatten();
        if let Some(table) = table {
            add_anywhere(at.us(), &at.vs(), table, self.cells, amp, out);
        }
        table.is_some()
    }

    /// The noise at some texels of a row. `kept` belongs to this noise and the columns of this row.
    pub(in super::super) fn sample(&self, at: &Part<'_>, kept: &mut PerlinRow, out: &mut [f32]) {
        let cells = self.cells;
        if let Some(y) = self.along(at, kept) {
            let (x, bits) = kept.at(at);
            return along_row(x, bits, y, out);
        }
        match (at.row_v(), self.table()) {
            (Some(v), _) => hashed_row(at.us(), v, cells, out),
            (None, Some(table)) => anywhere(at.us(), &at.vs(), table, cells, out),
            (None, None) => hashed(at.us(), &at.vs(), cells, out),
        }
    }

    /// Bits of every cell, where there are few enough.
    fn table(&self) -> Option<&[u32; TABLE]> {
        let few = self.cells.u as usize * self.cells.v as usize <= TABLE;
        few.then(|| &**self.table.get_or_init(|| table(self.cells)))
    }

    /// Prepare for a row that lies in one row of cells; returns how far it is from their first line. `None` for other
    /// rows, and where there are many more cells than texels, which are hashed faster than cells.
    fn along(&self, at: &Part<'_>, kept: &mut PerlinRow) -> Option<f32> {
        let v = at.row_v()?;
        if at.du().is_none() || self.cells.u as usize > DENSEST * at.row_us().len() {
            return None;
        }
        let (_, t) = self.cells.at(0.0, v);
        let (row, _, y) = axis(t, self.cells.v);
        kept.set(at, self.cells, row);
        Some(y)
    }
}

impl PerlinRow {
    /// Of some texels: where they lie in their cells, and the cells' bits.
    fn at(&self, at: &Part<'_>) -> (&[f32], &[u8]) {
        (&self.x[at.texels()], &self.bits[at.texels()])
    }

    fn set(&mut self, at: &Part<'_>, cells: Cells, row: u32) {
        if self.du != at.du() {
            self.cells.resize(cells.u as usize + near::AGAIN, 0);
            self.columns.resize(at.row_us().len(), 0);
            self.bits.resize(at.row_us().len(), 0);
            self.x.resize(at.row_us().len(), 0.0);
            find_columns(at.row_us(), cells, &mut self.columns, &mut self.x);
            (self.du, self.row) = (at.du(), None);
        }
        if self.row == Some(row) {
            return;
        }
        self.row = Some(row);
        let (bits, again) = self.cells.split_at_mut(cells.u as usize);
        row_bits(cells, row, bits);
        again.iter_mut().zip(bits.iter().cycle()).for_each(|(again, first)| *again = *first);
        near::look_up(&self.cells, cells.u, &self.columns, &mut self.bits);
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
    fn find_columns(us: &[f32], cells: Cells, columns: &mut [u16], xs: &mut [f32]) {
        for ((c, x), u) in columns.iter_mut().zip(xs).zip(us) {
            let (column, _, along) = axis(cells.at(*u, 0.0).0, cells.u);
            // A row has 65536 texels at most, and no more cells.
            (*c, *x) = (column as u16, along);
        }
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

/// The noise at (`x`, `y`) in a cell, from the bits of its corners and the fades of both.
#[inline(always)]
fn in_cell(h: [u32; 4], [x, y]: [f32; 2], fades: [f32; 2]) -> f32 {
    let g =
        [slope(h[0], x, y), slope(h[1], x - 1.0, y), slope(h[2], x, y - 1.0), slope(h[3], x - 1.0, y - 1.0)];
    bilinear(g, fades[0], fades[1])
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
    in_cell(corners(cells.seed, (i0, i1), (j0, j1)), [x, y], [fade(x), fade(y)])
}

multiversion! {
    /// Texels whose cells' bits are known, `y` from the cells' first line.
    fn along_row(xs: &[f32], bits: &[u8], y: f32, out: &mut [f32]) {
        let fade_y = fade(y);
        for ((o, x), b) in out.iter_mut().zip(xs).zip(bits) {
            *o = in_cell(corner_bits(u32::from(*b)), [*x, y], [fade(*x), fade_y]);
        }
    }
}

multiversion! {
    /// The same, added to what is there.
    fn add_along_row(xs: &[f32], bits: &[u8], y: f32, amp: f32, out: &mut [f32]) {
        let fade_y = fade(y);
        for ((o, x), b) in out.iter_mut().zip(xs).zip(bits) {
            *o += amp * (0.5 + 0.5 * in_cell(corner_bits(u32::from(*b)), [*x, y], [fade(*x), fade_y]));
        }
    }
}

/// Where texels lie in a table of cells, and in their cells.
#[inline(always)]
fn place<const N: usize>(us: &[f32; N], vs: &[f32; N], cells: Cells) -> ([u32; N], [f32; N], [f32; N]) {
    let (mut at, mut x, mut y) = ([0; N], [0.0; N], [0.0; N]);
    for l in 0..N {
        let (s, t) = cells.at(us[l], vs[l]);
        let (i, j);
        ((i, _, x[l]), (j, _, y[l])) = (axis(s, cells.u), axis(t, cells.v));
        at[l] = j * cells.u + i;
    }
    (at, x, y)
}

/// `n`, or what is there and `amp (0.5 + 0.5 n)`.
#[inline(always)]
fn put<const ADD: bool>(out: &mut f32, n: f32, amp: f32) {
    *out = if ADD { *out + amp * (0.5 + 0.5 * n) } else { n };
}

multiversion! {
    fn anywhere(us: &[f32], vs: &[f32], table: &[u32; TABLE], cells: Cells, out: &mut [f32]) {
        put_anywhere::<false>(us, vs, table, cells, 1.0, out);
    }
}

multiversion! {
    /// The same, added to what is there.
    fn add_anywhere(us: &[f32], vs: &[f32], table: &[u32; TABLE], cells: Cells, amp: f32, out: &mut [f32]) {
        put_anywhere::<true>(us, vs, table, cells, amp, out);
    }
}

#[inline(always)]
fn put_anywhere<const ADD: bool>(
    us: &[f32],
    vs: &[f32],
    table: &[u32; TABLE],
    cells: Cells,
    amp: f32,
    out: &mut [f32],
) {
    let ((us, us_rest), (vs, vs_rest)) = (us.as_chunks::<LANES>(), vs.as_chunks::<LANES>());
    let (outs, out_rest) = out.as_chunks_mut::<LANES>();
    for ((out, us), vs) in outs.iter_mut().zip(us).zip(vs) {
        let (at, x, y) = place(us, vs, cells);
        let mut others = 0;
        for l in 0..LANES {
            others |= at[l] ^ at[0];
        }
        if others == 0 {
            // Most neighbours lie in one cell: it is looked up once, and its signs are the same for all.
            let corners = corner_bits(table[at[0] as usize % TABLE]);
            for l in 0..LANES {
                put::<ADD>(&mut out[l], in_cell(corners, [x[l], y[l]], [fade(x[l]), fade(y[l])]), amp);
            }
        } else {
            for l in 0..LANES {
                let corners = corner_bits(table[at[l] as usize % TABLE]);
                put::<ADD>(&mut out[l], in_cell(corners, [x[l], y[l]], [fade(x[l]), fade(y[l])]), amp);
            }
        }
    }
    for ((out, u), v) in out_rest.iter_mut().zip(us_rest).zip(vs_rest) {
        let ([at], [x], [y]) = place(&[*u], &[*v], cells);
        let corners = corner_bits(table[at as usize % TABLE]);
        put::<ADD>(out, in_cell(corners, [x, y], [fade(x), fade(y)]), amp);
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
