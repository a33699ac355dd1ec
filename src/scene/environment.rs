//! What is all around: a sky, a studio, a picture, or nothing.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;

use crate::base::{LinearRgb, Plane, num};

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

    /// Radiance at a place of the picture.
    #[inline(always)]
    fn radiance_at(&self, [u, v]: [f32; 2]) -> LinearRgb {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (fx, fy) = (x.floor(), y.floor());
        let (tx, ty) = (x - fx, y - fy);
        // From -1 to width - 1.
        let x0 = if fx < 0.0 { self.width - 1 } else { (fx as usize).min(self.width - 1) };
        let x1 = if x0 + 1 == self.width { 0 } else { x0 + 1 };
        let y0 = (fy.max(0.0) as usize).min(self.height - 1);
        let y1 = ((fy + 1.0).max(0.0) as usize).min(self.height - 1);
        let row = |y: usize| {
            let row = &self.texels[y * self.width..][..self.width];
            std::array::from_fn::<f32, 3, _>(|c| num::lerp(row[x0][c], row[x1][c], tx))
        };
        let (a, b) = (row(y0), row(y1));
        LinearRgb(std::array::from_fn(|c| num::lerp(a[c], b[c], ty)))
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

/// Two of [`num::atan2_turns`] at once, within 1e-6 of it: as lanes, with one division.
#[inline(always)]
fn angles_turns(y: [f32; 2], x: [f32; 2]) -> [f32; 2] {
    std::array::from_fn(|i| {
        let (y, x) = (y[i], x[i]);
        let (ax, ay) = (x.abs(), y.abs());
        let (lo, hi) = (ax.min(ay), ax.max(ay).max(f32::MIN_POSITIVE));
        // atan(t) = pi/4 + atan((t - 1)/(t + 1)), where t = lo/hi is above tan(pi/8).
        let far = lo > 0.414_213_57 * hi;
        let (over, under) = if far { (lo - hi, lo + hi) } else { (lo, hi) };
        let a = (if far { 0.125 } else { 0.0 }) + num::atan_turns(over / under);
        let a = if ay > ax { 0.25 - a } else { a };
        let a = if x < 0.0 { 0.5 - a } else { a };
        if y < 0.0 { -a } else { a }
    })
}

/// Share of the sphere that row `y` covers.
fn row_share(y: usize, height: usize) -> f64 {
    0.5 * (row_cos(y, height) - row_cos(y + 1, height))
}

/// Cosine from the zenith of the upper edge of row `y`.
fn row_cos(y: usize, height: usize) -> f64 {
    libm::cos(std::f64::consts::PI * y as f64 / height as f64)
}

/// A direction from which the environment shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    /// Unit vector.
    pub direction: Vec3,
    /// What comes from there: [`Environment::radiance`].
    pub radiance: LinearRgb,
    /// Probability density per solid angle; above 0.
    pub pdf: f32,
}

/// Draws directions as often as they are bright: by row of cells, then by column, then evenly over the cell's solid angle,
/// so that the density is constant over each cell, poles included.
///
/// A cell is a texel, or a block of them where that makes draws at most 5 % more noisy: the tables of a smooth sky then
/// stay in the nearest cache. A texel weighs what the bilinear picture has in it on average, so no direction that shines
/// has density 0.
#[derive(Clone, Debug)]
pub struct EnvironmentSampler {
    environment: Environment,
    /// `None` for a constant.
    table: Option<Table>,
}

#[derive(Clone, Debug)]
struct Table {
    /// Columns and rows of cells.
    width: usize,
    height: usize,
    /// Cumulative probability of the rows, from 0 to 1.
    rows: Vec<f32>,
    /// Cumulative probability of each row's columns, `width + 1` each.
    columns: Vec<f32>,
    /// [`guide`] of the rows, and of each row's columns.
    row_guide: Vec<u32>,
    column_guides: Vec<u32>,
    /// Cosines of the rows' edges, from 1 to -1.
    edges: Vec<f32>,
}

impl EnvironmentSampler {
    /// Prepare an environment; `None` if it is black.
    pub fn new(environment: &Environment) -> Option<Self> {
        if environment.is_black() {
            return None;
        }
        let table = match environment {
            Environment::Constant(_) => None,
            Environment::Image(image) => Some(Table::new(image)),
        };
        Some(Self { environment: environment.clone(), table })
    }

