//! A solved pattern on a grid of its own, sampled to the map.

use crate::base::Domain;
use crate::multiversion;
use crate::node::generate::Part;

/// A solution on the torus, `width x height` values.
///
/// Sampled by the uniform cubic B-spline: never outside the values' range, twice continuously differentiable, and
/// the same shape at every map size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub(super) width: usize,
    pub(super) height: usize,
    /// The values, the first columns and rows repeated past the last ones, so that taps need no wrapping.
    padded: Vec<f32>,
}

/// Taps beside the first one.
const PAD: usize = 3;
/// Texels worked on at once.
const LANES: usize = 16;

/// Where a coordinate's four taps begin, in [0, n), and their weights.
#[inline(always)]
fn taps(t: f32, n: f32) -> (f32, [f32; 4]) {
    // Sample i lies at (i + 0.5) / n; the first tap is one before the sample at or before t. One n keeps it positive.
    let x = t * n + (n - 1.5);
    let low = x.floor();
    let f = x - low;
    let g = 1.0 - f;
    let (f2, g2) = (f * f, g * g);
    let sixth = 1.0 / 6.0;
    let weights = [
        g2 * g * sixth,
        (4.0 - 3.0 * f2 * (2.0 - f)) * sixth,
        (4.0 - 3.0 * g2 * (2.0 - g)) * sixth,
        f2 * f * sixth,
    ];
    // t in [0, 1] gives n - 2 to 2n - 1; for n = 1 it may begin below 0.
    let low = if low >= n { low - n } else { low };
    (if low < 0.0 { low + n } else { low }, weights)
}

/// The four values from `at` on.
#[inline(always)]
fn four(values: &[f32], at: usize) -> [f32; 4] {
    match values[at..].first_chunk() {
        Some(four) => *four,
        None => [0.0; 4],
    }
}

#[inline(always)]
fn weighted(k: [f32; 4], v: [f32; 4]) -> f32 {
    k[0] * v[0] + k[1] * v[1] + k[2] * v[2] + k[3] * v[3]
}

/// Where the taps of a block of texels begin along one axis, and their weights.
#[inline(always)]
fn block(ts: &[f32], n: usize) -> ([f32; LANES], [[f32; 4]; LANES]) {
    let n = n as f32;
    let (mut first, mut weights) = ([0.0; LANES], [[0.0; 4]; LANES]);
    for (l, t) in ts.iter().take(LANES).enumerate() {
        (first[l], weights[l]) = taps(*t, n);
    }
    (first, weights)
}

multiversion! {
    /// Across a line of values with [`PAD`] repeated ones.
    fn along(line: &[f32], us: &[f32], out: &mut [f32]) {
        for (out, us) in out.chunks_mut(LANES).zip(us.chunks(LANES)) {
            let (x, kx) = block(us, line.len() - PAD);
            for (l, o) in out.iter_mut().enumerate() { *o = weighted(kx[l], four(line, x[l] as usize)); }
        }
    }
}

multiversion! {
    fn anywhere(field: &Field, us: &[f32], vs: &[f32], out: &mut [f32]) {
        let stride = field.width + PAD;
        for ((out, us), vs) in out.chunks_mut(LANES).zip(us.chunks(LANES)).zip(vs.chunks(LANES)) {
            let ((x, kx), (y, ky)) = (block(us, field.width), block(vs, field.height));
            for (l, o) in out.iter_mut().enumerate() {
                let at = y[l] as usize * stride + x[l] as usize;
                let (a, b) = (four(&field.padded, at), four(&field.padded, at + stride));
                let (c, d) = (four(&field.padded, at + 2 * stride), four(&field.padded, at + 3 * stride));
                let mut column = [0.0; 4];
                for i in 0..4 { column[i] = weighted(ky[l], [a[i], b[i], c[i], d[i]]); }
                *o = weighted(kx[l], column);
            }
        }
    }
}

impl Field {
    pub(super) fn new(width: usize, height: usize, values: Vec<f32>) -> Self {
        let padded = (0..height + PAD)
            .flat_map(|y| (0..width + PAD).map(move |x| (y % height) * width + x % width))
            .map(|i| values[i])
            .collect();
        Self { width, height, padded }
    }

    /// The values, row by row.
    #[cfg(test)]
    pub(super) fn values(&self) -> Vec<f32> {
        let rows = self.padded.chunks_exact(self.width + PAD).take(self.height);
        rows.flat_map(|row| &row[..self.width]).copied().collect()
    }

