//! Cellular noise: distances to the two nearest of one random point per cell.

use super::{Cells, Part, floor, to_u32};
use crate::base::hash;
use crate::multiversion;

/// How the distance of two points is measured.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Straight distance: round cells.
    #[default]
    Euclidean,
    /// Sum of the distances along both axes: cells like cut stones.
    Manhattan,
    /// The greater of the distances along both axes: cells like blocks.
    Chebyshev,
}

/// Texels worked on at once.
const LANES: usize = 16;

/// What a row of texels receives: empty slices for what nobody reads.
#[derive(Debug)]
pub(in super::super) struct Bands<'a> {
    /// Distance to the nearest point, in cells.
    pub(in super::super) f1: &'a mut [f32],
    /// Distance to the second nearest point, in cells.
    pub(in super::super) f2: &'a mut [f32],
    /// Their difference.
    pub(in super::super) edge: &'a mut [f32],
    /// A random number in [0, 1) that is the nearest point's own.
    pub(in super::super) id: &'a mut [f32],
}

/// A block of texels: what the search reads and what it has found so far.
struct Block {
    /// Place within the own cell.
    x: [f32; LANES],
    y: [f32; LANES],
    /// The own cell.
    i: [u32; LANES],
    j: [u32; LANES],
    /// Least and second least distance (squared for the Euclidean metric).
    f1: [f32; LANES],
    f2: [f32; LANES],
    /// Hash of the nearest point.
    id: [u32; LANES],
}

/// `i + d` modulo `cells` for 0 <= i < cells and |d| <= 2, also where cells is 1.
#[inline(always)]
fn neighbour(i: u32, d: i32, cells: u32) -> u32 {
    let (i, n) = (i as i32 + d, cells as i32);
    let i = if i < 0 { i + n } else { i };
    let i = if i < 0 { i + n } else { i };
    let i = if i >= n { i - n } else { i };
    (if i >= n { i - n } else { i }) as u32
}

/// A row or a column of cells near each texel's own.
struct Line {
    /// Column: its index. Row: the first half of [`hash::hash2`] of its index.
    key: [u32; LANES],
    /// From the texel to where the cell's points begin, in cells.
    from: [f32; LANES],
}

/// Where a cell's points lie, along one axis: `start + bits * scale` for 16 random bits.
#[derive(Clone, Copy)]
struct Spread {
    start: f32,
    scale: f32,
}

impl Spread {
    #[inline(always)]
    fn new(jitter: f32) -> Self {
        Self { start: 0.5 + jitter * (0.5 / 65_536.0 - 0.5), scale: jitter * (1.0 / 65_536.0) }
    }
}

/// The points of the cells that a row of texels can see: those of its own row of cells and of two to each side.
struct Points {
    /// Hash of each point, from two cells before the first column to two past the last, row by row.
    hash: Vec<u32>,
    /// Where they lie, each from where its cell's points begin, in cells.
    x: Vec<f32>,
    y: Vec<f32>,
    stride: usize,
}

impl Points {
    #[inline(always)]
    fn around(row: u32, cells: Cells, spread: Spread) -> Self {
        let stride = cells.u as usize + 4;
        let n = 5 * stride;
        let mut points = Self { hash: vec![0; n], x: vec![0.0; n], y: vec![0.0; n], stride };
        for dj in 0..5 {
            let key = hash::pcg(cells.seed ^ neighbour(row, dj as i32 - 2, cells.v));
            let line = dj * stride..(dj + 1) * stride;
            let hashes = &mut points.hash[line.clone()];
            for c in 0..stride {
                let column = (c as u32 + 2 * cells.u - 2) % cells.u;
                hashes[c] = hash::pcg(key.wrapping_add(column));
            }
            let (xs, ys) = (&mut points.x[line.clone()], &mut points.y[line]);
            for c in 0..stride {
                xs[c] = (hashes[c] >> 16) as i32 as f32 * spread.scale;
                ys[c] = (hashes[c] & 0xffff) as i32 as f32 * spread.scale;
            }
        }
        points
    }
}

/// A block of texels of one row that lie in the same cell.
struct InCell<'a> {
    points: &'a Points,
    cell: usize,
    /// Place of the row within the cell.
    y: f32,
    spread: Spread,
}

/// How a block meets the points of the cells around it.
trait Around {
    /// Take the points of these rows and columns of cells, counted from the own cell, into account.
    fn visit<const METRIC: usize>(&self, block: &mut Block, rows: [i32; 2], columns: [i32; 2]);
}

impl Around for InCell<'_> {
    #[inline(always)]
    fn visit<const METRIC: usize>(&self, block: &mut Block, rows: [i32; 2], columns: [i32; 2]) {
        for dj in rows[0]..=rows[1] {
            for di in columns[0]..=columns[1] {
                let k = (dj + 2) as usize * self.points.stride + self.cell + (di + 2) as usize;
                let (h, x) = (self.points.hash[k], self.points.x[k]);
                let dy = self.points.y[k] + (dj as f32 + self.spread.start - self.y);
                for l in 0..LANES {
                    let dx = x + (di as f32 + self.spread.start - block.x[l]);
                    block.meet::<METRIC>(l, dx, dy, h);
                }
            }
        }
    }
}