    /// What is sampled.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// A direction; `u` is uniform in the unit square.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> EnvironmentSample {
        let towards = |cos: f32, turns: f32| {
            let radius = num::safe_sqrt((1.0 - cos) * (1.0 + cos));
            Vec3::new(num::sin_turns(turns) * radius, cos, -num::cos_turns(turns) * radius)
        };
        match (&self.table, &self.environment) {
            (Some(table), Environment::Image(image)) => {
                let Drawn { cos, across, pdf } = table.sample(u);
                let direction = towards(cos, across - 0.5);
                // The angle down from its cosine and sine; across is known.
                let down = 2.0 * num::atan2_turns(num::safe_sqrt((1.0 - cos) * (1.0 + cos)), cos);
                let radiance = image.radiance_at([across, num::saturate(down)]);
                EnvironmentSample { direction, radiance, pdf }
            }
            _ => {
                let direction = towards(1.0 - 2.0 * u[1], u[0] - 0.5);
                EnvironmentSample {
                    direction,
                    radiance: self.environment.radiance(direction),
                    pdf: 0.25 / PI,
                }
            }
        }
    }

    /// The density of [`EnvironmentSampler::sample`] at a direction (a unit vector), per solid angle.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.look(direction).1
    }

    /// What comes from a direction (a unit vector), and the density with which [`EnvironmentSampler::sample`] finds it.
    #[inline(always)]
    pub fn look(&self, direction: Vec3) -> (LinearRgb, f32) {
        match (&self.table, &self.environment) {
            (Some(table), Environment::Image(image)) => {
                let [u, v] = place_of(direction);
                let y = ((v * table.height as f32) as usize).min(table.height - 1);
                let x = ((u * table.width as f32) as usize).min(table.width - 1);
                (image.radiance_at([u, v]), table.pdf(x, y))
            }
            _ => (self.environment.radiance(direction), 0.25 / PI),
        }
    }
}

/// A texel drawn, and where in it.
#[derive(Clone, Copy)]
struct Drawn {
    /// Cosine from the zenith.
    cos: f32,
    /// Across the picture, in [0, 1].
    across: f32,
    pdf: f32,
}

/// How much noisier draws from blocks of texels may be than draws from texels: in variance.
const COARSE: f64 = 1.05;

impl Table {
    /// The coarsest table that is nearly as good as the finest.
    fn new(image: &EnvironmentImage) -> Self {
        let light = averages(image);
        let fine = second_moment(&light, 1);
        // Blocks have the same number of texels, so that columns are of one width.
        let fits = |side: usize| image.width.is_multiple_of(side) && image.height.is_multiple_of(side);
        let good = |side: &usize| fits(*side) && second_moment(&light, *side) <= COARSE * fine;
        let side = [16, 8, 4, 2].into_iter().find(good).unwrap_or(1);
        Self::of_blocks(&light, side)
    }

    fn of_blocks(light: &Light, side: usize) -> Self {
        let (width, height) = (light.width / side, light.shares.len() / side);
        let mut columns = Vec::with_capacity((width + 1) * height);
        let mut weights = Vec::with_capacity(height);
        for y in 0..height {
            let row: Vec<f64> = (0..width).map(|x| block(light, side, x, y).0).collect();
            weights.push(row.iter().sum());
            columns.extend(cumulative(&row));
        }
        let edges = (0..=height).map(|y| row_cos(y, height) as f32).collect();
        let rows = cumulative(&weights);
        let column_guides = columns.chunks_exact(width + 1).flat_map(guide).collect();
        Self { width, height, row_guide: guide(&rows), rows, column_guides, columns, edges }
    }

    #[inline(always)]
    fn sample(&self, u: [f32; 2]) -> Drawn {
        let (y, down) = find(&self.rows, &self.row_guide, u[1]);
        let (x, into) = find(self.columns_of(y), &self.column_guides[y * self.width..][..self.width], u[0]);
        let cos = num::lerp(self.edges[y], self.edges[y + 1], down);
        Drawn { cos, across: (x as f32 + into) / self.width as f32, pdf: self.pdf(x, y) }
    }

    #[inline(always)]
    fn pdf(&self, x: usize, y: usize) -> f32 {
        let columns = self.columns_of(y);
        let share = (self.rows[y + 1] - self.rows[y]) * (columns[x + 1] - columns[x]);
        let solid_angle = (self.edges[y] - self.edges[y + 1]) * (2.0 * PI / self.width as f32);
        if solid_angle > 0.0 { share / solid_angle } else { 0.0 }
    }

    fn columns_of(&self, y: usize) -> &[f32] {
        &self.columns[y * (self.width + 1)..][..self.width + 1]
    }
}

/// What a picture has in each texel.
struct Light {
    width: usize,
    /// Mean luminance over each texel.
    texels: Vec<f64>,
    /// Share of the sphere that a texel of each row covers.
    shares: Vec<f64>,
}