    /// Write one row of the map; `line` is scratch that keeps its memory from row to row.
    pub(super) fn sample(&self, at: &Part<'_>, line: &mut Vec<f32>, out: &mut [f32]) {
        let Some(v) = at.row_v() else { return anywhere(self, at.us(), &at.vs(), out) };
        let stride = self.width + PAD;
        let (y, k) = taps(v, self.height as f32);
        let row = |i: usize| &self.padded[(y as usize + i) * stride..][..stride];
        let rows = [row(0), row(1), row(2), row(3)];
        line.clear();
        line.extend((0..stride).map(|x| weighted(k, rows.map(|row| row[x]))));
        along(line, at.us(), out);
    }
}

/// The size of a solver's grid: `cells` periods of `period` texels across the tile's shorter side, texels nearly
/// square in mm but for `stretch`, which makes the pattern so many times longer along the body.
///
/// Where that would exceed [`MAX_TEXELS`] the period gets fewer texels; the second value is what is left of it.
pub(super) fn grid(
    domain: &Domain,
    cells: u32,
    period: f32,
    least: f32,
    stretch: f32,
) -> (usize, usize, f32) {
    let shorter = domain.shorter_mm();
    let stretch = if stretch > 0.0 { stretch.min(16.0).max(1.0 / 16.0) } else { 1.0 };
    let cells = cells.clamp(1, 256) as f32;
    let (u, v) = (cells * domain.girth_mm / shorter, cells * domain.length_mm / shorter / stretch);
    let period = period.min((MAX_TEXELS as f32 / (u * v)).sqrt()).max(least);
    let side = |periods: f32| ((periods * period).round() as usize).clamp(4, MAX_TEXELS / 4);
    let (width, height) = (side(u), side(v));
    // A tile thousands of times longer than wide: give up on square texels rather than on memory.
    (width, height.min((4 * MAX_TEXELS / width).max(4)), period)
}

/// The largest grid that is solved at the full period.
pub(super) const MAX_TEXELS: usize = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::node::Inputs;
    use crate::node::generate::Coords;

    fn sample(field: &Field, domain: &Domain, y: i64, du: f32, dv: &[f32]) -> Vec<f32> {
        let du = vec![du; domain.width];
        let lanes = [Rows::broadcast(&du), Rows::window(dv, domain.width, domain.height, y)];
        let mut at = Coords::new(domain.width);
        at.set(domain, &Inputs::new(&[0, 1, 2], &lanes), 0, y);
        let mut out = vec![0.0; domain.width];
        field.sample(&at.all(), &mut Vec::new(), &mut out);
        out
    }

    #[test]
    fn a_constant_field_is_itself_and_a_linear_one_is_linear_inside() {
        let domain = Domain::square(40);
        let dv = vec![0.0; 40];
        for (w, h) in [(1, 1), (2, 3), (5, 4)] {
            let field = Field::new(w, h, vec![0.25; w * h]);
            for v in sample(&field, &domain, 7, 0.3, &dv) {
                assert!((v - 0.25).abs() < 1e-6);
            }
        }
        // B-splines reproduce straight lines: sample i of 20 lies at (i + 0.5) / 20.
        let values = (0..20 * 20).map(|i| (i % 20) as f32).collect();
        let field = Field::new(20, 20, values);
        let out = sample(&field, &domain, 7, 0.0, &dv);
        for x in 4..36 {
            assert!((out[x] - (domain.u(x) * 20.0 - 0.5)).abs() < 1e-4, "{x}: {}", out[x]);
        }
    }

    #[test]
    fn a_map_of_offsets_and_a_constant_give_the_same_bits() {
        let domain = Domain::square(33);
        let values = (0..7 * 5).map(|i| (i * i % 11) as f32).collect();
        let field = Field::new(7, 5, values);
        let map = sample(&field, &domain, 3, 0.2, &[-0.4; 33]);
        let (du, dv) = (vec![0.2; 33], vec![-0.4; 33]);
        let lanes = [Rows::broadcast(&du), Rows::broadcast(&dv)];
        let mut at = Coords::new(33);
        at.set(&domain, &Inputs::new(&[0, 1, 2], &lanes), 0, 3);
        let mut out = vec![0.0; 33];
        field.sample(&at.all(), &mut Vec::new(), &mut out);
        assert_eq!(out, map);
    }

    #[test]
    fn the_grid_follows_the_tile_and_stays_small() {
        let d = Domain { width: 10, height: 10, girth_mm: 50.0, length_mm: 100.0 };
        assert_eq!(grid(&d, 4, 16.0, 8.0, 1.0), (64, 128, 16.0));
        assert_eq!(grid(&d, 4, 16.0, 8.0, 2.0), (64, 64, 16.0));
        let long = Domain { length_mm: 1e9, ..d };
        let (w, h, _) = grid(&long, 256, 16.0, 8.0, 0.0);
        assert!(w * h <= 4 * MAX_TEXELS && w >= 4 && h >= 4);
    }
}
