//! The picture while it is made: sums, and what they say about their own error.

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Samples so far.
    pub count: u32,
    /// Sum of their linear sRGB.
    pub sum: [f64; 3],
    /// Sum of the squares.
    pub squares: [f64; 3],
    /// Sum of the albedo of the first hit.
    pub albedo: [f32; 3],
    /// Sum of the shading normal of the first hit, in the world.
    pub normal: [f32; 3],
    /// Sum of the film thickness of the first hit, nm.
    pub thickness_nm: f32,
    /// Samples that met an object.
    pub hits: u32,
}

impl Pixel {
    /// Add the colour of a sample.
    #[inline]
    pub(super) fn add(&mut self, rgb: [f32; 3]) {
        self.count += 1;
        for c in 0..3 {
            let x = f64::from(rgb[c]);
            self.sum[c] += x;
            self.squares[c] += x * x;
        }
    }

    /// Mean of the samples, linear sRGB; black without any.
    pub fn rgb(&self) -> [f32; 3] {
        let n = f64::from(self.count.max(1));
        self.sum.map(|s| (s / n) as f32)
    }

    /// Variance of that mean, if samples were independent: `(mean of squares - square of mean)/(n - 1)`. Stratified samples
    /// have less. 0 with fewer than two samples.
    pub fn variance(&self) -> [f32; 3] {
        if self.count < 2 {
            return [0.0; 3];
        }
        let n = f64::from(self.count);
        std::array::from_fn(|c| {
            let mean = self.sum[c] / n;
            ((self.squares[c] / n - mean * mean).max(0.0) / (n - 1.0)) as f32
        })
    }
}

/// A picture of pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub pixels: Vec<Pixel>,
}

impl Film {
    /// Black, without samples.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![Pixel::default(); width * height] }
    }

    /// Linear sRGB of every pixel.
    pub fn rgb(&self) -> Vec<[f32; 3]> {
        self.pixels.iter().map(Pixel::rgb).collect()
    }

    /// Samples per pixel, on average: less than asked for where the work was stopped.
    pub fn samples_per_pixel(&self) -> f64 {
        let total: f64 = self.pixels.iter().map(|p| f64::from(p.count)).sum();
        total / self.pixels.len().max(1) as f64
    }

    /// Standard error of the picture as it is estimated from its samples: root of the mean variance over pixels and
    /// channels. An upper bound for stratified samples.
    pub fn noise(&self) -> f64 {
        let sum: f64 = self.pixels.iter().flat_map(Pixel::variance).map(f64::from).sum();
        (sum / (3 * self.pixels.len()).max(1) as f64).sqrt()
    }

    /// Named planes for an OpenEXR file: colour, variance of the colour, and what was hit first (albedo, normal in the
    /// world, film thickness in nm, share of samples that met an object).
    pub fn channels(&self) -> Vec<(&'static str, Vec<f32>)> {
        let plane = |f: &dyn Fn(&Pixel) -> f32| self.pixels.iter().map(f).collect::<Vec<f32>>();
        let mean = |x: f32, p: &Pixel| if p.hits > 0 { x / p.hits as f32 } else { 0.0 };
        vec![
            ("R", plane(&|p| p.rgb()[0])),
            ("G", plane(&|p| p.rgb()[1])),
            ("B", plane(&|p| p.rgb()[2])),
            ("A", plane(&|p| p.hits as f32 / p.count.max(1) as f32)),
            ("variance.R", plane(&|p| p.variance()[0])),
            ("variance.G", plane(&|p| p.variance()[1])),
            ("variance.B", plane(&|p| p.variance()[2])),
            ("albedo.R", plane(&|p| mean(p.albedo[0], p))),
            ("albedo.G", plane(&|p| mean(p.albedo[1], p))),
            ("albedo.B", plane(&|p| mean(p.albedo[2], p))),
            ("normal.X", plane(&|p| mean(p.normal[0], p))),
            ("normal.Y", plane(&|p| mean(p.normal[1], p))),
            ("normal.Z", plane(&|p| mean(p.normal[2], p))),
            ("film.thickness_nm", plane(&|p| mean(p.thickness_nm, p))),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_the_textbook_ones() {
        let mut pixel = Pixel::default();
        assert_eq!((pixel.rgb(), pixel.variance()), ([0.0; 3], [0.0; 3]));
        for x in [1.0, 2.0, 3.0, 6.0] {
            pixel.add([x, 5.0, 0.0]);
        }
        assert_eq!(pixel.rgb(), [3.0, 5.0, 0.0]);
        // Sample variance 14/3, of the mean 14/12.
        assert!((pixel.variance()[0] - 14.0 / 12.0).abs() < 1e-6);
        assert_eq!(pixel.variance()[1], 0.0);
    }
}
