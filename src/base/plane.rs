//! One f32 image on the torus, and windows of its rows.

/// A single-channel f32 image, row-major, `width x height` texels, toroidal in both directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    width: usize,
    height: usize,
    data: Vec<f32>,
}

impl Plane {
    /// A plane filled with `value`.
    pub fn filled(width: usize, height: usize, value: f32) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// A plane over existing texels, row-major.
    ///
    /// # Panics
    /// If `data.len() != width * height`: a broken invariant of the caller.
    pub fn from_vec(width: usize, height: usize, data: Vec<f32>) -> Self {
        assert_eq!(data.len(), width * height, "plane data does not match its size");
        Self { width, height, data }
    }

    /// A plane made texel by texel: `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Self {
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                data.push(f(x, y));
            }
        }
        Self { width, height, data }
    }

    /// Width in texels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All texels, row-major.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// All texels, row-major, to write.
    pub fn data_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// The texels, row-major, giving up the plane.
    pub fn into_vec(self) -> Vec<f32> {
        self.data
    }

    /// Row `y`, wrapped into the torus.
    pub fn row(&self, y: i64) -> &[f32] {
        let y = y.rem_euclid(self.height as i64) as usize;
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// The texel at (`x`, `y`), both wrapped into the torus.
    pub fn at(&self, x: i64, y: i64) -> f32 {
        self.row(y)[x.rem_euclid(self.width as i64) as usize]
    }

    /// All rows as a window.
    pub fn rows(&self) -> Rows<'_> {
        Rows {
            data: &self.data,
            width: self.width,
            height: self.height as i64,
            first: 0,
            count: self.height as i64,
        }
    }

    /// The plane moved by (`dx`, `dy`) texels on the torus: `out(x, y) = self(x - dx, y - dy)`.
    pub fn shifted(&self, dx: i64, dy: i64) -> Self {
        Self::from_fn(self.width, self.height, |x, y| self.at(x as i64 - dx, y as i64 - dy))
    }

    /// Half the size in each direction by the mean of 2x2 texels; an odd last row or column is dropped.
    pub fn halved(&self) -> Self {
        let (w, h) = ((self.width / 2).max(1), (self.height / 2).max(1));
        Self::from_fn(w, h, |x, y| {
            let (x, y) = (2 * x as i64, 2 * y as i64);
            0.25 * (self.at(x, y) + self.at(x + 1, y) + self.at(x, y + 1) + self.at(x + 1, y + 1))
        })
    }
}

/// A window of rows of a plane on the torus: what a kernel may read.
///
/// A window over one repeated row stands for a constant input, so a kernel never has to know.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    data: &'a [f32],
    width: usize,
    /// Height of the whole torus, for wrapping.
    height: i64,
    /// The torus row that `data` starts with.
    first: i64,
    /// Rows in `data`; 0 for a constant, whose one row answers for every y.
    count: i64,
}

impl<'a> Rows<'a> {
    /// The window `first .. first + data.len() / width` of a torus `height` rows high.
    pub fn window(data: &'a [f32], width: usize, height: usize, first: i64) -> Self {
        Self { data, width, height: height as i64, first, count: (data.len() / width) as i64 }
    }

    /// One row that answers for every y: a constant.
    pub fn broadcast(row: &'a [f32]) -> Self {
        Self { data: row, width: row.len(), height: 1, first: 0, count: 0 }
    }

    /// Texels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The value, where this window is a constant.
    pub fn constant(&self) -> Option<f32> {
        (self.count == 0).then(|| self.data[0])
    }

    /// Row `y`, wrapped on the torus.
    ///
    /// # Panics
    /// If the row lies outside the window: the node read beyond its declared reach.
    #[inline]
    pub fn row(&self, y: i64) -> &'a [f32] {
        if self.count == 0 {
            return self.data;
        }
        let i = (y - self.first).rem_euclid(self.height);
        assert!(i < self.count, "a node read row {y}, outside its declared reach");
        let start = i as usize * self.width;
        &self.data[start..start + self.width]
    }

    /// The texel at (`x`, `y`), both wrapped on the torus.
    #[inline]
    pub fn at(&self, x: i64, y: i64) -> f32 {
        self.row(y)[x.rem_euclid(self.width as i64) as usize]
    }

    /// Bilinear sample at texel coordinates (`x`, `y`), where texel centres lie at integer + 0.5; toroidal.
    ///
    /// A non-finite coordinate reads as 0.
    #[inline]
    pub fn bilinear(&self, x: f32, y: f32) -> f32 {
        if let Some(c) = self.constant() {
            return c;
        }
        let (x, y) = (finite_or_zero(x) - 0.5, finite_or_zero(y) - 0.5);
        let (fx, fy) = (x.floor(), y.floor());
        let (tx, ty) = (x - fx, y - fy);
        let (x0, y0) = (fx as i64, fy as i64);
        let (r0, r1) = (self.row(y0), self.row(y0.wrapping_add(1)));
        let w = self.width as i64;
        let (i0, i1) = (x0.rem_euclid(w) as usize, x0.wrapping_add(1).rem_euclid(w) as usize);
        let a = r0[i0] + (r0[i1] - r0[i0]) * tx;
        let b = r1[i0] + (r1[i1] - r1[i0]) * tx;
        a + (b - a) * ty
    }
}

fn finite_or_zero(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_wrap_on_the_torus() {
        let p = Plane::from_fn(3, 4, |x, y| (10 * y + x) as f32);
        assert_eq!(p.at(-1, -1), 32.0);
        assert_eq!(p.rows().row(5), &[10.0, 11.0, 12.0]);
        assert_eq!(p.shifted(1, 2).at(1, 2), p.at(0, 0));
    }

    #[test]
    fn bilinear_is_exact_at_texel_centres_and_never_nan() {
        let p = Plane::from_fn(4, 4, |x, y| (x * y) as f32);
        assert_eq!(p.rows().bilinear(2.5, 3.5), 6.0);
        assert!(p.rows().bilinear(f32::NAN, f32::INFINITY).is_finite());
    }
}
