//! Lights for the device: a sun is one direction, a rectangle so many small lights, each with a shadow map of its own.

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

use super::PreviewError;
use crate::base::num;
use crate::scene::{Light, Scene};

/// Most suns, and most rectangles.
pub(super) const MOST_LAMPS: usize = 32;
/// Most small lights that all rectangles become.
pub(super) const MOST_PLACES: usize = 128;

/// `Sun` of suns.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Sun {
    /// Unit vector to it.
    pub(super) direction: [f32; 3],
    /// What its angle adds to alpha^2.
    pub(super) spread: f32,
    /// On a surface that faces it.
    pub(super) irradiance: [f32; 3],
    /// Size of a texel of the shadow map, in scene units.
    pub(super) texel: f32,
    /// World to the shadow map.
    pub(super) shadow: [[f32; 4]; 4],
}

/// `Rectangle` of rectangles.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Rectangle {
    /// Along a side.
    pub(super) x: [f32; 3],
    /// Its first small light.
    pub(super) first: u32,
    /// Along the next side.
    pub(super) y: [f32; 3],
    /// How many small lights it has.
    pub(super) count: u32,
    /// Which way it shines.
    pub(super) z: [f32; 3],
    /// What the angle of each adds to alpha^2.
    pub(super) spread: f32,
    /// Its middle.
    pub(super) center: [f32; 3],
    /// Size of a texel of a shadow map, in scene units at distance 1.
    pub(super) texel: f32,
    /// Radiance times area of each small light.
    pub(super) light: [f32; 3],
    /// Shadow maps across at distance 1.
    pub(super) scale: f32,
    /// Depth in shadow maps is `depth[0] + depth[1]/distance`.
    pub(super) depth: [f32; 2],
    /// Sides of the part of it that each stands for.
    pub(super) cell: [f32; 2],
    /// What is in the middle of all shadow maps: its place at distance 1, ...
    pub(super) pivot: [f32; 2],
    /// ... and one over its distance.
    pub(super) over: f32,
    /// To 8 bytes.
    pub(super) padding: f32,
    /// Sixteen small lights are at the first one's place and, for each bit of the index, ...
    pub(super) corner: [f32; 2],
    /// Half of its sides.
    pub(super) half_sides: [f32; 2],
    /// ... a step: of bits 0 and 1, ...
    pub(super) low_steps: [f32; 4],
    /// ... of 2 and 3.
    pub(super) high_steps: [f32; 4],
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
    /// Light from far away.
    pub(super) suns: Vec<Sun>,
    /// Light from nearby.
    pub(super) rectangles: Vec<Rectangle>,
    /// What rectangles become: their place on them, and the middle of the shadow map.
    pub(super) places: Vec<[f32; 4]>,
    /// World to the shadow map of each of these.
    pub(super) seen: Vec<Mat4>,
    /// Suns that are discs.
    pub(super) discs: Vec<Disc>,
}

