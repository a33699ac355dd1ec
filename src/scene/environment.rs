//! What is all around: a sky, a studio, a picture, or nothing.

mod sampler;

use std::sync::Arc;

use glam::Vec3;

use crate::base::{LinearRgb, Plane, num};
pub use sampler::{EnvironmentSample, EnvironmentSampler};

/// Radiance from every direction, relative to D65.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same from everywhere; black is none.
    Constant(LinearRgb),
    /// An equirectangular picture: rows from the zenith (y up) to the nadir, columns once around.
    Image(Arc<EnvironmentImage>),
}

/// An equirectangular picture, as read from a file or computed from a formula: see [`EnvironmentImage::new`].
///
/// Its middle lies in the direction -z, where a viewer on +z looks; columns grow to +x, rows from +y to -y.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Radiance, row by row; finite and not negative.
    pub texels: Vec<[f32; 3]>,
}

/// Why a picture is no environment.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EnvironmentError {
    /// It has no texels, or not as many as its size says.
    #[error("an environment of {width} x {height} texels has {texels}")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Texels.
        texels: usize,
    },
    /// It has neither one plane nor three of equal size.
    #[error("an environment has red, green and blue planes of one size, or one grey one")]
    Planes,
    /// A texel is negative, infinite or NaN.
    #[error("texel {x}, {y} of the environment is ({}, {}, {}): radiance is finite and not negative", .texel[0], .texel[1], .texel[2])]
    Texel {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// Its value.
        texel: [f32; 3],
    },
}

impl Environment {
    /// Radiance from a direction (a unit vector).
    #[inline(always)]
    pub fn radiance(&self, direction: Vec3) -> LinearRgb {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Image(image) => image.radiance(direction),
        }
    }

    /// Radiance from several directions (unit vectors) at once.
    #[inline(always)]
    pub fn radiances<const N: usize>(&self, directions: &[Vec3; N]) -> [LinearRgb; N] {
        match self {
            Self::Constant(radiance) => [*radiance; N],
            Self::Image(image) => image.radiances(directions),
        }
    }

    /// Mean radiance over all directions.
    pub fn mean_radiance(&self) -> LinearRgb {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Image(image) => image.mean_radiance(),
        }
    }

    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(LinearRgb(c)) => c.iter().all(|&c| c <= 0.0),
            Self::Image(image) => image.texels.iter().flatten().all(|&c| c <= 0.0),
        }
    }
}

