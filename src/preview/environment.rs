//! Light from all around, made ready on the CPU: for each roughness the picture as a lobe of that width sees it, and the
//! irradiance.
//!
//! A layer is the octahedron unfolded into a square (Engelhardt & Dachsbacher 2008), with texel centres on its edges. Each
//! texel is a sum over few directions of a lobe, each read from a level of the picture about as coarse as the directions are
//! far apart (Krivanek & Colbert, GPU Gems 3, ch. 20); the directions are the same for all texels. Irradiance is a sum over all
//! of a coarse level.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use super::{Gpu, textures};
use crate::base::{LinearRgb, num};
use crate::scene::{Environment, EnvironmentImage, Scene};

/// Texels of a side of a layer.
pub(super) const SIDE: usize = 128;
/// Layers of roughness, from 0 to 1.
pub(super) const LAYERS: usize = 8;
/// Directions of a lobe.
const DIRECTIONS: usize = 48;
/// Most columns of the level that irradiance is a sum over.
const COSINE_COLUMNS: usize = 64;
/// Columns of the sharpest level that is filtered.
const MOST_COLUMNS: usize = 1024;
/// Most radiance that a half holds.
const BRIGHTEST: f32 = 60_000.0;

/// The layers of a scene, `LAYERS + 1` of `SIDE` x `SIDE` texels of four halves each: see the module. `None` where the same
/// comes from everywhere.
pub(super) fn layers(scene: &Scene) -> Option<Vec<f16>> {
    let Environment::Image(picture) = &scene.environment else { return None };
    if scene.environment.is_black() {
        return None;
    }
    let levels = levels(picture.as_ref().clone());
    let lobes: Vec<Vec<Direction>> =
        (0..LAYERS).map(|i| gloss(i as f32 / (LAYERS - 1) as f32, &levels)).collect();
    let coarse = levels.iter().find(|level| level.width <= COSINE_COLUMNS).or(levels.last())?;
    let patches = patches(coarse);
    let mut out = vec![f16::ZERO; 4 * SIDE * SIDE * (LAYERS + 1)];
    out.par_chunks_mut(4 * SIDE).enumerate().for_each(|(row, texels)| {
        let y = row % SIDE;
        for (x, texel) in texels.chunks_exact_mut(4).enumerate() {
            let normal = unfolded(x, y);
            let sum = match lobes.get(row / SIDE) {
                Some(lobe) => blurred(&levels, lobe, normal),
                None => by_cosine(&patches, normal),
            };
            (0..3).for_each(|i| texel[i] = f16::from_f32(sum[i].min(BRIGHTEST)));
        }
    });
    Some(out)
}

/// Layers on the device.
pub(super) fn texture(gpu: &Gpu, texels: &[f16]) -> wgpu::TextureView {
    let bytes = bytemuck::cast_slice(texels.reinterpret_cast());
    let texture =
        textures::upload(gpu, "environment by roughness", textures::FOUR, [SIDE, SIDE, LAYERS + 1], 1, bytes);
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// The picture, and coarser and coarser means of it.
fn levels(mut picture: EnvironmentImage) -> Vec<EnvironmentImage> {
    while picture.width > MOST_COLUMNS {
        picture = halved(&picture);
    }
    let mut levels = vec![picture];
    while let Some(last) = levels.last().filter(|last| last.width > 8 && last.height > 4) {
        levels.push(halved(last));
    }
    levels
}

/// Half as many columns and rows; what an odd last one shows is left out.
fn halved(picture: &EnvironmentImage) -> EnvironmentImage {
    let (width, height) = (picture.width / 2, picture.height / 2);
    // Rows towards the poles cover less.
    let share = |y: usize| num::sin_turns(0.5 * (y as f32 + 0.5) / picture.height as f32);
    let texels = (0..width * height).map(|i| {
        let (x, y) = (2 * (i % width), 2 * (i / width));
        let (a, b) = (share(y), share(y + 1));
        let at = |x: usize, y: usize| picture.texels[y * picture.width + x];
        let (p, q, r, s) = (at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1));
        std::array::from_fn(|c| 0.5 * (a * (p[c] + q[c]) + b * (r[c] + s[c])) / (a + b))
    });
    EnvironmentImage { width, height, texels: texels.collect() }
}

/// A direction of a lobe around z.
struct Direction {
    towards: Vec3,
    weight: f32,
    level: usize,
}

/// The lobe of GGX of this roughness, seen along its normal: directions mirrored at facets, by the cosine.
fn gloss(roughness: f32, levels: &[EnvironmentImage]) -> Vec<Direction> {
    let alpha_2 = (roughness * roughness).powi(2);
    if alpha_2 < 1e-8 {
        return vec![Direction { towards: Vec3::Z, weight: 1.0, level: 0 }];
    }
    weighted(
        (0..DIRECTIONS).map(|i| {
            let (u, around) = point(i);
            let cos_2 = (1.0 - u) / (1.0 + (alpha_2 - 1.0) * u);
            let facet = towards(cos_2.sqrt(), around);
            let mirrored = facet * (2.0 * facet.z) - Vec3::Z;
            let t = 1.0 + (alpha_2 - 1.0) * cos_2;
            // Density of facets over 4, as the facet and the view have one angle.
            (mirrored, mirrored.z, alpha_2 / (4.0 * PI * t * t))
        }),
        levels,
    )
}

/// What a lobe around `normal` sees.
fn blurred(levels: &[EnvironmentImage], lobe: &[Direction], normal: Vec3) -> [f32; 3] {
    let (s, t) = normal.any_orthonormal_pair();
    let axes = Mat3::from_cols(s, t, normal);
    lobe.iter().fold([0.0; 3], |sum, d| {
        let LinearRgb(c) = levels[d.level].radiance(axes * d.towards);
        [0, 1, 2].map(|i| sum[i] + d.weight * c[i])
    })
}

