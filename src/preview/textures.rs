//! Maps on the device: bind group 2. Textures with levels for any distance.
//!
//! A level is the mean of what it covers, but for two things that are seen as a whole. Normals that differ below a pixel
//! leave, beside the direction of their mean, what its length lacks: shaders widen the lobe by it (Toksvig 2005; Olano &
//! Baker, LEAN mapping, 2010) and average the base's cosine. And the thickness of a film has, beside its mean, the width over
//! which it varies, by which interference is averaged.

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use wgpu::util::DeviceExt;

use super::{Gpu, PreviewError, film_table};
use crate::scene::{Material, SkinMaps, Texel};

/// `Plain` of maps_none.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PlainUniform {
    /// Albedo.
    pub(super) albedo: [f32; 3],
    /// Perceptual roughness.
    pub(super) roughness: f32,
    /// Film thickness, nm, and three of nothing.
    pub(super) thickness: [f32; 4],
}

/// A texel of a level, as sums of means need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Mean {
    color: [f32; 3],
    /// Of alpha^2.
    alpha_2: f32,
    normal: [f32; 3],
    /// In parts of the thickest.
    thickness: f32,
    thickness_2: f32,
}

impl Mean {
    fn of(texel: &Texel, per_nm: f32) -> Self {
        let alpha = texel.roughness * texel.roughness;
        let thickness = texel.thickness_nm * per_nm;
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

/// The next level of one of `width` by `height` texels, which `at` gives.
fn halve(width: usize, height: usize, at: impl Fn(usize) -> Mean + Sync) -> Vec<Mean> {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let row = |y: usize| {
        let rows = taps(y, height);
        let at = &at;
        (0..w).map(move |x| {
            let mut mean = Mean::default();
            for (column, a) in taps(x, width) {
                for (row, b) in rows {
                    if a * b > 0.0 {
                        mean.add(&at(row * width + column), a * b);
                    }
                }
            }
            mean
        })
    };
    (0..h).into_par_iter().flat_map_iter(row).collect()
}

/// A level as textures hold it, texel by texel.
struct Level {
    /// Albedo and roughness.
    color: Vec<[f16; 4]>,
    /// Normal's x and y, thickness, and 1 - the squared length of the mean normal.
    form: Vec<[f16; 4]>,
    /// Over which the thickness varies.
    width: Vec<f16>,
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
fn levels(maps: &SkinMaps, per_nm: f32) -> Vec<Level> {
    let (mut width, mut height) = (maps.width, maps.height);
    let texel = |i: usize| Mean::of(&maps.texels[i], per_nm);
    let mut levels = vec![encode(maps.texels.len(), texel)];
    let mut last: Option<Vec<Mean>> = None;
    while width > 1 || height > 1 {
        let next = match &last {
            None => halve(width, height, texel),
            Some(last) => halve(width, height, |i| last[i]),
        };
        levels.push(encode(next.len(), |i| next[i]));
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        last = Some(next);
    }
    levels
}

/// The surface of a material on the device.
#[derive(Debug)]
pub(super) struct Surface {
    /// Bind group 2.
    pub(super) group: wgpu::BindGroup,
    /// Its layout.
    pub(super) layout: wgpu::BindGroupLayout,
    /// Name and bytes of each texture.
    pub(super) textures: Vec<(&'static str, u64)>,
    /// Whether the table of [`film_table`] is among them.
    pub(super) film_table: bool,
    /// Whether its film varies below a texel of some level.
    pub(super) film_width: bool,
}

impl Surface {
    /// Copy the maps of a material, or its constants; `anisotropy` is the most samples along a slanted view.
    ///
    /// # Errors
    /// If the maps are larger than the adapter holds, or an index of the film is out of range.
    pub(super) fn new(gpu: &Gpu, material: &Material, anisotropy: u16) -> Result<Self, PreviewError> {
        match &material.maps {
            Some(maps) => Self::mapped(gpu, maps, material.constants.indices, anisotropy),
            None => Ok(Self::plain(gpu, material)),
        }
    }

    fn plain(gpu: &Gpu, material: &Material) -> Self {
        let uniform = PlainUniform {
            albedo: material.color.0,
            roughness: material.roughness,
            thickness: [material.thickness_nm, 0.0, 0.0, 0.0],
        };
        let block = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("plain surface"),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("plain surface"),
            entries: &[uniform_entry(0)],
        });
        let entries = [wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() }];
        let label = Some("plain surface");
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &layout,
            entries: &entries,
        });
        Self { group, layout, textures: Vec::new(), film_table: false, film_width: false }
    }

    fn mapped(gpu: &Gpu, maps: &SkinMaps, indices: [f32; 3], anisotropy: u16) -> Result<Self, PreviewError> {
        let most = u64::from(gpu.device.limits().max_texture_dimension_2d);
        gpu.fits("a side of a map in texels", maps.width.max(maps.height) as u64, most)?;
        let thickest = maps.texels.iter().fold(0.0_f32, |most, t| most.max(t.thickness_nm));
        let scale = if thickest > 0.0 { thickest } else { 1.0 };
        let levels = levels(maps, 1.0 / scale);
        let size = [maps.width, maps.height, 1];
        let make = |name: &'static str, format, texels: &dyn Fn(&Level) -> &[f16]| {
            let data: Vec<u16> = levels.iter().flat_map(|l| texels(l).reinterpret_cast()).copied().collect();
            let bytes: &[u8] = bytemuck::cast_slice(&data);
            let texture = upload(gpu, name, format, size, levels.len(), bytes);
            (texture.create_view(&wgpu::TextureViewDescriptor::default()), (name, bytes.len() as u64))
        };
        let (color, color_size) = make("albedo and roughness", FOUR, &|l| l.color.as_flattened());
        let (form, form_size) = make("normal and film", FOUR, &|l| l.form.as_flattened());
        let varies = levels.iter().any(|l| l.width.iter().any(|w| *w > f16::ZERO));
        let width = varies.then(|| make("spread of film", wgpu::TextureFormat::R16Float, &|l| &l.width));
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("maps"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: anisotropy.max(1),
            ..Default::default()
        });
        let block = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("scale of maps"),
            contents: bytemuck::cast_slice(&[scale, 0.0, 0.0, 0.0]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let sampled = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let mut entries = vec![
            uniform_entry(0),
            texture_entry(1, wgpu::TextureViewDimension::D2),
            texture_entry(2, wgpu::TextureViewDimension::D2),
            entry(3, sampled),
        ];
        let mut resources = vec![
            block.as_entire_binding(),
            wgpu::BindingResource::TextureView(&color),
            wgpu::BindingResource::TextureView(&form),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let mut sizes = vec![color_size, form_size];
        let film = (thickest > 0.0 && thickest <= film_table::THICKEST_NM)
            .then(|| film_texture(gpu, indices, scale))
            .transpose()?;
        let film_sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("film"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        if let Some((view, bytes)) = &film {
            entries.extend([texture_entry(4, wgpu::TextureViewDimension::D2Array), entry(5, sampled)]);
            resources.extend([
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(&film_sampler),
            ]);
            sizes.push(("film by cosine and thickness", *bytes));
        }
        if let Some((view, size)) = &width {
            entries.push(texture_entry(6, wgpu::TextureViewDimension::D2));
            resources.push(wgpu::BindingResource::TextureView(view));
            sizes.push(*size);
        }
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("maps"),
            entries: &entries,
        });
        let resources = entries.iter().map(|e| e.binding).zip(resources);
        let resources: Vec<_> =
            resources.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        let label = Some("maps");
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &layout,
            entries: &resources,
        });
        Ok(Self { group, layout, textures: sizes, film_table: film.is_some(), film_width: width.is_some() })
    }
}