/// The mean over a texel of what is linear between texel centres is 1/8, 6/8, 1/8 of them each way.
fn averages(image: &EnvironmentImage) -> Light {
    let (width, height) = (image.width, image.height);
    let light = |x: usize, y: usize| f64::from(LinearRgb(image.texels[y * width + x]).luminance());
    let across = |x: usize, y: usize| {
        0.125 * (light((x + width - 1) % width, y) + light((x + 1) % width, y)) + 0.75 * light(x, y)
    };
    let texel = |i: usize| {
        let (x, y) = (i % width, i / width);
        let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
        0.125 * (across(x, above) + across(x, below)) + 0.75 * across(x, y)
    };
    let shares = (0..height).map(|y| row_share(y, height) / width as f64).collect();
    Light { width, texels: (0..width * height).map(texel).collect(), shares }
}

/// Of a block of texels: the light in it, the share of the sphere that it covers, and the integral of the light's square.
fn block(light: &Light, side: usize, x: usize, y: usize) -> (f64, f64, f64) {
    let mut sums = (0.0, 0.0, 0.0);
    for y in y * side..(y + 1) * side {
        let share = light.shares[y];
        for l in &light.texels[y * light.width + x * side..][..side] {
            sums = (sums.0 + l * share, sums.1 + share, sums.2 + l * l * share);
        }
    }
    sums
}

/// The integral of the light's square over the density of draws from blocks, up to a factor: what variance grows with.
fn second_moment(light: &Light, side: usize) -> f64 {
    let (width, height) = (light.width / side, light.shares.len() / side);
    let blocks = (0..width * height).map(|i| block(light, side, i % width, i / width));
    blocks.filter(|b| b.0 > 0.0).map(|(sum, share, squares)| squares * share / sum).sum()
}

/// Running sums over their total, from 0 to exactly 1; even steps where the total is 0 (such a row is never drawn).
fn cumulative(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let mut out = vec![0.0];
    out.extend(weights.iter().enumerate().map(|(i, w)| {
        sum += w;
        if total > 0.0 { (sum / total).min(1.0) as f32 } else { (i + 1) as f32 / weights.len() as f32 }
    }));
    if let Some(last) = out.last_mut() {
        *last = 1.0;
    }
    out
}

/// Where to begin in a cumulative list of n steps for each n-th part of [0, 1): the step in which it begins (Chen & Asau
/// 1974). A search then takes a step or two.
fn guide(cumulative: &[f32]) -> Vec<u32> {
    let n = cumulative.len() - 1;
    (0..n).map(|i| step_of(cumulative, i as f32 / n as f32) as u32).collect()
}

/// The step of a cumulative list in which `u` lies, which is never empty.
fn step_of(cumulative: &[f32], u: f32) -> usize {
    cumulative.partition_point(|&c| c <= u).max(1) - 1
}

