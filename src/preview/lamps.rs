//! Lights for the device: a sun is one direction, a rectangle so many small lights, each with a shadow map of its own.

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3};

use super::PreviewError;
use crate::base::num;
use crate::scene::{Light, Scene};

/// Most lights.
pub(super) const MOST_LAMPS: usize = 32;
/// Most small lights that all of them become.
pub(super) const MOST_SAMPLES: usize = 128;

/// `Lamp` of lamps.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Lamp {
    /// Its first small light.
    pub(super) first: u32,
    /// How many it has.
    pub(super) count: u32,
    /// What the angle of each adds to alpha^2.
    pub(super) spread: f32,
    /// To 16 bytes.
    pub(super) padding: f32,
}

/// `Sample` of lamps.wgsl: a small light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct LampSample {
    /// Unit vector to a sun (w = 0), or a place on a rectangle (w = 1).
    pub(super) at: [f32; 4],
    /// Irradiance, or radiance times area.
    pub(super) light: [f32; 3],
    /// Size of a texel of the shadow map, in scene units; per unit of distance for a rectangle.
    pub(super) texel: f32,
    /// Which way a rectangle shines.
    pub(super) normal: [f32; 3],
    /// To the next 16 bytes.
    pub(super) padding: f32,
    /// World to the shadow map.
    pub(super) shadow: [[f32; 4]; 4],
}

/// `Disc` of background.wgsl: a sun as the eye sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Disc {
    /// Unit vector to it.
    pub(super) direction: [f32; 3],
    /// Square of half its chord.
    pub(super) chord_2: f32,
    /// Radiance.
    pub(super) radiance: [f32; 3],
    /// To 16 bytes.
    pub(super) padding: f32,
}

/// All lights of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lamps {
    /// Suns and rectangles.
    pub(super) lamps: Vec<Lamp>,
    /// What they become.
    pub(super) samples: Vec<LampSample>,
    /// Suns that are discs.
    pub(super) discs: Vec<Disc>,
}

impl Lamps {
    /// The lights of a scene; each rectangle becomes `per_rectangle` small ones, shadow maps have `shadow_size` texels a
    /// side and hold what `casters` has.
    ///
    /// # Errors
    /// If there are too many lights.
    pub(super) fn new(
        scene: &Scene,
        casters: &Casters,
        per_rectangle: usize,
        shadow_size: u32,
    ) -> Result<Self, PreviewError> {
        let most = |what, needed: usize, most: usize| {
            let too_large = PreviewError::TooLarge { what, needed: needed as u64, most: most as u64 };
            if needed > most { Err(too_large) } else { Ok(()) }
        };
        most("the number of lights", scene.lights.len(), MOST_LAMPS)?;
        let mut all = Self::default();
        let texels = shadow_size.max(1) as f32;
        for light in &scene.lights {
            let first = all.samples.len() as u32;
            let spread = match *light {
                Light::Directional { direction, irradiance, angular_radius_rad } => {
                    let (shadow, width) = casters.seen_from_afar(direction);
                    all.samples.push(LampSample {
                        at: direction.extend(0.0).to_array(),
                        light: irradiance.0,
                        texel: width / texels,
                        shadow: shadow.to_cols_array_2d(),
                        ..LampSample::default()
                    });
                    all.discs.extend(Disc::new(light));
                    // A disc of radius r has the variance r^2/4 along an axis, a quarter of that for the half vector,
                    // and alpha^2 is twice the variance of slopes.
                    angular_radius_rad * angular_radius_rad / 8.0
                }
                Light::Area { center, u, v, radiance } => {
                    let count = per_rectangle.max(1);
                    let normal = u.cross(v).normalize_or_zero();
                    let area = 4.0 * u.cross(v).length() / count as f32;
                    for i in 0..count {
                        let [x, y] = hammersley(i, count).map(|t| 2.0 * t - 1.0);
                        let at = center + u * x + v * y;
                        let (shadow, width) = casters.seen_from(at, normal);
                        all.samples.push(LampSample {
                            at: at.extend(1.0).to_array(),
                            light: radiance.0.map(|r| r * area),
                            texel: width / texels,
                            normal: normal.to_array(),
                            padding: 0.0,
                            shadow: shadow.to_cols_array_2d(),
                        });
                    }
                    // As a disc of the same solid angle, as the scene sees it: r^2 = angle/pi.
                    let to = center - casters.middle();
                    let cosine = -to.normalize_or_zero().dot(normal);
                    let angle = area * cosine.max(0.0) / to.length_squared().max(area);
                    angle / (8.0 * PI)
                }
            };
            let count = all.samples.len() as u32 - first;
            all.lamps.push(Lamp { first, count, spread, padding: 0.0 });
        }
        most("the number of small lights that rectangles become", all.samples.len(), MOST_SAMPLES)?;
        Ok(all)
    }

