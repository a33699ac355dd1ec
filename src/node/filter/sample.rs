//! Bilinear look-up at many points of the torus: the core of the warps and of `transform`.

use crate::base::Rows;
use crate::multiversion;

/// Every row of an input, wrapped once for a whole band.
pub(super) struct Sampler<'a> {
    rows: Vec<&'a [f32]>,
    constant: Option<f32>,
}

/// Where to look: whole texels and fractions, for one row of texels.
#[derive(Default)]
pub(super) struct Points {
    column: Vec<i32>,
    row: Vec<i32>,
    tu: Vec<f32>,
    tv: Vec<f32>,
}

impl<'a> Sampler<'a> {
    /// A sampler of `image`, a torus `height` texels high.
    pub(super) fn new(image: Rows<'a>, height: usize) -> Self {
        Self { rows: (0..height as i64).map(|y| image.row(y)).collect(), constant: image.constant() }
    }

    /// The image moved by (`du`, `dv`) tile fractions: `out[x] = image(u + du, v + dv)` on row `y`.
    ///
    /// A shift of whole texels is exact; one that is not finite counts as 0.
    pub(super) fn moved(&self, y: usize, du: &[f32], dv: &[f32], points: &mut Points, out: &mut [f32]) {
        if let Some(value) = self.constant {
            out.fill(value);
            return;
        }
        let (width, height) = (out.len(), self.rows.len());
        points.resize(width);
        let Points { column, row, tu, tv } = points;
        split(du, width as f32, width as i32, 0, 1, column, tu);
        split(dv, height as f32, height as i32, y as i32, 0, row, tv);
        for (x, o) in out.iter_mut().enumerate() {
            *o = self.between(column[x] as usize, row[x] as usize, tu[x], tv[x]);
        }
    }

    /// The image at texel coordinates from texel centres: (0, 0) is the centre of the first texel. Wrapped.
    pub(super) fn at(&self, x: f64, y: f64) -> f32 {
        if let Some(value) = self.constant {
            return value;
        }
        let (x0, y0) = (x.floor(), y.floor());
        let wrap = |i: f64, n: usize| (i as i64).rem_euclid(n as i64) as usize;
        let (column, row) = (wrap(x0, self.rows[0].len()), wrap(y0, self.rows.len()));
        self.between(column, row, (x - x0) as f32, (y - y0) as f32)
    }

    #[inline(always)]
    fn between(&self, x: usize, y: usize, tu: f32, tv: f32) -> f32 {
        let (r0, r1) = (self.rows[y], self.rows[if y + 1 == self.rows.len() { 0 } else { y + 1 }]);
        let x1 = if x + 1 == r0.len() { 0 } else { x + 1 };
        // Weighted sums: exact at the ends, and huge values of unlike sign do not overflow.
        let a = r0[x] * (1.0 - tu) + r0[x1] * tu;
        let b = r1[x] * (1.0 - tu) + r1[x1] * tu;
        a * (1.0 - tv) + b * tv
    }
}

impl Points {
    fn resize(&mut self, n: usize) {
        self.column.resize(n, 0);
        self.row.resize(n, 0);
        self.tu.resize(n, 0.0);
        self.tv.resize(n, 0.0);
    }
}

multiversion! {
    // Texel `start + step * i` of `n`, moved by `shift` tiles and wrapped, as a whole texel and a fraction.
    fn split(shift: &[f32], size: f32, n: i32, start: i32, step: i32, whole: &mut [i32], part: &mut [f32]) {
        for (i, ((s, w), p)) in shift.iter().zip(whole).zip(part).enumerate() {
            // Into [0, 1] tiles first: then the product is at most n, whatever the shift was.
            let s = if s.abs() <= 1e9 { *s } else { 0.0 };
            let texels = (s - s.floor()) * size;
            let floor = texels.floor();
            *p = texels - floor;
            let at = floor as i32 + start + step * i as i32;
            let at = if at >= n { at - n } else { at };
            *w = if at >= n { at - n } else { at };
        }
    }
}