impl Lamps {
    /// The lights of a scene; each rectangle becomes `per_rectangle` small ones, or as many as there is room for, rounded down to a
    /// power of two, each of which is at `shifts` places of its part of the rectangle in turn. Shadow maps of suns and of rectangles have so many
    /// texels a side and hold what `casters` has.
    ///
    /// # Errors
    /// If there are too many lights.
    pub(super) fn new(
        scene: &Scene,
        casters: &Casters,
        per_rectangle: usize,
        shifts: u32,
        [sun_size, rectangle_size]: [u32; 2],
    ) -> Result<Self, PreviewError> {
        let (needed, most) = (scene.lights.len() as u64, MOST_LAMPS as u64);
        if needed > most {
            return Err(PreviewError::TooLarge { what: "the number of lights", needed, most });
        }
        let mut all = Self::default();
        let rectangles = scene.lights.iter().filter(|l| matches!(l, Light::Area { .. })).count();
        // A power of two: so many parts of a rectangle have one point of Hammersley's set each.
        let per_rectangle = 1_usize << per_rectangle.clamp(1, MOST_PLACES / rectangles.max(1)).ilog2();
        let [sun_texels, rectangle_texels] = [sun_size, rectangle_size].map(|size| size.max(1) as f32);
        for light in &scene.lights {
            match *light {
                Light::Directional { direction, irradiance, angular_radius_rad } => {
                    let (shadow, width) = casters.seen_from_afar(direction);
                    all.suns.push(Sun {
                        direction: direction.to_array(),
                        // A disc of radius r has the variance r^2/4 along an axis, a quarter of that for the half vector,
                        // and alpha^2 is twice the variance of slopes.
                        spread: angular_radius_rad * angular_radius_rad / 8.0,
                        irradiance: irradiance.0,
                        texel: width / sun_texels,
                        shadow: shadow.to_cols_array_2d(),
                    });
                    all.discs.extend(Disc::new(light));
                }
                Light::Area { center, u, v, radiance } => {
                    let count = per_rectangle;
                    let area = 4.0 * u.cross(v).length() / count as f32;
                    let x = u.normalize_or(Vec3::X);
                    let z = u.cross(v).normalize_or(Vec3::Z);
                    let y = z.cross(x);
                    // As a disc of the same solid angle, as the scene sees it: r^2 = angle/pi.
                    let to = center - casters.middle();
                    let cosine = -to.normalize_or_zero().dot(z);
                    let angle = area * cosine.max(0.0) / to.length_squared().max(area) / shifts.max(1) as f32;
                    let first = all.places.len() as u32;
                    let places: Vec<Vec2> = (0..count)
                        .map(|i| {
                            let [s, t] = hammersley(i, count).map(|t| 2.0 * t - 1.0);
                            let at = u * s + v * t;
                            Vec2::new(at.dot(x), at.dot(y))
                        })
                        .collect();
                    let axes = Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), Vec4::W);
                    let look = axes.transpose() * Mat4::from_translation(-center);
                    let seen = casters.seen_from(&look, &places);
                    all.places.extend(places.iter().map(|place| {
                        let [u, v] = (seen.middle(*place) * seen.scale).to_array();
                        [place.x, place.y, 0.5 - u, 0.5 + v]
                    }));
                    all.seen.extend(places.iter().map(|place| {
                        let (s, m) = (2.0 * seen.scale, seen.middle(*place));
                        let project = Mat4::from_cols(
                            Vec4::new(s, 0.0, 0.0, 0.0),
                            Vec4::new(0.0, s, 0.0, 0.0),
                            Vec4::new(-s * m.x, -s * m.y, seen.depth[0], 1.0),
                            Vec4::new(0.0, 0.0, seen.depth[1], 0.0),
                        );
                        project * Mat4::from_translation(-place.extend(0.0)) * look
                    }));
                    let step = |i: usize| places.get(i).map_or(Vec2::ZERO, |place| *place - places[0]);
                    let half_sides = [u.length(), v.dot(y).abs()];
                    let columns = (1_usize << count.ilog2().div_ceil(2)) as f32;
                    let steps = |i: usize, j: usize| [step(i).x, step(i).y, step(j).x, step(j).y];
                    all.rectangles.push(Rectangle {
                        x: x.to_array(),
                        first,
                        y: y.to_array(),
                        count: count as u32,
                        z: z.to_array(),
                        spread: angle / (8.0 * PI),
                        center: center.to_array(),
                        texel: 1.0 / (seen.scale * rectangle_texels),
                        light: radiance.0.map(|r| r * area),
                        scale: seen.scale,
                        depth: seen.depth,
                        cell: [2.0 * half_sides[0] / columns, 2.0 * half_sides[1] * columns / count as f32],
                        half_sides,
                        pivot: seen.pivot.to_array(),
                        over: seen.over,
                        corner: places[0].to_array(),
                        low_steps: steps(1, 2),
                        high_steps: steps(4, 8),
                        ..Rectangle::default()
                    });
                }
            }
        }
        Ok(all)
    }

    /// Whether each rectangle is four right-angled quarters of four small lights, as places_shared.wgsl wants.
    pub(super) fn have_quarters(&self) -> bool {
        self.rectangles.iter().all(|r| {
            let middle = |toward: [usize; 2]| {
                let of = |p: usize| self.places[r.first as usize + 8 * toward[0] + 2 * p + toward[1]];
                [0, 1].map(|c| (0..4).map(|p| 0.25 * of(p)[c]).sum::<f32>())
            };
            let side = |t: usize, half: f32| if t == 0 { -half } else { half };
            let is_there = |toward: [usize; 2]| {
                let found = middle(toward);
                // Points of the set lean by an eighth.
                (0..2).all(|c| (found[c] - side(toward[c], r.cell[c])).abs() < 0.2 * r.cell[c])
            };
            r.count == 16 && [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().all(is_there)
        })
    }

    /// The uniform block `suns` of suns.wgsl.
    pub(super) fn sun_block(&self) -> Vec<u8> {
        let mut suns = self.suns.clone();
        suns.resize(MOST_LAMPS, Sun::default());
        bytemuck::cast_slice(&suns).to_vec()
    }

    /// The uniform block `Rectangles` of rectangles.wgsl.
    pub(super) fn rectangle_block(&self) -> Vec<u8> {
        let mut rectangles = self.rectangles.clone();
        rectangles.resize(MOST_LAMPS, Rectangle::default());
        let mut places = self.places.clone();
        places.resize(MOST_PLACES, [0.0; 4]);
        [bytemuck::cast_slice(&rectangles), bytemuck::cast_slice(&places)].concat()
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
pub(super) fn hammersley(i: usize, n: usize) -> [f32; 2] {
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

    /// The shadow maps of small lights at these places of a rectangle, in whose axes `look` is; they fit all casters if
    /// these are before it.
    fn seen_from(&self, look: &Mat4, places: &[Vec2]) -> Seen {
        let points: Vec<Vec3> = self.points.iter().map(|p| look.transform_point3(*p)).collect();
        let (near, far) = points.iter().fold((f32::INFINITY, 0.0_f32), |(a, b), p| (a.min(p.z), b.max(p.z)));
        if far <= 0.0 {
            // All middles are far outside: nothing is in a shadow.
            return Seen { scale: 1.0, depth: [0.0; 2], pivot: Vec2::splat(-1e6), over: 0.0 };
        }
        let (near, far) = (near.max(1e-3 * far) / EDGE, far * EDGE);
        // From among them a map sees this far to each side, and what is behind it casts nothing.
        let most = Vec2::splat(4.0);
        let projected = |p: &Vec3, place: Vec2| ((p.truncate() - place) / p.z.max(1e-6)).clamp(-most, most);
        let start = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (low, high) = points.iter().fold(start, |(low, high), p| {
            let p = projected(p, Vec2::ZERO);
            (low.min(p), high.max(p))
        });
        let depth = far / (far - near);
        let mut seen = Seen {
            scale: 1.0,
            depth: [depth, -depth * near],
            pivot: 0.5 * (low + high),
            over: 2.0 / (near + far),
        };
        let half = places.iter().fold(1e-6_f32, |half, place| {
            let middle = seen.middle(*place);
            let reach = |p| (projected(p, *place) - middle).abs().max_element();
            points.iter().fold(half, |half, p| half.max(reach(p)))
        });
        seen.scale = 1.0 / (2.0 * half * EDGE);
        seen
    }
}

/// Shadow maps that are as wide and as deep, and look at one point.
struct Seen {
    /// Maps across at distance 1.
    scale: f32,
    /// Depth is the first, and the second over the distance.
    depth: [f32; 2],
    /// Where the point is at distance 1, from the middle of the rectangle.
    pivot: Vec2,
    /// One over its distance.
    over: f32,
}

impl Seen {
    /// What a map looks at, at distance 1 of its light.
    fn middle(&self, place: Vec2) -> Vec2 {
        self.pivot - place * self.over
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

    /// Sixteen small lights of a rectangle are four quarters of four; fewer are not, nor are those of a slanted one.
    #[test]
    fn rectangles_have_quarters() {
        let scene = scene();
        let casters = Casters::new(&scene);
        let (x, y) = (Vec3::X * 3.0, Vec3::Z * 2.0);
        for (u, v, count, are) in
            [(x, y, 16, true), (x, y, 4, false), (x, y + x, 16, false), (y, x, 16, true)]
        {
            let mut scene = scene.clone();
            let (center, radiance) = (Vec3::Y * 9.0, LinearRgb([1.0; 3]));
            scene.lights = vec![Light::Area { center, u, v, radiance }];
            let lamps = Lamps::new(&scene, &casters, count, 1, [64; 2]).expect("few lights");
            assert_eq!(lamps.have_quarters(), are, "{u} {v} {count}");
        }
    }

    /// Everything that casts a shadow is in the map, the nearer the less deep; a floor is not among it.
    #[test]
    fn maps_hold_what_casts_shadows() {
        let scene = scene();
        let casters = Casters::new(&scene);
        assert_eq!(casters.objects, [0]);
        let to = Vec3::new(0.3, 0.8, -0.2).normalize();
        let center = casters.middle() + to * 12.0;
        let (u, v) = to.any_orthonormal_pair();
        let mut lit = scene.clone();
        lit.lights = vec![Light::Area { center, u: v, v: u, radiance: LinearRgb([1.0; 3]) }];
        let lamps = Lamps::new(&lit, &casters, 4, 1, [64; 2]).expect("one light");
        let far = |p: Vec3| -p.dot(to);
        let afar = [(casters.seen_from_afar(to).0, &far as &dyn Fn(Vec3) -> f32)];
        let near = |p: Vec3| (p - center).dot(-to);
        let nearby = lamps.seen.iter().map(|map| (*map, &near as &dyn Fn(Vec3) -> f32));
        for (map, distance) in afar.into_iter().chain(nearby) {
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
        let lamps = Lamps::new(&scene, &Casters::new(&scene), 16, 1, [64; 2]).expect("one light");
        assert_eq!((lamps.rectangles[0].count, lamps.places.len(), lamps.discs.len()), (16, 16, 0));
        let r = lamps.rectangles[0];
        let small: f32 = lamps
            .places
            .iter()
            .map(|[x, y, ..]| {
                let to = Vec3::from(r.center) + Vec3::from(r.x) * *x + Vec3::from(r.y) * *y;
                let direction = to.normalize();
                r.light[1] * direction.y * -direction.dot(Vec3::from(r.z)) / to.length_squared()
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
        let error = Lamps::new(&scene, &Casters::new(&scene), 16, 1, [64; 2]).expect_err("too many");
        assert_eq!(error.to_string(), "the number of lights needs 33, the adapter holds 32 at most");
        scene.lights.truncate(2);
        let lamps = Lamps::new(&scene, &Casters::new(&scene), 16, 1, [64; 2]).expect("two suns");
        assert_eq!((lamps.suns.len(), lamps.discs.len()), (2, 2));
        assert_eq!((lamps.sun_block().len(), lamps.rectangle_block().len()), (32 * 96, 32 * 160 + 128 * 16));
    }
}