/// A block of texels whose cells may differ: every texel hashes its own.
struct Hashed {
    cells: Cells,
    spread: Spread,
}

impl Around for Hashed {
    #[inline(always)]
    fn visit<const METRIC: usize>(&self, block: &mut Block, rows: [i32; 2], columns: [i32; 2]) {
        let mut lines = [const { Line { key: [0; LANES], from: [0.0; LANES] } }; 5];
        for di in columns[0]..=columns[1] {
            lines[(di + 2) as usize] = block.column(di, self.cells, self.spread);
        }
        for dj in rows[0]..=rows[1] {
            let row = block.row(dj, self.cells, self.spread);
            for di in columns[0]..=columns[1] {
                let column = &lines[(di + 2) as usize];
                for l in 0..LANES {
                    let h = hash::pcg(row.key[l].wrapping_add(column.key[l]));
                    let dx = (h >> 16) as i32 as f32 * self.spread.scale + column.from[l];
                    let dy = (h & 0xffff) as i32 as f32 * self.spread.scale + row.from[l];
                    block.meet::<METRIC>(l, dx, dy, h);
                }
            }
        }
    }
}

impl Block {
    #[inline(always)]
    fn column(&self, di: i32, cells: Cells, spread: Spread) -> Line {
        let mut line = Line { key: [0; LANES], from: [0.0; LANES] };
        for l in 0..LANES {
            line.key[l] = neighbour(self.i[l], di, cells.u);
            line.from[l] = di as f32 + spread.start - self.x[l];
        }
        line
    }

    #[inline(always)]
    fn row(&self, dj: i32, cells: Cells, spread: Spread) -> Line {
        let mut line = Line { key: [0; LANES], from: [0.0; LANES] };
        for l in 0..LANES {
            line.key[l] = hash::pcg(cells.seed ^ neighbour(self.j[l], dj, cells.v));
            line.from[l] = dj as f32 + spread.start - self.y[l];
        }
        line
    }

    /// Take a point into account, whose hash is `h`.
    #[inline(always)]
    fn meet<const METRIC: usize>(&mut self, l: usize, dx: f32, dy: f32, h: u32) {
        let d = match METRIC {
            0 => dx * dx + dy * dy,
            1 => dx.abs() + dy.abs(),
            _ => greater(dx.abs(), dy.abs()),
        };
        let nearer = d < self.f1[l];
        let loser = greater(d, self.f1[l]);
        self.f2[l] = if loser < self.f2[l] { loser } else { self.f2[l] };
        self.f1[l] = if nearer { d } else { self.f1[l] };
        self.id[l] = if nearer { h } else { self.id[l] };
    }

    /// Search the cells around.
    ///
    /// Points outside the nearest 3 x 3 cells are at least 1 away plus the way to the own cell's side there; where
    /// what was found is farther, that side of the next ring is searched too. Outside 5 x 5 no point can be nearest
    /// or second: the own cell's and one neighbour's points are at most 2 away in each of the three metrics.
    #[inline(always)]
    fn search<const METRIC: usize>(&mut self, around: &impl Around, jitter: f32, second: bool) {
        around.visit::<METRIC>(self, [-1, 1], [-1, 1]);
        let margin = 1.0 + 0.5 * (1.0 - jitter);
        let mut far = [false; 4];
        for l in 0..LANES {
            let (x, y) = (self.x[l], self.y[l]);
            let found = if second { self.f2[l] } else { self.f1[l] };
            let beyond = |side: f32| {
                let safe = (margin + side) * 0.9999;
                found > if METRIC == 0 { safe * safe } else { safe }
            };
            far[0] |= beyond(x);
            far[1] |= beyond(1.0 - x);
            far[2] |= beyond(y);
            far[3] |= beyond(1.0 - y);
        }
        for (side, di) in [(0, -2), (1, 2)] {
            if far[side] {
                around.visit::<METRIC>(self, [-1, 1], [di, di]);
            }
        }
        for (side, dj) in [(2, -2), (3, 2)] {
            if far[side] {
                around.visit::<METRIC>(self, [dj, dj], [-2, 2]);
            }
        }
        if METRIC == 0 {
            for l in 0..LANES {
                self.f1[l] = self.f1[l].sqrt();
                self.f2[l] = self.f2[l].sqrt();
            }
        }
    }
}

/// The first lanes of a slice; a short one is filled with zeros.
#[inline(always)]
fn lanes(values: &[f32]) -> [f32; LANES] {
    if let Ok(whole) = <[f32; LANES]>::try_from(values) {
        return whole;
    }
    let mut lanes = [0.0; LANES];
    for (lane, value) in lanes.iter_mut().zip(values) {
        *lane = *value;
    }
    lanes
}