/// The table of a film on the device, and its size.
fn film_texture(
    gpu: &Gpu,
    indices: [f32; 3],
    thickest_nm: f32,
) -> Result<(wgpu::TextureView, u64), PreviewError> {
    let texels =
        film_table::table(indices, thickest_nm).map_err(|e| PreviewError::Material(e.to_string()))?;
    let bytes: &[u8] = bytemuck::cast_slice(texels.reinterpret_cast());
    let size = [film_table::COSINES, film_table::THICKNESSES, film_table::LAYERS];
    let texture = upload(gpu, "film", FOUR, size, 1, bytes);
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    Ok((view, bytes.len() as u64))
}

/// Four halves a texel.
pub(super) const FOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// A texture to read: columns, rows and layers, with so many levels, layer by layer.
pub(super) fn upload(
    gpu: &Gpu,
    name: &str,
    format: wgpu::TextureFormat,
    [width, height, layers]: [usize; 3],
    levels: usize,
    bytes: &[u8],
) -> wgpu::Texture {
    let descriptor = wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d {
            width: width as u32,
            height: height as u32,
            depth_or_array_layers: layers as u32,
        },
        mip_level_count: levels as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, bytes)
}

/// A bind group of these resources, from binding 0 on.
pub(super) fn group<'a>(
    gpu: &Gpu,
    name: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(i, resource)| wgpu::BindGroupEntry { binding: i as u32, resource };
    let entries: Vec<_> = resources.into_iter().enumerate().map(entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(name), layout, entries: &entries })
}

/// A binding that vertex and fragment shaders see.
pub(super) fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::VERTEX_FRAGMENT, ty, count: None }
}

/// A uniform block.
pub(super) fn uniform_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BufferBindingType::Uniform;
    entry(binding, wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None })
}

/// A texture that is filtered.
pub(super) fn texture_entry(
    binding: u32,
    dimension: wgpu::TextureViewDimension,
) -> wgpu::BindGroupLayoutEntry {
    entry(
        binding,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: dimension,
            multisampled: false,
        },
    )
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
            let all = levels(&maps, 1.0);
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
        let all = levels(&maps, 1.0 / 600.0);
        let (color, form, width) = texel(&all[1], 0);
        assert!((color[3] - 0.3).abs() < 3e-4, "{}", color[3]);
        let expected = slope * slope / (1.0 + slope * slope);
        assert!((form[3] - expected).abs() < 1e-5, "{} for {expected}", form[3]);
        assert!(form[0].abs() < 1e-6 && (form[2] * 600.0 - 400.0).abs() < 0.5);
        assert!((width * 600.0 - 200.0 * 12.0_f32.sqrt()).abs() < 1.0);
        // And where nothing is hidden, nothing is kept.
        let (color, form, width) = texel(&all[0], 1);
        assert!((color[3] - 0.3).abs() < 3e-4 && form[3] == 0.0 && width == 0.0);
    }
}