impl EnvironmentImage {
    /// A picture whose every texel is finite and not negative.
    ///
    /// # Errors
    /// Otherwise, naming the first such texel.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Result<Self, EnvironmentError> {
        if texels.is_empty() || width.checked_mul(height) != Some(texels.len()) {
            return Err(EnvironmentError::Size { width, height, texels: texels.len() });
        }
        let bad = |texel: &[f32; 3]| !texel.iter().all(|c| c.is_finite() && *c >= 0.0);
        if let Some(i) = texels.iter().position(bad) {
            return Err(EnvironmentError::Texel { x: i % width, y: i / width, texel: texels[i] });
        }
        Ok(Self { width, height, texels })
    }

    /// A picture from planes, as an image file is read: red, green and blue, or one for all. Radiance is linear: pictures
    /// that were encoded for screens are to be decoded before.
    ///
    /// # Errors
    /// Unless there are one or three planes of equal size, and every texel is finite and not negative.
    pub fn from_planes(planes: &[Plane]) -> Result<Self, EnvironmentError> {
        let (r, g, b) = match planes {
            [r, g, b] => (r, g, b),
            [gray] => (gray, gray, gray),
            _ => return Err(EnvironmentError::Planes),
        };
        let (width, height) = (r.width(), r.height());
        if [g, b].iter().any(|p| (p.width(), p.height()) != (width, height)) {
            return Err(EnvironmentError::Planes);
        }
        let texels = r.data().iter().zip(g.data()).zip(b.data());
        Self::new(width, height, texels.map(|((r, g), b)| [*r, *g, *b]).collect())
    }

    /// The picture of a function of the direction; what is negative or not finite becomes 0.
    pub fn from_fn(width: usize, height: usize, f: impl Fn(Vec3) -> LinearRgb) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let clean = |c: f32| if c.is_finite() { c.max(0.0) } else { 0.0 };
        let texels = (0..width * height)
            .map(|i| {
                let uv = [(i % width) as f32 + 0.5, (i / width) as f32 + 0.5];
                f(direction_of(uv[0] / width as f32, uv[1] / height as f32)).0.map(clean)
            })
            .collect();
        Self { width, height, texels }
    }

    /// Radiance from a direction (a unit vector): bilinear between texel centres, around the columns and up to the
    /// poles' rows.
    #[inline(always)]
    pub fn radiance(&self, direction: Vec3) -> LinearRgb {
        self.radiance_at(place_of(direction))
    }

    /// The same from several directions at once, as lanes.
    #[inline(always)]
    fn radiances<const N: usize>(&self, directions: &[Vec3; N]) -> [LinearRgb; N] {
        let places = places_of(directions);
        let mut radiances = [LinearRgb([0.0; 3]); N];
        for i in 0..N {
            radiances[i] = self.radiance_at(places[i]);
        }
        radiances
    }

    /// Radiance at a place of the picture.
    #[inline(always)]
    fn radiance_at(&self, [u, v]: [f32; 2]) -> LinearRgb {
        let (width, height) = (self.width as i32, self.height as i32);
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (fx, fy) = (x.floor(), y.floor());
        let (tx, ty) = (x - fx, y - fy);
        // Of 32 bits: one instruction. From -1 to width - 1.
        let (x0, y0) = (fx as i32, fy as i32);
        let x0 = if x0 < 0 { width - 1 } else { x0.min(width - 1) };
        let x1 = if x0 + 1 == width { 0 } else { x0 + 1 };
        let (y0, y1) = (y0.max(0).min(height - 1), (y0 + 1).max(0).min(height - 1));
        let row = |y: i32| {
            let row = &self.texels[y as usize * self.width..][..self.width];
            let (a, b) = (row[x0 as usize], row[x1 as usize]);
            [num::lerp(a[0], b[0], tx), num::lerp(a[1], b[1], tx), num::lerp(a[2], b[2], tx)]
        };
        let (a, b) = (row(y0), row(y1));
        LinearRgb([num::lerp(a[0], b[0], ty), num::lerp(a[1], b[1], ty), num::lerp(a[2], b[2], ty)])
    }

    /// The direction of the middle of a texel, a unit vector.
    pub fn direction(&self, x: usize, y: usize) -> Vec3 {
        direction_of((x as f32 + 0.5) / self.width as f32, (y as f32 + 0.5) / self.height as f32)
    }

    /// Mean radiance over all directions: each texel by its solid angle.
    pub fn mean_radiance(&self) -> LinearRgb {
        let mut sum = [0.0_f64; 3];
        for (y, row) in self.texels.chunks_exact(self.width).enumerate() {
            let share = row_share(y, self.height) / self.width as f64;
            for texel in row {
                (0..3).for_each(|c| sum[c] += f64::from(texel[c]) * share);
            }
        }
        LinearRgb(sum.map(|s| s as f32))
    }

    /// The picture times `factor`.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.texels.iter_mut().flatten().for_each(|c| *c *= factor);
        self
    }

    /// The picture turned around the vertical by `turns` (towards +x where it looked along -z), to the nearest column.
    pub fn turned(mut self, turns: f32) -> Self {
        let columns = ((num::fract(turns) * self.width as f32 + 0.5) as usize) % self.width;
        self.texels.chunks_exact_mut(self.width).for_each(|row| row.rotate_right(columns));
        self
    }
}

/// The direction at (`u`, `v`) of an equirectangular picture.
fn direction_of(u: f32, v: f32) -> Vec3 {
    let radius = num::sin_turns(0.5 * v);
    Vec3::new(num::sin_turns(u - 0.5) * radius, num::cos_turns(0.5 * v), -num::cos_turns(u - 0.5) * radius)
}

