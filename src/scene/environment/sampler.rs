//! Directions to what shines all around, the brighter the more often.

use std::f32::consts::PI;

use glam::Vec3;

use super::{Environment, EnvironmentImage, place_of, row_cos, row_share};
use crate::base::{LinearRgb, num};

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

    fn of_blocks(light: &Luminance, side: usize) -> Self {
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
struct Luminance {
    width: usize,
    /// Mean luminance over each texel.
    texels: Vec<f64>,
    /// Share of the sphere that a texel of each row covers.
    shares: Vec<f64>,
}

/// The mean over a texel of what is linear between texel centres is 1/8, 6/8, 1/8 of them each way.
fn averages(image: &EnvironmentImage) -> Luminance {
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
    Luminance { width, texels: (0..width * height).map(texel).collect(), shares }
}

/// Of a block of texels: the light in it, the share of the sphere that it covers, and the integral of the light's square.
fn block(light: &Luminance, side: usize, x: usize, y: usize) -> (f64, f64, f64) {
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
fn second_moment(light: &Luminance, side: usize) -> f64 {
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
    use std::sync::Arc;

    use super::super::tests::{grid, sphere, spotted};
    use super::*;
    use crate::base::hash;

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
}