    /// The uniform block `Lamps` of lamps.wgsl.
    pub(super) fn block(&self) -> Vec<u8> {
        let mut lamps = self.lamps.clone();
        lamps.resize(MOST_LAMPS, Lamp::default());
        let mut samples = self.samples.clone();
        samples.resize(MOST_SAMPLES, LampSample::default());
        [bytemuck::cast_slice(&lamps), bytemuck::cast_slice(&samples)].concat()
    }
}

impl Disc {
    /// `None` for a light that is no disc.
    fn new(light: &Light) -> Option<Self> {
        let Light::Directional { direction, angular_radius_rad, .. } = *light else { return None };
        let hit = light.hit(Vec3::ZERO, direction)?;
        let half_sin = libm::sinf(0.5 * angular_radius_rad);
        Some(Self {
            direction: direction.to_array(),
            // |a - b|^2 = 2 (1 - cos).
            chord_2: 4.0 * half_sin * half_sin,
            radiance: hit.radiance.0,
            padding: 0.0,
        })
    }
}

/// Point `i` of `n` of Hammersley's set, moved into the middles of its strata: few points that are even along both axes.
fn hammersley(i: usize, n: usize) -> [f32; 2] {
    let reversed = ((i as u32).reverse_bits() >> 8) as f32 / (1u32 << 24) as f32;
    [(i as f32 + 0.5) / n as f32, num::fract(reversed + 0.5 / n as f32)]
}

/// The points of all that casts shadows worth a map.
#[derive(Clone, Debug, Default)]
pub(super) struct Casters {
    /// Indices of the objects.
    pub(super) objects: Vec<usize>,
    points: Vec<Vec3>,
    low: Vec3,
    high: Vec3,
}

/// An object so many times wider than the smallest one is a floor: nothing is below it that its shadow could fall on.
const FLOOR: f32 = 16.0;

impl Casters {
    /// The objects of a scene, without floors.
    pub(super) fn new(scene: &Scene) -> Self {
        let sizes: Vec<f32> = (0..scene.objects.len()).map(|i| Self::size(scene, i)).collect();
        let least = sizes.iter().copied().filter(|s| *s > 0.0).fold(f32::INFINITY, f32::min);
        let casts = |i: &usize| sizes[*i] > 0.0 && sizes[*i] <= FLOOR * least;
        let objects: Vec<usize> = (0..sizes.len()).filter(casts).collect();
        let of = |i: &usize| scene.objects[*i].mesh.positions.iter().copied();
        let points: Vec<Vec3> = objects.iter().flat_map(of).collect();
        let (low, high) = points
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        if points.is_empty() { Self::default() } else { Self { objects, points, low, high } }
    }

    fn size(scene: &Scene, object: usize) -> f32 {
        let [low, high] = scene.objects[object].mesh.bounds();
        (high - low).length()
    }

    /// The middle of a box around them.
    pub(super) fn middle(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// World to the shadow map of a light in this direction, which fits all of them; and the map's width in scene units.
    fn seen_from_afar(&self, direction: Vec3) -> (Mat4, f32) {
        let (right, up) = direction.any_orthonormal_pair();
        let axes = Mat4::from_cols(right.extend(0.0), up.extend(0.0), direction.extend(0.0), glam::Vec4::W);
        let look = axes.transpose();
        let (low, high) = self.points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
            let p = look.transform_point3(*p);
            (low.min(p), high.max(p))
        });
        if low.x > high.x {
            return (Mat4::ZERO, 1.0);
        }
        let (size, middle) = (high - low, 0.5 * (low + high));
        let width = size.x.max(size.y).max(1e-6) * EDGE;
        // The nearest to the light, that is the highest, gets depth 0.
        let depth = size.z.max(1e-6) * EDGE;
        let scale = Mat4::from_scale(Vec3::new(2.0 / width, 2.0 / width, -1.0 / depth));
        let shift = Mat4::from_translation(-Vec3::new(middle.x, middle.y, middle.z + 0.5 * depth));
        (scale * shift * look, width)
    }

    /// World to the shadow map of a light at this place that shines along `normal`, which fits all of them if they are
    /// before it; and the map's width in scene units at distance 1.
    fn seen_from(&self, place: Vec3, normal: Vec3) -> (Mat4, f32) {
        let forward =
            (self.middle() - place).try_normalize().filter(|f| f.dot(normal) > 0.0).unwrap_or(normal);
        let (right, up) = forward.any_orthonormal_pair();
        let seen = |p: &Vec3| {
            let to = *p - place;
            let depth = to.dot(forward);
            (Vec2::new(to.dot(right), to.dot(up)) / depth.max(1e-6), depth)
        };
        let start = (Vec2::INFINITY, Vec2::NEG_INFINITY, f32::INFINITY, 0.0_f32);
        let (low, high, near, far) =
            self.points.iter().map(seen).fold(start, |(low, high, near, far), (p, depth)| {
                (low.min(p), high.max(p), near.min(depth), far.max(depth))
            });
        if far <= 0.0 {
            return (Mat4::ZERO, 1.0);
        }
        // From among them a map sees this far to each side, and what is behind it casts nothing.
        let (low, high) = (low.max(Vec2::splat(-4.0)), high.min(Vec2::splat(4.0)));
        let (near, far) = (near.max(1e-3 * far) / EDGE, far * EDGE);
        let middle = 0.5 * (low + high);
        let width = (high - low).max_element().max(1e-6) * EDGE;
        let look = Mat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), glam::Vec4::W)
            .transpose()
            * Mat4::from_translation(-place);
        let (s, depth) = (2.0 / width, far / (far - near));
        let project = Mat4::from_cols(
            glam::Vec4::new(s, 0.0, 0.0, 0.0),
            glam::Vec4::new(0.0, s, 0.0, 0.0),
            glam::Vec4::new(-s * middle.x, -s * middle.y, depth, 1.0),
            glam::Vec4::new(0.0, 0.0, -depth * near, 0.0),
        );
        (project * look, width)
    }
}

