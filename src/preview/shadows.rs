//! Shadow maps: depth as each small light sees it. Drawn once, as lights and objects do not move.

use glam::Mat4;
use wgpu::util::DeviceExt;

use super::mesh::{self, DeviceMesh};
use super::program::Slot;
use super::{Gpu, PreviewError, slots, textures};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The maps of all lights.
#[derive(Debug)]
pub(super) struct Shadows {
    /// Whose they are.
    pub(super) name: &'static str,
    /// All maps, a layer each.
    pub(super) all: wgpu::TextureView,
    /// Whether they are there already.
    pub(super) drawn: bool,
    pipeline: wgpu::RenderPipeline,
    layers: Vec<(wgpu::TextureView, wgpu::BindGroup)>,
    casters: Vec<usize>,
    bytes: u64,
}

impl Shadows {
    /// Room for maps of `size` texels a side, one for each way from the world to one; `casters` are the meshes that cast
    /// shadows.
    ///
    /// # Errors
    /// If the adapter holds no such map.
    pub(super) fn new(
        gpu: &Gpu,
        name: &'static str,
        seen: &[Mat4],
        casters: Vec<usize>,
        size: u32,
    ) -> Result<Self, PreviewError> {
        let limits = gpu.device.limits();
        let (size, count) = (size.max(1), seen.len().max(1) as u32);
        gpu.fits("a shadow map in texels", u64::from(size), u64::from(limits.max_texture_dimension_2d))?;
        gpu.fits("the number of shadow maps", u64::from(count), u64::from(limits.max_texture_array_layers))?;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: count },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let block = textures::uniform_entry(0);
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow"),
            entries: &[block],
        });
        let layer = |(i, shadow): (usize, &Mat4)| {
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: i as u32,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let light = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("shadow"),
                contents: bytemuck::bytes_of(&shadow.to_cols_array_2d()),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            (view, textures::group(gpu, "shadow", &layout, [light.as_entire_binding()]))
        };
        let layers = seen.iter().enumerate().map(layer).collect();
        Ok(Self {
            name,
            all: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            drawn: false,
            pipeline: pipeline(gpu, &layout),
            layers,
            casters,
            bytes: 4 * u64::from(size) * u64::from(size) * u64::from(count),
        })
    }

    /// The binding of [`Shadows::all`].
    pub(super) fn entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
        textures::entry(
            binding,
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Depth,
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
        )
    }

    /// Size on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Draw all maps.
    pub(super) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        meshes: &[(DeviceMesh, usize)],
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let last = self.layers.len().saturating_sub(1);
        for (i, (view, light)) in self.layers.iter().enumerate() {
            // One measure for all of them.
            let times =
                times.as_ref().filter(|_| i == 0 || i == last).map(|t| wgpu::RenderPassTimestampWrites {
                    query_set: t.query_set,
                    beginning_of_pass_write_index: t.beginning_of_pass_write_index.filter(|_| i == 0),
                    end_of_pass_write_index: t.end_of_pass_write_index.filter(|_| i == last),
                });
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow map"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: times,
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, light, &[]);
            for caster in &self.casters {
                meshes[*caster].0.draw(&mut pass);
            }
        }
        self.drawn = true;
    }
}

fn pipeline(gpu: &Gpu, group: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "shadow", &slots::slots!["shadow"], "");
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("shadow"),
        bind_group_layouts: &[Some(group)],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shadow"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place_caster"),
            compilation_options: Default::default(),
            buffers: &[Some(mesh::PLACES)],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