/// The greater of two numbers: one instruction, unlike `f32::max`, which looks for NaN.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The own cell and the place in it, along one axis.
#[inline(always)]
fn own(t: f32, cells: u32) -> (u32, f32) {
    let low = floor(t);
    let i = to_u32(low);
    (if i >= cells { i - cells } else { i }, t - low)
}

/// Blocks of texels that lie in one cell are common where a cell is at least so many texels wide.
const WIDE: usize = 24;

/// Cellular noise of a row of texels.
///
/// `jitter` in [0, 1]: 0 puts every point at its cell's centre, 1 anywhere in the cell.
/// Source: Steven Worley, "A Cellular Texture Basis Function" (1996), with one point per cell.
pub(in super::super) fn worley(
    at: &Part<'_>,
    cells: Cells,
    metric: Metric,
    jitter: f32,
    out: &mut Bands<'_>,
) {
    match at.row_v() {
        Some(v) if cells.u as usize * WIDE <= at.row_us().len() => {
            along_row(at.us(), v, cells, metric, jitter, out)
        }
        _ => anywhere(at.us(), &at.vs(), cells, metric, jitter, out),
    }
}

impl Block {
    /// Texels at (`u`, `v`), each in [0, 1], that have found nothing yet.
    #[inline(always)]
    fn new(u: &[f32; LANES], v: &[f32; LANES], cells: Cells) -> Self {
        let mut b = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            i: [0; LANES],
            j: [0; LANES],
            f1: [f32::MAX; LANES],
            f2: [f32::MAX; LANES],
            id: [0; LANES],
        };
        for l in 0..LANES {
            let (s, t) = cells.at(u[l], v[l]);
            (b.i[l], b.x[l]) = own(s, cells.u);
            (b.j[l], b.y[l]) = own(t, cells.v);
        }
        b
    }

    #[inline(always)]
    fn search_by(&mut self, metric: Metric, around: &impl Around, jitter: f32, second: bool) {
        match metric {
            Metric::Euclidean => self.search::<0>(around, jitter, second),
            Metric::Manhattan => self.search::<1>(around, jitter, second),
            Metric::Chebyshev => self.search::<2>(around, jitter, second),
        }
    }
}

impl Bands<'_> {
    #[inline(always)]
    fn wants_second(&self) -> bool {
        !self.f2.is_empty() || !self.edge.is_empty()
    }

    /// Put what the first `n` texels of a block have found.
    #[inline(always)]
    fn put(&mut self, b: &Block, first: usize, n: usize) {
        for (band, found) in [(&mut *self.f1, &b.f1), (&mut *self.f2, &b.f2)] {
            if !band.is_empty() {
                put_lanes(found, &mut band[first..first + n]);
            }
        }
        if !self.edge.is_empty() {
            let mut edge = [0.0; LANES];
            for l in 0..LANES {
                edge[l] = b.f2[l] - b.f1[l];
            }
            put_lanes(&edge, &mut self.edge[first..first + n]);
        }
        if !self.id.is_empty() {
            let mut id = [0.0; LANES];
            for l in 0..LANES {
                id[l] = hash::unit(hash::pcg(b.id[l]));
            }
            put_lanes(&id, &mut self.id[first..first + n]);
        }
    }
}

/// As many of the lanes as there is room for.
#[inline(always)]
fn put_lanes(from: &[f32; LANES], to: &mut [f32]) {
    match <&mut [f32; LANES]>::try_from(&mut *to) {
        Ok(whole) => *whole = *from,
        Err(_) => to.copy_from_slice(&from[..to.len()]),
    }
}

multiversion! {
    fn anywhere(us: &[f32], vs: &[f32], cells: Cells, metric: Metric, jitter: f32, out: &mut Bands<'_>) {
        let around = Hashed { cells, spread: Spread::new(jitter) };
        for first in (0..us.len()).step_by(LANES) {
            let n = LANES.min(us.len() - first);
            let mut b = Block::new(&lanes(&us[first..first + n]), &lanes(&vs[first..first + n]), cells);
            b.search_by(metric, &around, jitter, out.wants_second());
            out.put(&b, first, n);
        }
    }
}

multiversion! {
    /// Texels of one `v`: the points that they can see are hashed once.
    fn along_row(us: &[f32], v: f32, cells: Cells, metric: Metric, jitter: f32, out: &mut Bands<'_>) {
        let spread = Spread::new(jitter);
        let (row, y) = own(cells.at(0.0, v).1, cells.v);
        let points = Points::around(row, cells, spread);
        for first in (0..us.len()).step_by(LANES) {
            let n = LANES.min(us.len() - first);
            let mut b = Block::new(&lanes(&us[first..first + n]), &[v; LANES], cells);
            let cell = b.i[0];
            let mut differ = false;
            for l in 0..LANES { differ |= b.i[l] != cell; }
            if differ {
                b.search_by(metric, &Hashed { cells, spread }, jitter, out.wants_second());
            } else {
                let around = InCell { points: &points, cell: cell as usize, y, spread };
                b.search_by(metric, &around, jitter, out.wants_second());
            }
            out.put(&b, first, n);
        }
    }
}