/// Room around what a shadow map holds.
const EDGE: f32 = 1.01;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::LinearRgb;
    use crate::scene::{Inputs, SceneSpec};

    fn scene() -> Scene {
        let mut spec = SceneSpec::default();
        spec.subject.triangles = 2000;
        Scene::build(&spec, &Inputs::default()).expect("it can be built")
    }

    #[test]
    fn few_points_are_even_along_both_axes() {
        for n in [1, 4, 16, 64] {
            for axis in 0..2 {
                let mut strata: Vec<usize> =
                    (0..n).map(|i| (hammersley(i, n)[axis] * n as f32) as usize).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..n).collect::<Vec<_>>());
            }
        }
    }

    /// Everything that casts a shadow is in the map, the nearer the less deep; a floor is not among it.
    #[test]
    fn maps_hold_what_casts_shadows() {
        let scene = scene();
        let casters = Casters::new(&scene);
        assert_eq!(casters.objects, [0]);
        let to = Vec3::new(0.3, 0.8, -0.2).normalize();
        let at = casters.middle() + to * 12.0;
        for (map, distance) in [
            (casters.seen_from_afar(to).0, &(|p: Vec3| -p.dot(to)) as &dyn Fn(Vec3) -> f32),
            (casters.seen_from(at, -to).0, &|p: Vec3| (p - at).dot(-to)),
        ] {
            let mut seen: Vec<(f32, f32)> = Vec::new();
            for p in &scene.objects[0].mesh.positions {
                let c = map * p.extend(1.0);
                let c = c / c.w;
                assert!(c.x.abs() <= 1.0 && c.y.abs() <= 1.0 && (0.0..=1.0).contains(&c.z), "{c}");
                seen.push((distance(*p), c.z));
            }
            seen.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert!(seen.windows(2).all(|w| w[1].1 >= w[0].1 - 1e-5));
        }
    }

    /// The small lights of a rectangle give together what it gives.
    #[test]
    fn a_rectangle_keeps_its_light() {
        let mut scene = scene();
        let (u, v) = (Vec3::X * 3.0, Vec3::Z * 2.0);
        let light = Light::Area { center: Vec3::Y * 8.0, u, v, radiance: LinearRgb([2.0; 3]) };
        scene.lights = vec![light];
        let lamps = Lamps::new(&scene, &Casters::new(&scene), 16, 64).expect("one light");
        assert_eq!((lamps.lamps[0].count, lamps.samples.len(), lamps.discs.len()), (16, 16, 0));
        let small: f32 = lamps
            .samples
            .iter()
            .map(|s| {
                let to = Vec3::from_slice(&s.at);
                let direction = to.normalize();
                s.light[1] * direction.y * -direction.dot(Vec3::from(s.normal)) / to.length_squared()
            })
            .sum();
        let n = 64;
        let whole: f32 = (0..n * n)
            .filter_map(|i| {
                let s = light
                    .sample(Vec3::ZERO, [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32))?;
                Some(s.radiance.0[1] * s.direction.y / s.pdf / (n * n) as f32)
            })
            .sum();
        assert!((small / whole - 1.0).abs() < 0.01, "{small} for {whole}");
    }

    #[test]
    fn too_many_lights_are_refused_with_the_number() {
        let mut scene = scene();
        let sun = Light::Directional {
            direction: Vec3::Y,
            irradiance: LinearRgb([1.0; 3]),
            angular_radius_rad: 0.01,
        };
        scene.lights = vec![sun; MOST_LAMPS + 1];
        let error = Lamps::new(&scene, &Casters::new(&scene), 16, 64).expect_err("too many");
        assert_eq!(error.to_string(), "the number of lights needs 33, the adapter holds 32 at most");
        scene.lights.truncate(2);
        let lamps = Lamps::new(&scene, &Casters::new(&scene), 16, 64).expect("two suns");
        assert_eq!((lamps.samples.len(), lamps.discs.len()), (2, 2));
        assert_eq!(lamps.block().len(), 32 * 16 + 128 * 112);
    }
}