/// Where a direction lies in an equirectangular picture, both in [0, 1].
#[inline(always)]
fn place_of(d: Vec3) -> [f32; 2] {
    let [around, down] = angles_turns([d.x, (d.x * d.x + d.z * d.z).sqrt()], [-d.z, d.y]);
    [num::saturate(0.5 + around), num::saturate(2.0 * down)]
}

/// [`place_of`] several directions at once.
#[inline(always)]
fn places_of<const N: usize>(directions: &[Vec3; N]) -> [[f32; 2]; N] {
    let (mut x, mut y, mut back, mut radius) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    for i in 0..N {
        (x[i], y[i], back[i]) = (directions[i].x, directions[i].y, -directions[i].z);
    }
    for i in 0..N {
        radius[i] = (x[i] * x[i] + back[i] * back[i]).sqrt();
    }
    let (around, down) = (angles_turns(x, back), angles_turns(radius, y));
    let mut places = [[0.0; 2]; N];
    for i in 0..N {
        places[i] = [num::saturate(0.5 + around[i]), num::saturate(2.0 * down[i])];
    }
    places
}

/// [`num::atan2_turns`] of several at once, within 1e-6 of it: as lanes, with one division.
#[inline(always)]
fn angles_turns<const N: usize>(y: [f32; N], x: [f32; N]) -> [f32; N] {
    // Plain code: closures handed to std are not compiled for wider instruction sets.
    let mut turns = [0.0; N];
    for i in 0..N {
        let (y, x) = (y[i], x[i]);
        let (ax, ay) = (x.abs(), y.abs());
        let (lo, hi) = (ax.min(ay), ax.max(ay).max(f32::MIN_POSITIVE));
        // atan(t) = pi/4 + atan((t - 1)/(t + 1)), where t = lo/hi is above tan(pi/8).
        let far = lo > 0.414_213_57 * hi;
        let (over, under) = if far { (lo - hi, lo + hi) } else { (lo, hi) };
        let a = (if far { 0.125 } else { 0.0 }) + num::atan_turns(over / under);
        let a = if ay > ax { 0.25 - a } else { a };
        let a = if x < 0.0 { 0.5 - a } else { a };
        turns[i] = if y < 0.0 { -a } else { a };
    }
    turns
}

/// Share of the sphere that row `y` covers.
fn row_share(y: usize, height: usize) -> f64 {
    0.5 * (row_cos(y, height) - row_cos(y + 1, height))
}

