//! Materials on the device: bind group 1.

use wgpu::util::DeviceExt;

use super::Gpu;
use super::material::SkinData;

/// Who reads a material: what is shaded, and tests.
const READERS: wgpu::ShaderStages = wgpu::ShaderStages::FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

/// The layout of the group: the uniform block at 0, then the tables that the material has. It is the same for all materials
/// of equal programs.
pub fn layout(gpu: &Gpu, data: &SkinData) -> wgpu::BindGroupLayout {
    let entry = |binding: u32, ty: wgpu::BindingType| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: READERS,
        ty,
        count: None,
    };
    let block = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let table = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let tables = data.tables.iter().map(|t| entry(t.binding, table));
    let entries: Vec<_> = std::iter::once(entry(0, block)).chain(tables).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("material"),
        entries: &entries,
    })
}

/// The group itself: numbers and tables are copied to the device. Faults come up in [`Gpu::check`].
pub fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, data: &SkinData) -> wgpu::BindGroup {
    let block = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("material"),
        contents: bytemuck::bytes_of(&data.uniform),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let texture = |table: &super::material::Table| {
        let descriptor = wgpu::TextureDescriptor {
            label: Some(table.name),
            size: wgpu::Extent3d { width: table.width, height: table.height(), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = wgpu::util::TextureDataOrder::LayerMajor;
        let bytes = bytemuck::cast_slice(&table.texels);
        let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, bytes);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    };
    let views: Vec<_> = data.tables.iter().map(|table| (table.binding, texture(table))).collect();
    let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() }];
    entries.extend(views.iter().map(|(binding, view)| wgpu::BindGroupEntry {
        binding: *binding,
        resource: wgpu::BindingResource::TextureView(view),
    }));
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("material"),
        layout,
        entries: &entries,
    })
}
