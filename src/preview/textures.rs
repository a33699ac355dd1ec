//! Maps on the device: bind group 2.

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use wgpu::util::DeviceExt;

use super::levels::{Part, Thickness, levels};
use super::options::Options;
use super::relief::Relief;
use super::{Gpu, PreviewError, film_table};
use crate::optics::layered::Constants;
use crate::scene::{Material, SkinMaps};

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
    /// Whether the relief of its height map is there.
    pub(super) relief: bool,
}

impl Surface {
    /// Copy the maps of a material, or its constants; compact maps are bytes.
    ///
    /// # Errors
    /// If the maps are larger than the adapter holds, or an index of the film is out of range.
    pub(super) fn new(
        gpu: &Gpu,
        material: &Material,
        options: &Options,
        compact: bool,
    ) -> Result<Self, PreviewError> {
        match &material.maps {
            Some(maps) => Self::mapped(gpu, maps, &material.constants, options, compact),
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
        let textures = Vec::new();
        Self { group, layout, textures, film_table: false, film_width: false, relief: false }
    }

    fn mapped(
        gpu: &Gpu,
        maps: &SkinMaps,
        constants: &Constants,
        options: &Options,
        compact: bool,
    ) -> Result<Self, PreviewError> {
        let most = u64::from(gpu.device.limits().max_texture_dimension_2d);
        gpu.fits("a side of a map in texels", maps.width.max(maps.height) as u64, most)?;
        let thickness = Thickness::of(maps);
        let levels = levels(maps, thickness);
        let size = [maps.width, maps.height, 1];
        let make = |name: &'static str, part: Part| {
            let [halves, texel_bytes] = part.formats();
            let (format, data): (_, Vec<u8>) = match compact {
                true => (texel_bytes, levels.par_iter().flat_map_iter(|l| l.bytes(part)).collect()),
                false => (
                    halves,
                    levels.iter().flat_map(|l| bytemuck::cast_slice(l.halves(part))).copied().collect(),
                ),
            };
            let texture = upload(gpu, name, format, size, levels.len(), &data);
            (texture.create_view(&wgpu::TextureViewDescriptor::default()), (name, data.len() as u64))
        };
        let (color, color_size) = make("albedo and roughness", Part::Color);
        let (form, form_size) = make("normal and film", Part::Form);
        let varies = levels.iter().any(|l| l.width.iter().any(|w| *w > f16::ZERO));
        let width = varies.then(|| make("spread of film", Part::Width));
        let filtered = wgpu::SamplerDescriptor {
            label: Some("maps"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        };
        let smooth = gpu.device.create_sampler(&filtered);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            anisotropy_clamp: options.anisotropy.max(1),
            ..filtered.clone()
        });
        // Each read of a texel takes long where texels are few.
        let width_sampler = gpu.device.create_sampler(&match compact {
            true => wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Nearest,
                min_filter: wgpu::FilterMode::Nearest,
                mipmap_filter: wgpu::MipmapFilterMode::Nearest,
                ..filtered
            },
            false => filtered,
        });
        let block = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("scale of maps"),
            contents: bytemuck::cast_slice(&thickness.block()),
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
        let film = (thickness.most_nm > 0.0 && thickness.most_nm <= film_table::THICKEST_NM)
            .then(|| film_texture(gpu, constants, thickness.most_nm))
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
            entries.extend([texture_entry(6, wgpu::TextureViewDimension::D2), entry(7, sampled)]);
            resources.extend([
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(&width_sampler),
            ]);
            sizes.push(*size);
        }
        let relief = Relief::new(gpu, maps, options.parallax);
        if let Some(relief) = &relief {
            entries.extend([
                uniform_entry(8),
                texture_entry(9, wgpu::TextureViewDimension::D2),
                entry(10, sampled),
            ]);
            resources.extend([
                relief.block.as_entire_binding(),
                wgpu::BindingResource::TextureView(&relief.heights),
                wgpu::BindingResource::Sampler(&smooth),
            ]);
            sizes.push(("relief", relief.bytes));
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
        Ok(Self {
            group,
            layout,
            textures: sizes,
            film_table: film.is_some(),
            film_width: width.is_some(),
            relief: relief.is_some(),
        })
    }
}

/// The table of a film on the device, and its size.
fn film_texture(
    gpu: &Gpu,
    constants: &Constants,
    thickest_nm: f32,
) -> Result<(wgpu::TextureView, u64), PreviewError> {
    let texels =
        film_table::table(constants, thickest_nm).map_err(|e| PreviewError::Material(e.to_string()))?;
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
