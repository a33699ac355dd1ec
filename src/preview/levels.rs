//! Levels of maps, for any distance.
//!
//! A level is the mean of what it covers, but for two things that are seen as a whole. Normals that differ below a pixel
//! leave, beside the direction of their mean, what its length lacks: shaders widen the lobe by it (Toksvig 2005; Olano &
//! Baker, LEAN mapping, 2010) and average the base's cosine. And the thickness of a film has, beside its mean, the width over
//! which it varies, by which interference is averaged.

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use super::textures::FOUR;
use crate::scene::{SkinMaps, Texel};

/// What the texels' thickness of a film stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Thickness {
    /// The thinnest, nm.
    least_nm: f32,
    /// The thickest, nm.
    pub(super) most_nm: f32,
}

impl Thickness {
    /// Of maps; none has texels, or all are 0.
    pub(super) fn of(maps: &SkinMaps) -> Self {
        let start = (f32::INFINITY, 0.0_f32);
        let (least, most) = maps
            .texels
            .iter()
            .map(|t| t.thickness_nm)
            .fold(start, |(least, most), nm| (least.min(nm), most.max(nm)));
        Self { least_nm: least.max(0.0).min(most), most_nm: most }
    }

    /// `map_scale` of maps.wgsl.
    pub(super) fn block(self) -> [f32; 4] {
        [self.most_nm - self.least_nm, self.most_nm.max(1e-6), self.least_nm, 0.0]
    }

    /// From 0, the thinnest, to 1.
    fn share(self, nm: f32) -> f32 {
        let range = self.most_nm - self.least_nm;
        if range > 0.0 { (nm - self.least_nm) / range } else { 0.0 }
    }
}

/// A texel of a level, as sums of means need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Mean {
    color: [f32; 3],
    /// Of alpha^2.
    alpha_2: f32,
    normal: [f32; 3],
    /// From the thinnest to the thickest.
    thickness: f32,
    thickness_2: f32,
}

impl Mean {
    fn of(texel: &Texel, thickness: Thickness) -> Self {
        let alpha = texel.roughness * texel.roughness;
        let thickness = thickness.share(texel.thickness_nm);
        Self {
            color: texel.color,
            alpha_2: alpha * alpha,
            normal: texel.normal,
            thickness,
            thickness_2: thickness * thickness,
        }
    }

    fn add(&mut self, other: &Self, weight: f32) {
        for c in 0..3 {
            self.color[c] += weight * other.color[c];
            self.normal[c] += weight * other.normal[c];
        }
        self.alpha_2 += weight * other.alpha_2;
        self.thickness += weight * other.thickness;
        self.thickness_2 += weight * other.thickness_2;
    }

    /// A texel of each texture.
    fn encode(&self) -> ([f32; 4], [f32; 4], f32) {
        let [r, g, b] = self.color;
        let [x, y, z] = self.normal;
        let length_2 = (x * x + y * y + z * z).min(1.0);
        let hidden = 1.0 - length_2;
        // Less is rounding.
        let hidden = if hidden > 1e-5 { hidden } else { 0.0 };
        let scale = 1.0 / length_2.sqrt().max(1e-4);
        // Of an even spread of the same variance.
        let variance = (self.thickness_2 - self.thickness * self.thickness).max(0.0);
        let width = if variance > 1e-9 { (12.0 * variance).sqrt() } else { 0.0 };
        let roughness = self.alpha_2.sqrt().sqrt();
        ([r, g, b, roughness], [x * scale, y * scale, self.thickness, hidden], width)
    }
}

/// Indices and weights of the texels of a side of `n` that texel `i` of a side of `n/2` covers.
fn taps(i: usize, n: usize) -> [(usize, f32); 3] {
    if n == 1 {
        return [(0, 1.0), (0, 0.0), (0, 0.0)];
    }
    let m = n / 2;
    if n.is_multiple_of(2) {
        return [(2 * i, 0.5), (2 * i + 1, 0.5), (2 * i, 0.0)];
    }
    let part = |k: usize| k as f32 / n as f32;
    [(2 * i, part(m - i)), (2 * i + 1, part(m)), (2 * i + 2, part(i + 1))]
}

