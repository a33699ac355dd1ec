//! The grid a graph is evaluated on.

/// The grid of one tile: its size in texels and its physical size.
///
/// `u` runs around the body (x, `width` texels, `girth_mm`), `v` along it tail-ward (y, `height` texels, `length_mm`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Texels around the body.
    pub width: usize,
    /// Texels along the body.
    pub height: usize,
    /// Physical width of the tile, mm: the whole girth.
    pub girth_mm: f32,
    /// Physical height of the tile, mm.
    pub length_mm: f32,
}

/// The largest side, in texels, that any command accepts.
pub const MAX_SIDE: usize = 65_536;

impl Domain {
    /// A square tile of `size` texels and 100 mm, for tests and node previews.
    pub fn square(size: usize) -> Self {
        Self { width: size, height: size, girth_mm: 100.0, length_mm: 100.0 }
    }

    /// The domain whose longer side has `longer` texels and whose texels are as square as whole numbers allow.
    pub fn from_longer_side(longer: usize, girth_mm: f32, length_mm: f32) -> Self {
        let ratio = f64::from(girth_mm) / f64::from(length_mm);
        let round = |x: f64| (x.round() as usize).max(1);
        let (width, height) = if ratio >= 1.0 {
            (longer, round(longer as f64 / ratio))
        } else {
            (round(longer as f64 * ratio), longer)
        };
        Self { width, height, girth_mm, length_mm }
    }

    /// Texels in the tile.
    pub fn texels(&self) -> usize {
        self.width * self.height
    }

    /// Size of a texel around the body, mm.
    pub fn texel_u_mm(&self) -> f32 {
        self.girth_mm / self.width as f32
    }

    /// Size of a texel along the body, mm.
    pub fn texel_v_mm(&self) -> f32 {
        self.length_mm / self.height as f32
    }

    /// Size of a texel, mm: the geometric mean of its sides.
    pub fn texel_mm(&self) -> f32 {
        (self.texel_u_mm() * self.texel_v_mm()).sqrt()
    }

    /// `u` of the centre of column `x`, in [0, 1).
    #[inline(always)]
    pub fn u(&self, x: usize) -> f32 {
        (x as f32 + 0.5) / self.width as f32
    }

    /// `v` of the centre of row `y`, in [0, 1). `y` may lie outside the tile; it is not wrapped.
    #[inline(always)]
    pub fn v(&self, y: i64) -> f32 {
        (y as f32 + 0.5) / self.height as f32
    }

    /// The shorter physical side, mm.
    pub fn shorter_mm(&self) -> f32 {
        self.girth_mm.min(self.length_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longer_side_keeps_texels_square() {
        let d = Domain::from_longer_side(2048, 53.4, 92.0);
        assert_eq!((d.width, d.height), (1189, 2048));
        assert!((d.texel_u_mm() / d.texel_v_mm() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn extreme_ratios_keep_one_texel() {
        let d = Domain::from_longer_side(4, 1.0, 1e6);
        assert_eq!((d.width, d.height), (1, 4));
    }
}
