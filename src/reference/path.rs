//! One path of light, traced backwards from the eye.

use fearless_simd::Simd;
use glam::Vec3;

use super::bvh::{Bvh, Hit, Stack, TOGETHER};
use super::film::Pixel;
use super::lights::{Found, Lights};
use super::sampler::Samplers;
use super::settings::{Settings, Technique};
use super::skin::Skins;
use super::surface::{Point, Vertex, lift};
use crate::optics::Bands;
use crate::scene::Scene;

/// Paths that carry less than 1 over this of their light may end by chance, where they would be shaded again: the light they
/// have run into by then is kept. Measured on the coil, error times seconds: 0.87 of that of ending by chance, from the third
/// surface on, before the next ray is followed.
const DARK: f32 = 2.0;
/// Surfaces after which any path may end by chance.
const LONG: u32 = 3;
/// Shadow rays end this much short of a light, which is no obstacle.
const SHORT: f32 = 0.9999;

/// What paths run through.
pub(super) struct World<'a> {
    pub(super) scene: &'a Scene,
    pub(super) vertices: &'a [Vec<Vertex>],
    pub(super) bvh: &'a Bvh,
    pub(super) lights: &'a Lights<'a>,
    pub(super) skins: &'a Skins,
    pub(super) settings: &'a Settings,
}

/// What a path needs on its way.
pub(super) struct Walk<'a, S> {
    /// Lanes.
    pub(super) simd: S,
    pub(super) sampler: Samplers<1>,
    pub(super) stack: &'a mut Stack,
}