/// The next level of one of `width` by `height` texels, which `at` gives and `add` adds with a weight.
pub(super) fn halve<T: Default + Send>(
    width: usize,
    height: usize,
    at: impl Fn(usize) -> T + Sync,
    add: impl Fn(&mut T, &T, f32) + Sync,
) -> Vec<T> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let row = |y: usize| {
        let rows = taps(y, height);
        let (at, add) = (&at, &add);
        (0..w).map(move |x| {
            let mut mean = T::default();
            for (column, a) in taps(x, width) {
                for (row, b) in rows {
                    if a * b > 0.0 {
                        add(&mut mean, &at(row * width + column), a * b);
                    }
                }
            }
            mean
        })
    };
    (0..h).into_par_iter().flat_map_iter(row).collect()
}

/// A level as textures hold it, texel by texel.
pub(super) struct Level {
    /// Albedo and roughness.
    color: Vec<[f16; 4]>,
    /// Normal's x and y, thickness, and 1 - the squared length of the mean normal.
    form: Vec<[f16; 4]>,
    /// Over which the thickness varies.
    pub(super) width: Vec<f16>,
}

/// A texture of a level.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    /// Albedo and roughness.
    Color,
    /// Normal and film.
    Form,
    /// Variation of the film.
    Width,
}

impl Part {
    /// Of halves, and of bytes.
    pub(super) fn formats(self) -> [wgpu::TextureFormat; 2] {
        match self {
            Self::Color | Self::Form => [FOUR, wgpu::TextureFormat::Rgba8Unorm],
            Self::Width => [wgpu::TextureFormat::R16Float, wgpu::TextureFormat::R8Unorm],
        }
    }
}

impl Level {
    pub(super) fn halves(&self, part: Part) -> &[u16] {
        match part {
            Part::Color => self.color.as_flattened(),
            Part::Form => self.form.as_flattened(),
            Part::Width => &self.width,
        }
        .reinterpret_cast()
    }

    /// What texels_byte.wgsl reads: roots of what is small where it matters, and slopes around 128.
    pub(super) fn bytes(&self, part: Part) -> Vec<u8> {
        fn even(x: f32) -> u8 {
            (255.0 * x + 0.5) as u8
        }
        fn root(x: f32) -> u8 {
            even(x.sqrt())
        }
        fn slope(x: f32) -> u8 {
            (128.5 + 127.0 * x) as u8
        }
        let four = |texels: &[[f16; 4]], byte: fn([f32; 4]) -> [u8; 4]| -> Vec<u8> {
            texels.iter().flat_map(|t| byte(t.map(f16::to_f32))).collect()
        };
        match part {
            Part::Color => four(&self.color, |[r, g, b, a]| [root(r), root(g), root(b), even(a)]),
            Part::Form => four(&self.form, |[x, y, z, w]| [slope(x), slope(y), even(z), root(w)]),
            Part::Width => self.width.iter().map(|w| root(w.to_f32())).collect(),
        }
    }
}

/// A level as textures hold it.
fn encode(len: usize, at: impl Fn(usize) -> Mean + Sync) -> Level {
    const CHUNK: usize = 4096;
    let zero = [f16::ZERO; 4];
    let mut level = Level { color: vec![zero; len], form: vec![zero; len], width: vec![f16::ZERO; len] };
    let chunks = level.color.par_chunks_mut(CHUNK).zip(level.form.par_chunks_mut(CHUNK));
    chunks.zip(level.width.par_chunks_mut(CHUNK)).enumerate().for_each(|(chunk, ((color, form), width))| {
        let mut texels = [[0.0; 4]; 3 * CHUNK];
        let [a, b, c] = [0, 1, 2].map(|k| k * CHUNK);
        for i in 0..color.len() {
            let (color, form, width) = at(chunk * CHUNK + i).encode();
            (texels[a + i], texels[b + i]) = (color, form);
            texels[c + i / 4][i % 4] = width;
        }
        let len = color.len();
        color.as_flattened_mut().convert_from_f32_slice(texels[a..a + len].as_flattened());
        form.as_flattened_mut().convert_from_f32_slice(texels[b..b + len].as_flattened());
        width.convert_from_f32_slice(&texels[c..].as_flattened()[..len]);
    });
    level
}

