//! Cellular noise: distances to the two nearest of one random point per cell.

use super::{Cells, floor, to_u32};
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

    /// Take the point of the cell where `row` and `column` cross into account.
    #[inline(always)]
    fn visit<const METRIC: usize>(&mut self, row: &Line, column: &Line, spread: Spread) {
        for l in 0..LANES {
            let h = hash::pcg(row.key[l].wrapping_add(column.key[l]));
            let dx = (h >> 16) as i32 as f32 * spread.scale + column.from[l];
            let dy = (h & 0xffff) as i32 as f32 * spread.scale + row.from[l];
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
    }

    /// Search the cells around.
    ///
    /// Points outside the nearest 3 x 3 cells are at least 1 away plus the way to the own cell's side there; where
    /// what was found is farther, that side of the next ring is searched too. Outside 5 x 5 no point can be nearest
    /// or second: the own cell's and one neighbour's points are at most 2 away in each of the three metrics.
    #[inline(always)]
    fn search<const METRIC: usize>(&mut self, cells: Cells, jitter: f32, second: bool) {
        let spread = Spread::new(jitter);
        let columns =
            [self.column(-1, cells, spread), self.column(0, cells, spread), self.column(1, cells, spread)];
        for dj in -1..=1 {
            let row = self.row(dj, cells, spread);
            for column in &columns {
                self.visit::<METRIC>(&row, column, spread);
            }
        }
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
                let column = self.column(di, cells, spread);
                for dj in -1..=1 {
                    let row = self.row(dj, cells, spread);
                    self.visit::<METRIC>(&row, &column, spread);
                }
            }
        }
        for (side, dj) in [(2, -2), (3, 2)] {
            if far[side] {
                let row = self.row(dj, cells, spread);
                for di in -2..=2 {
                    let column = self.column(di, cells, spread);
                    self.visit::<METRIC>(&row, &column, spread);
                }
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

multiversion! {
    /// Cellular noise of a row of texels at (`us`, `vs`), each in [0, 1].
    ///
    /// `jitter` in [0, 1]: 0 puts every point at its cell's centre, 1 anywhere in the cell.
    /// Source: Steven Worley, "A Cellular Texture Basis Function" (1996), with one point per cell.
    pub(in super::super) fn worley(
        us: &[f32], vs: &[f32], cells: Cells, metric: Metric, jitter: f32, out: &mut Bands<'_>,
    ) {
        let second = !out.f2.is_empty() || !out.edge.is_empty();
        for first in (0..us.len()).step_by(LANES) {
            let n = LANES.min(us.len() - first);
            let (u, v) = (lanes(&us[first..first + n]), lanes(&vs[first..first + n]));
            let mut b = Block {
                x: [0.0; LANES], y: [0.0; LANES], i: [0; LANES], j: [0; LANES],
                f1: [f32::MAX; LANES], f2: [f32::MAX; LANES], id: [0; LANES],
            };
            for l in 0..LANES {
                let (s, t) = cells.at(u[l], v[l]);
                (b.i[l], b.x[l]) = own(s, cells.u);
                (b.j[l], b.y[l]) = own(t, cells.v);
            }
            match metric {
                Metric::Euclidean => b.search::<0>(cells, jitter, second),
                Metric::Manhattan => b.search::<1>(cells, jitter, second),
                Metric::Chebyshev => b.search::<2>(cells, jitter, second),
            }
            if !out.f1.is_empty() { out.f1[first..first + n].copy_from_slice(&b.f1[..n]); }
            if !out.f2.is_empty() { out.f2[first..first + n].copy_from_slice(&b.f2[..n]); }
            if !out.edge.is_empty() {
                for l in 0..n { out.edge[first + l] = b.f2[l] - b.f1[l]; }
            }
            if !out.id.is_empty() {
                for l in 0..n { out.id[first + l] = hash::unit(hash::pcg(b.id[l])); }
            }
        }
    }
}