impl World<'_> {
    /// What rays from the eye meet: an object, or light, whose colour needs no wavelengths. `objects` is false where they
    /// are known to meet none.
    #[inline(always)]
    pub(super) fn first<S: Simd>(
        &self,
        simd: S,
        stack: &mut Stack,
        origins: &[Vec3; TOGETHER],
        directions: &[Vec3; TOGETHER],
        objects: bool,
    ) -> [Result<Hit, [f32; 3]>; TOGETHER] {
        let mut hits = [None; TOGETHER];
        if objects {
            hits = self.bvh.first_hits(simd, stack, origins, directions);
        }
        let mut limits = [f32::INFINITY; TOGETHER];
        for i in 0..TOGETHER {
            limits[i] = hits[i].map_or(f32::INFINITY, |h| h.distance);
        }
        let lights = self.lights.seen(origins, directions, &limits);
        let mut met = [Err([0.0; 3]); TOGETHER];
        for i in 0..TOGETHER {
            met[i] = match (lights[i], hits[i]) {
                (Some(light), _) => Err(light),
                (None, Some(hit)) => Ok(hit),
                (None, None) => Err([0.0; 3]),
            };
        }
        met
    }

    /// Radiance that an object sends back along a ray, in every band, by a random path; what is met is added to `pixel`.
    ///
    /// At each surface one light is asked and one direction followed (Kajiya 1986; Veach 1997, 9.2.4 and 10.2).
    #[inline(always)]
    pub(super) fn radiance<S: Simd, B: Bands<f32, N>, const N: usize>(
        &self,
        Walk { simd, sampler, stack }: &mut Walk<'_, S>,
        mut hit: Hit,
        mut direction: Vec3,
        channels: &Channels<B, N>,
        pixel: &mut Pixel,
    ) -> [f32; N] {
        let technique = self.settings.technique;
        let parts = self.settings.stage.parts();
        let ghostly = self.settings.transport.ghostly_environment();
        let bounces = self.settings.transport.bounces();
        let clamp = |indirect: bool| self.settings.clamp.filter(|_| indirect);
        let mut radiance = [0.0; N];
        let mut throughput = [1.0; N];
        let mut bounce = 0;
        while bounce < bounces {
            let bumps = self.settings.stage.has_bumps();
            let point = Point::new(self.scene, self.vertices, &hit, direction, bumps);
            if bounce == 0 {
                point.record(pixel);
            }
            let frame = point.frame;
            let view = self.skins.view(&point, channels, frame.to_local(-direction).to_array(), parts);

            if technique.asks() {
                let [u] = sampler.next();
                if let Some(light) = self.lights.sample(point.position, [u[0], u[1]], u[2]) {
                    let wi = frame.to_local(light.direction).to_array();
                    let outside = point.normal.dot(light.direction) > 0.0;
                    let (f, pdf) = if outside { view.eval_pdf(wi) } else { ([0.0; N], 0.0) };
                    if f.iter().any(|f| *f != 0.0) {
                        let from = lift(point.position, point.normal, light.direction);
                        let limit = light.distance * SHORT;
                        // Lamps hide what is behind them, as they do where rays meet them.
                        let behind = self.lights.hit(from, light.direction, limit, false).is_some();
                        let free = ghostly && light.environment;
                        if !behind
                            && (free || !self.bvh.is_blocked(*simd, stack, from, light.direction, limit))
                        {
                            let weight =
                                if light.delta { 1.0 } else { technique.weight_asked(light.pdf, pdf) };
                            let part: [f32; N] = std::array::from_fn(|i| throughput[i] * f[i]);
                            add(
                                &mut radiance,
                                &part,
                                &channels.bands.upsample(light.radiance.0),
                                weight * wi[2].abs() / light.pdf,
                                clamp(bounce > 0),
                            );
                        }
                    }
                }
            }

            let [u] = sampler.next();
            let Some(sample) = view.sample([u[0], u[1], u[2]]) else { return radiance };
            direction = frame.to_world(Vec3::from_array(sample.wi));
            if point.normal.dot(direction) <= 0.0 {
                return radiance;
            }
            let scale = sample.wi[2].abs() / sample.pdf;
            throughput = std::array::from_fn(|i| throughput[i] * sample.f[i] * scale);
            // Infinite where no light can be asked for it.
            let pdf = if sample.delta { f32::INFINITY } else { sample.pdf };
            bounce += 1;

            let origin = lift(point.position, point.normal, direction);
            let next = self.bvh.first_hit(*simd, stack, origin, direction, f32::INFINITY);
            let limit = next.map_or(f32::INFINITY, |h| h.distance);
            let asked = pdf < f32::INFINITY && technique == Technique::Mis;
            let mut met = |found: Found| {
                let weight = technique.weight_met(pdf, found.pdf);
                let light = channels.bands.upsample(found.radiance.0);
                add(&mut radiance, &throughput, &light, weight, clamp(bounce > 1));
            };
            if let Some(found) = self.lights.hit(origin, direction, limit, asked) {
                met(found);
                return radiance;
            }
            match next {
                Some(next) if !ghostly => {
                    let brightest = throughput.iter().fold(0.0f32, |a, &b| a.max(b));
                    let survive = (brightest * DARK).min(if bounce < LONG { 1.0 } else { 0.95 });
                    if survive < 1.0 {
                        if survive <= u[3] {
                            return radiance;
                        }
                        throughput = throughput.map(|t| t / survive);
                    }
                    hit = next;
                }
                // The environment shines through what was met, though not through lamps behind it; suns do not.
                Some(_) => {
                    if self.lights.hit(origin, direction, f32::INFINITY, false).is_none() {
                        self.lights.sky(direction, asked).into_iter().for_each(met);
                    }
                    return radiance;
                }
                None => {
                    self.lights.far(direction, asked).for_each(met);
                    return radiance;
                }
            }
        }
        radiance
    }
}

/// `sum += throughput light weight` in every band, none more than `most`, and all by one factor.
#[inline(always)]
fn add<const N: usize>(
    sum: &mut [f32; N],
    throughput: &[f32; N],
    light: &[f32; N],
    weight: f32,
    most: Option<f32>,
) {
    let part: [f32; N] = std::array::from_fn(|i| throughput[i] * light[i] * weight);
    let peak = part.iter().fold(0.0f32, |a, &b| a.max(b));
    let scale = most.map_or(1.0, |most| if peak > most { most / peak } else { 1.0 });
    for i in 0..N {
        sum[i] += part[i] * scale;
    }
}

/// The bands of one path: what they reflect, and how they make a colour.
pub(super) struct Channels<B, const N: usize> {
    /// What colours and films are in them.
    pub(super) bands: B,
    /// What each band adds to red, green and blue.
    pub(super) weights: [[f32; 3]; N],
}

impl<B, const N: usize> Channels<B, N> {
    /// The linear sRGB colour of a radiance in every band.
    #[inline(always)]
    pub(super) fn rgb(&self, radiance: [f32; N]) -> [f32; 3] {
        let mut rgb = [0.0; 3];
        for (x, weight) in radiance.iter().zip(&self.weights) {
            for c in 0..3 {
                rgb[c] += x * weight[c];
            }
        }
        rgb
    }
}