/// Every level of the maps, from the sharpest to a single texel.
pub(super) fn levels(maps: &SkinMaps, thickness: Thickness) -> Vec<Level> {
    let (mut width, mut height) = (maps.width, maps.height);
    let texel = |i: usize| Mean::of(&maps.texels[i], thickness);
    let mut levels = vec![encode(maps.texels.len(), texel)];
    let mut last: Option<Vec<Mean>> = None;
    while width > 1 || height > 1 {
        let next = match &last {
            None => halve(width, height, texel, Mean::add),
            Some(last) => halve(width, height, |i| last[i], Mean::add),
        };
        levels.push(encode(next.len(), |i| next[i]));
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        last = Some(next);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(width: usize, height: usize, f: impl Fn(usize, usize) -> Texel) -> SkinMaps {
        let texels = (0..width * height).map(|i| f(i % width, i / width)).collect();
        SkinMaps { width, height, texels, height_mm: None, size_mm: [1.0; 2] }
    }

    fn texel(level: &Level, i: usize) -> ([f32; 4], [f32; 4], f32) {
        (level.color[i].map(f16::to_f32), level.form[i].map(f16::to_f32), level.width[i].to_f32())
    }

    /// Every texel counts alike in every level, also where sides are odd.
    #[test]
    fn the_last_level_is_the_mean_of_all() {
        for (w, h) in [(1, 1), (4, 8), (7, 5), (1, 6), (33, 10)] {
            let value = |x: usize, y: usize| ((5 * x + 3 * y * y) % 11) as f32 / 11.0;
            let maps = maps(w, h, |x, y| Texel {
                color: [value(x, y), 0.5, 1.0],
                roughness: 0.5,
                normal: [0.0, 0.0, 1.0],
                thickness_nm: 0.0,
            });
            let all = levels(&maps, Thickness::of(&maps));
            assert_eq!(all.len(), w.max(h).ilog2() as usize + 1);
            let (color, form, _) = texel(&all[all.len() - 1], 0);
            let mean = (0..w * h).map(|i| value(i % w, i / w)).sum::<f32>() / (w * h) as f32;
            assert!((color[0] - mean).abs() < 1e-3, "{w}x{h}: {} for {mean}", color[0]);
            assert!((color[3] - 0.5).abs() < 1e-3 && form == [0.0; 4]);
        }
    }

    /// The mean of two normals that lean by a slope is as short as their cosine; thickness between two values has their
    /// spread.
    #[test]
    fn what_a_level_hides_is_kept() {
        let slope = 0.1_f32;
        let maps = maps(2, 2, |x, _| {
            let z = 1.0 / (1.0 + slope * slope).sqrt();
            let lean = if x == 0 { -slope * z } else { slope * z };
            Texel {
                color: [0.5; 3],
                roughness: 0.3,
                normal: [lean, 0.0, z],
                thickness_nm: if x == 0 { 200.0 } else { 600.0 },
            }
        });
        let all = levels(&maps, Thickness::of(&maps));
        let (color, form, width) = texel(&all[1], 0);
        assert!((color[3] - 0.3).abs() < 3e-4, "{}", color[3]);
        let expected = slope * slope / (1.0 + slope * slope);
        assert!((form[3] - expected).abs() < 1e-5, "{} for {expected}", form[3]);
        assert!(form[0].abs() < 1e-6 && (form[2] * 400.0 - 200.0).abs() < 0.5);
        assert!((width * 400.0 - 200.0 * 12.0_f32.sqrt()).abs() < 1.0);
        // And where nothing is hidden, nothing is kept.
        let (color, form, width) = texel(&all[0], 1);
        assert!((color[3] - 0.3).abs() < 3e-4 && form[3] == 0.0 && width == 0.0);
    }

    /// Bytes are the halves to half a step: of slopes, of roots of colours, and of thickness between its ends.
    #[test]
    fn bytes_are_as_near_as_they_can_be() {
        let maps = maps(64, 1, |x, _| {
            let t = x as f32 / 63.0;
            let z = (1.0 - 0.81 * t * t).sqrt();
            let color = [t, t * t, 1.0 - t];
            Texel { color, roughness: t, normal: [-0.9 * t, 0.0, z], thickness_nm: 200.0 + 50.0 * t }
        });
        let level = &levels(&maps, Thickness::of(&maps))[0];
        let [color, form] = [Part::Color, Part::Form].map(|part| level.bytes(part));
        for i in 0..64 {
            let (halves, form_halves, _) = texel(level, i);
            let unit = |b: u8| f32::from(b) / 255.0;
            for c in 0..3 {
                assert!((unit(color[4 * i + c]) - halves[c].sqrt()).abs() < 0.0025);
            }
            assert!((unit(color[4 * i + 3]) - halves[3]).abs() < 0.0025);
            let slope = (f32::from(form[4 * i]) - 128.0) / 127.0;
            assert!((slope - form_halves[0]).abs() < 0.0045 && form[4 * i + 1] == 128);
            let nm = 200.0 + 50.0 * unit(form[4 * i + 2]);
            assert!((nm - maps.texels[i].thickness_nm).abs() < 0.15, "{nm}");
        }
    }
}
