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

impl Block {
    /// Take the point of the cell at (`di`, `dj`) from the own cell into account.
    #[inline(always)]
    fn visit<const METRIC: usize>(
        &mut self,
        rows: &[u32; LANES],
        di: i32,
        dj: i32,
        cells: Cells,
        jitter: f32,
    ) {
        for l in 0..LANES {
            let h = hash::pcg(rows[l].wrapping_add(neighbour(self.i[l], di, cells.u)));
            let at = |bits: u32| ((bits as i32 as f32 + 0.5) * (1.0 / 65_536.0) - 0.5) * jitter + 0.5;
            let dx = (at(h >> 16) + di as f32 - self.x[l]).abs();
            let dy = (at(h & 0xffff) + dj as f32 - self.y[l]).abs();
            let d = match METRIC {
                0 => dx * dx + dy * dy,
                1 => dx + dy,
                _ => {
                    if dx > dy {
                        dx
                    } else {
                        dy
                    }
                }
            };
            let nearer = d < self.f1[l];
            let loser = if nearer { self.f1[l] } else { d };
            self.f2[l] = if loser < self.f2[l] { loser } else { self.f2[l] };
            self.f1[l] = if nearer { d } else { self.f1[l] };
            self.id[l] = if nearer { h } else { self.id[l] };
        }
    }

    /// The first half of [`hash::hash2`] of the rows at `dj`.
    #[inline(always)]
    fn rows(&self, dj: i32, cells: Cells) -> [u32; LANES] {
        let mut rows = [0; LANES];
        for l in 0..LANES {
            rows[l] = hash::pcg(cells.seed ^ neighbour(self.j[l], dj, cells.v));
        }
        rows
    }

    /// Search the cells around.
    ///
    /// Points outside the nearest 3 x 3 cells are at least 1 away plus the way to the own cell's nearest side; where
    /// what was found is farther, the next ring is searched too. Outside 5 x 5 no point can be nearest or second:
    /// the own cell's and one neighbour's points are at most 2 away in each of the three metrics.
    #[inline(always)]
    fn search<const METRIC: usize>(&mut self, cells: Cells, jitter: f32, second: bool) {
        for dj in -1..=1 {
            let rows = self.rows(dj, cells);
            for di in -1..=1 {
                self.visit::<METRIC>(&rows, di, dj, cells, jitter);
            }
        }
        let margin = 1.0 + 0.5 * (1.0 - jitter);
        let mut far = false;
        for l in 0..LANES {
            let (x, y) = (self.x[l], self.y[l]);
            let side = x.min(1.0 - x).min(y.min(1.0 - y));
            let safe = (margin + side) * 0.9999;
            let safe = if METRIC == 0 { safe * safe } else { safe };
            let found = if second { self.f2[l] } else { self.f1[l] };
            far |= found > safe;
        }
        if far {
            for dj in -2i32..=2 {
                let rows = self.rows(dj, cells);
                for di in -2i32..=2 {
                    if di.abs() == 2 || dj.abs() == 2 {
                        self.visit::<METRIC>(&rows, di, dj, cells, jitter);
                    }
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
            let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
            u[..n].copy_from_slice(&us[first..first + n]);
            v[..n].copy_from_slice(&vs[first..first + n]);
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