/// Cosine from the zenith of the upper edge of row `y`.
fn row_cos(y: usize, height: usize) -> f64 {
    libm::cos(std::f64::consts::PI * y as f64 / height as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small, bright, coloured spot on a dim ramp, with black rows and columns.
    pub(super) fn spotted(width: usize, height: usize) -> EnvironmentImage {
        let mut texels = vec![[0.0; 3]; width * height];
        for y in 0..height {
            for x in width / 3..width {
                texels[y * width + x] = [0.1, 0.2 * (y as f32 / height as f32), 0.05];
            }
        }
        texels[(height / 4) * width + width / 8] = [900.0, 700.0, 400.0];
        EnvironmentImage::new(width, height, texels).expect("sound")
    }

    pub(super) fn grid(n: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..n * n).map(move |i| [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32))
    }

    /// The integral of f over the sphere, evenly in height and azimuth.
    pub(super) fn sphere(n: usize, f: impl Fn(Vec3) -> f64) -> f64 {
        let mean: f64 = grid(n)
            .map(|[u, v]| {
                let y = 1.0 - 2.0 * v;
                let r = (1.0 - y * y).sqrt();
                f(Vec3::new(num::sin_turns(u) * r, y, num::cos_turns(u) * r))
            })
            .sum::<f64>()
            / (n * n) as f64;
        mean * 4.0 * std::f64::consts::PI
    }

    #[test]
    fn directions_and_places_are_inverse_and_oriented_as_told() {
        for [u, v] in grid(41) {
            let [a, b] = place_of(direction_of(u, v));
            assert!((a - u).abs() < 2e-6 && (b - v).abs() < 2e-6, "{u} {v}: {a} {b}");
        }
        assert!((direction_of(0.5, 0.5) - Vec3::NEG_Z).length() < 1e-6);
        assert!((direction_of(0.75, 0.5) - Vec3::X).length() < 1e-6);
        assert!((direction_of(0.2, 0.0) - Vec3::Y).length() < 1e-6);
        let turned = spotted(32, 16).turned(0.25);
        assert_eq!(turned.texels[4 * 32 + 4 + 8], [900.0, 700.0, 400.0]);
    }

    #[test]
    fn radiance_is_the_texel_at_its_centre_and_continuous_around() {
        let image = spotted(16, 8);
        for (i, texel) in image.texels.iter().enumerate() {
            let d = direction_of(((i % 16) as f32 + 0.5) / 16.0, ((i / 16) as f32 + 0.5) / 8.0);
            let LinearRgb(c) = image.radiance(d);
            (0..3).for_each(|k| assert!((c[k] - texel[k]).abs() < 1e-2, "{i}"));
        }
        let a = image.radiance(direction_of(1e-4, 0.6)).0[0];
        assert!((a - image.radiance(direction_of(1.0 - 1e-4, 0.6)).0[0]).abs() < 1e-3 && a > 0.01);
        assert!(image.radiance(Vec3::ZERO).0.iter().all(|c| c.is_finite()));
    }

    #[test]
    fn the_mean_is_the_integral() {
        let image = spotted(64, 32);
        let mean = image.mean_radiance().0;
        let environment = Environment::Image(Arc::new(image));
        for c in 0..3 {
            let truth =
                sphere(1500, |d| f64::from(environment.radiance(d).0[c])) / (4.0 * std::f64::consts::PI);
            assert!((f64::from(mean[c]) / truth - 1.0).abs() < 1e-2, "{mean:?} {truth}");
        }
        let flat = EnvironmentImage::from_fn(20, 10, |_| LinearRgb([0.25, 0.5, 1.0]));
        assert_eq!(flat.mean_radiance(), LinearRgb([0.25, 0.5, 1.0]));
    }

    #[test]
    fn what_is_no_radiance_is_refused_and_black_is_none() {
        assert_eq!(
            EnvironmentImage::new(2, 2, vec![[0.0; 3]; 3]),
            Err(EnvironmentError::Size { width: 2, height: 2, texels: 3 })
        );
        assert!(EnvironmentImage::new(0, 0, vec![]).is_err());
        for bad in [f32::NAN, f32::INFINITY, -0.1] {
            let error =
                EnvironmentImage::new(2, 1, vec![[0.0; 3], [1.0, bad, 0.0]]).expect_err("no radiance");
            assert!(error.to_string().starts_with("texel 1, 0 of the environment"), "{error}");
        }
        let plane = |value: f32, width| Plane::filled(width, 1, value);
        let image = EnvironmentImage::from_planes(&[plane(0.1, 2), plane(0.2, 2), plane(0.3, 2)]);
        assert_eq!(image.map(|i| i.texels), Ok(vec![[0.1, 0.2, 0.3]; 2]));
        for bad in [vec![], vec![plane(0.1, 2); 2], vec![plane(0.1, 2), plane(0.1, 3), plane(0.1, 2)]] {
            assert_eq!(EnvironmentImage::from_planes(&bad), Err(EnvironmentError::Planes));
        }
        let black = EnvironmentImage::from_fn(4, 2, |_| LinearRgb([f32::NAN, -1.0, f32::INFINITY]));
        assert!(EnvironmentSampler::new(&Environment::Image(Arc::new(black))).is_none());
        assert!(EnvironmentSampler::new(&Environment::Constant(LinearRgb::default())).is_none());
    }
}