/// The same with its guide, and how far into the step, in [0, 1].
#[inline(always)]
fn find(cumulative: &[f32], guide: &[u32], u: f32) -> (usize, f32) {
    // Below 1, so that there is a step above it.
    let u = num::saturate(u).min(1.0 - f32::EPSILON);
    let mut i = guide[((u * guide.len() as f32) as usize).min(guide.len() - 1)] as usize;
    // Rounding may have begun a step too far.
    while i > 0 && cumulative[i] > u {
        i -= 1;
    }
    while cumulative[i + 1] <= u {
        i += 1;
    }
    let (low, high) = (cumulative[i], cumulative[i + 1]);
    (i, num::saturate((u - low) / (high - low)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::hash;

    /// A small, bright, coloured spot on a dim ramp, with black rows and columns.
    fn spotted(width: usize, height: usize) -> EnvironmentImage {
        let mut texels = vec![[0.0; 3]; width * height];
        for y in 0..height {
            for x in width / 3..width {
                texels[y * width + x] = [0.1, 0.2 * (y as f32 / height as f32), 0.05];
            }
        }
        texels[(height / 4) * width + width / 8] = [900.0, 700.0, 400.0];
        EnvironmentImage::new(width, height, texels).expect("sound")
    }

    fn grid(n: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..n * n).map(move |i| [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32))
    }

    /// The integral of f over the sphere, evenly in height and azimuth.
    fn sphere(n: usize, f: impl Fn(Vec3) -> f64) -> f64 {
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
    fn smooth_skies_are_drawn_by_blocks_and_spots_by_texels() {
        let columns = |sampler: &EnvironmentSampler| sampler.table.as_ref().map(|t| t.width);
        let smooth = EnvironmentImage::from_fn(64, 32, |d| LinearRgb([1.0 + 0.2 * d.y + 0.1 * d.x; 3]));
        let mean = f64::from(smooth.mean_radiance().luminance());
        let sampler = EnvironmentSampler::new(&Environment::Image(Arc::new(smooth))).expect("it shines");
        assert_eq!(columns(&sampler), Some(4));
        let sum = sphere(1200, |d| f64::from(sampler.pdf(d)));
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        // Light over density is nearly even, and its mean is the light of the sphere.
        let drawn: Vec<f64> = grid(200)
            .map(|u| {
                let s = sampler.sample(u);
                f64::from(s.radiance.luminance() / s.pdf) / (4.0 * std::f64::consts::PI)
            })
            .collect();
        let n = drawn.len() as f64;
        let average = drawn.iter().sum::<f64>() / n;
        let variance = drawn.iter().map(|x| (x - average).powi(2)).sum::<f64>() / n;
        assert!((average / mean - 1.0).abs() < 1e-3, "{average} {mean}");
        assert!(variance < (COARSE - 1.0) * mean * mean, "{variance}");
        let spot =
            EnvironmentSampler::new(&Environment::Image(Arc::new(spotted(64, 32)))).expect("it shines");
        assert_eq!(columns(&spot), Some(64));
    }

    #[test]
    fn the_density_integrates_to_one() {
        for image in [spotted(16, 8), spotted(33, 17), spotted(1, 1), spotted(3, 2)] {
            let environment = Environment::Image(Arc::new(image));
            let sampler = EnvironmentSampler::new(&environment).expect("it shines");
            let sum = sphere(1200, |d| f64::from(sampler.pdf(d)));
            assert!((sum - 1.0).abs() < 5e-3, "{sum}");
        }
        let gray = Environment::Constant(LinearRgb([0.5; 3]));
        let sampler = EnvironmentSampler::new(&gray).expect("it shines");
        assert!((sphere(10, |d| f64::from(sampler.pdf(d))) - 1.0).abs() < 1e-5);
    }

    /// The estimate is the integral, for the radiance and for a lobe that weighs dark parts, and with less noise than
    /// blind sampling has.
    #[test]
    fn estimates_are_integrals() {
        let environment = Environment::Image(Arc::new(spotted(32, 16)));
        let sampler = EnvironmentSampler::new(&environment).expect("it shines");
        for axis in [Vec3::Y, Vec3::new(-0.6, -0.8, 0.0), Vec3::new(0.0, 0.6, 0.8)] {
            let f = |d: Vec3, c: LinearRgb| f64::from(c.0[1] * d.dot(axis).max(0.0));
            let truth = sphere(1500, |d| f(d, environment.radiance(d)));
            let n = 500;
            let estimate = grid(n)
                .map(|u| sampler.sample(u))
                .map(|s| f(s.direction, s.radiance) / f64::from(s.pdf))
                .sum::<f64>()
                / (n * n) as f64;
            assert!((estimate / truth - 1.0).abs() < 1e-2, "{axis}: {estimate} for {truth}");
        }
        // The spread of single samples.
        let relative = |pick: &dyn Fn([f32; 2]) -> f64| {
            let values: Vec<f64> = (0..4000u32)
                .map(|i| pick([0, 1].map(|k| hash::hash2(5, i, k) as f32 * 2.0_f32.powi(-32))))
                .collect();
            let mean = values.iter().sum::<f64>() / 4000.0;
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4000.0).sqrt() / mean
        };
        let by_light = relative(&|u| {
            let s = sampler.sample(u);
            f64::from(s.radiance.luminance() / s.pdf)
        });
        let constant = EnvironmentSampler::new(&Environment::Constant(LinearRgb([1.0; 3])));
        let constant = constant.expect("it shines");
        let blind = relative(&|u| f64::from(environment.radiance(constant.sample(u).direction).luminance()));
        assert!(by_light < 1.2 && blind > 5.0 * by_light, "{by_light} {blind}");
    }

    #[test]
    fn a_sample_and_its_density_agree() {
        let environment = Environment::Image(Arc::new(spotted(32, 16)));
        let sampler = EnvironmentSampler::new(&environment).expect("it shines");
        let agree = grid(100)
            .map(|u| sampler.sample(u))
            .filter(|s| {
                assert!(s.pdf > 0.0 && (s.direction.length() - 1.0).abs() < 1e-5);
                (sampler.pdf(s.direction) / s.pdf - 1.0).abs() < 1e-4
            })
            .count();
        // At a texel's edge rounding may tell the neighbour's.
        assert!(agree > 9950, "{agree}");
        for u in [[0.0, 0.0], [1.0, 1.0], [f32::NAN, 2.0]] {
            assert!(sampler.sample(u).pdf > 0.0);
        }
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