/// A part of the sky: the direction of its middle, and its radiance times its solid angle over pi.
type Patch = (Vec3, [f32; 3]);

/// The texels of a picture.
fn patches(picture: &EnvironmentImage) -> Vec<Patch> {
    let (width, height) = (picture.width, picture.height);
    let patch = |i: usize| {
        let (x, y) = (i % width, i / width);
        let [top, bottom] = [y, y + 1].map(|y| num::cos_turns(0.5 * y as f32 / height as f32));
        let angle = 2.0 * (top - bottom) / width as f32;
        (picture.direction(x, y), picture.texels[i].map(|c| c * angle))
    };
    (0..width * height).map(patch).collect()
}

/// Irradiance over pi of a surface that faces along `normal`: all of the sky, as its cosine is so wide that few directions leave
/// half a percent, which is seen on what is even.
fn by_cosine(patches: &[Patch], normal: Vec3) -> [f32; 3] {
    patches.iter().fold([0.0; 3], |sum, (towards, light)| {
        let cosine = normal.dot(*towards).max(0.0);
        [0, 1, 2].map(|i| sum[i] + cosine * light[i])
    })
}

/// Directions with their weight and density as a lobe, those below the horizon left out.
fn weighted(
    directions: impl Iterator<Item = (Vec3, f32, f32)>,
    levels: &[EnvironmentImage],
) -> Vec<Direction> {
    let all: Vec<_> = directions.collect();
    let count = all.len() as f32;
    // Of a texel at the equator of the sharpest level.
    let texel = 2.0 * (PI / levels[0].height as f32).powi(2);
    let mut lobe: Vec<Direction> = all
        .into_iter()
        .filter(|(_, weight, _)| *weight > 0.0)
        .map(|(towards, weight, density)| {
            let solid_angle = 1.0 / (count * density.max(1e-6));
            let level = (0.5 * num::log2((solid_angle / texel).max(1.0))).ceil() as usize;
            Direction { towards, weight, level: level.min(levels.len() - 1) }
        })
        .collect();
    let sum: f32 = lobe.iter().map(|d| d.weight).sum();
    lobe.iter_mut().for_each(|d| d.weight /= sum);
    lobe
}

/// Point `i` of a sequence that is even over the unit square at any length (Roberts 2018), as (u, turns).
fn point(i: usize) -> (f32, f32) {
    (num::fract(0.5 + 0.754_877_7 * i as f32), num::fract(0.5 + 0.569_840_3 * i as f32))
}

fn towards(cos: f32, turns: f32) -> Vec3 {
    let sin = num::safe_sqrt(1.0 - cos * cos);
    Vec3::new(sin * num::cos_turns(turns), sin * num::sin_turns(turns), cos)
}

/// The direction that a texel of a layer shows.
fn unfolded(x: usize, y: usize) -> Vec3 {
    let at = |i: usize| 2.0 * i as f32 / (SIDE - 1) as f32 - 1.0;
    let (px, pz) = (at(x), at(y));
    let height = 1.0 - px.abs() - pz.abs();
    let fold = |p: f32, q: f32| if height < 0.0 { (1.0 - q.abs()).copysign(p) } else { p };
    Vec3::new(fold(px, pz), height, fold(pz, px)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Inputs, SceneSpec};
    use std::sync::Arc;

    fn scene(environment: Environment) -> Scene {
        let mut spec = SceneSpec::default();
        spec.subject.triangles = 1000;
        let mut scene = Scene::build(&spec, &Inputs::default()).expect("it can be built");
        scene.environment = environment;
        scene.lights.clear();
        scene
    }

    fn picture(f: impl Fn(Vec3) -> f32) -> Environment {
        Environment::Image(Arc::new(EnvironmentImage::from_fn(256, 128, |d| LinearRgb([f(d); 3]))))
    }

    /// The texel of a layer that shows the direction of its index.
    fn texel(layers: &[f16], layer: usize, x: usize, y: usize) -> f32 {
        layers[4 * ((layer * SIDE + y) * SIDE + x)].to_f32()
    }

    #[test]
    fn even_light_and_darkness_need_no_layers() {
        for radiance in [0.5, 0.0] {
            assert_eq!(layers(&scene(Environment::Constant(LinearRgb([radiance; 3])))), None);
            assert_eq!(layers(&scene(picture(|_| radiance))).is_some(), radiance > 0.0);
        }
    }

    /// Of light that grows with the height: irradiance over pi is 2/3 above and 0 below; the mirror shows it as it is, and
    /// every lobe in between has a mean between these.
    #[test]
    fn layers_are_lobes_of_growing_width() {
        let layers = layers(&scene(picture(|d| d.y.max(0.0)))).expect("a picture");
        let up = |layer| texel(&layers, layer, SIDE / 2, SIDE / 2);
        assert!((up(0) - 1.0).abs() < 0.01, "{}", up(0));
        assert!((up(LAYERS) - 2.0 / 3.0).abs() < 0.01, "{}", up(LAYERS));
        assert!(texel(&layers, LAYERS, 0, 0) < 0.01);
        for layer in 1..LAYERS {
            assert!(up(layer) < up(layer - 1) + 1e-3, "{layer}");
        }
        for (x, y) in [(10, 90), (64, 0), (127, 64), (100, 30)] {
            let d = unfolded(x, y);
            assert!((texel(&layers, 0, x, y) - d.y.max(0.0)).abs() < 0.01, "{d}");
        }
    }
}
