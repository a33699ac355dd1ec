//! Deferred shading: triangles of one material are recorded, and then the pixels that show them are shaded. A program on the CPU
//! shades squares of 16 pixels for each triangle that reaches into them, which is most of its work where triangles are
//! small.

use glam::Vec3;

use super::mesh::{self, DeviceMesh};
use super::shaded::Room;
use super::target::{self, Shading};
use super::{Gpu, slots, textures};

/// Formats of what is recorded: texture coordinates, which need all digits; normals with the level of maps; and tangents.
const FORMATS: [wgpu::TextureFormat; 3] =
    [wgpu::TextureFormat::Rg32Float, wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Rgba16Float];
/// Bytes of it for each pixel.
pub(super) const BYTES: u32 = 8 + 8 + 8;

/// The layout of bind group 3 of deferred.wgsl.
pub(super) fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let texture = |binding, sample_type| {
        let view_dimension = wgpu::TextureViewDimension::D2;
        textures::entry(
            binding,
            wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false },
        )
    };
    let color = |binding| texture(binding, wgpu::TextureSampleType::Float { filterable: false });
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("recorded"),
        entries: &[color(0), color(1), color(2), texture(3, wgpu::TextureSampleType::Depth)],
    })
}

/// What is recorded of a picture.
#[derive(Debug)]
pub(super) struct Recorded {
    views: [wgpu::TextureView; 3],
    /// Bind group 3.
    pub(super) group: wgpu::BindGroup,
}

impl Recorded {
    /// Room for it, beside the picture's depths.
    pub(super) fn new(gpu: &Gpu, [width, height]: [usize; 2], depths: &wgpu::TextureView) -> Self {
        let views = FORMATS.map(|format| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("recorded"),
                size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        });
        let bound = views.iter().chain([depths]).map(wgpu::BindingResource::TextureView);
        let group = textures::group(gpu, "recorded", &layout(gpu), bound);
        Self { views, group }
    }

    /// Begin to record, and to draw the picture's depths. What shows nothing keeps what was there, as its depth tells.
    pub(super) fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        depths: &wgpu::TextureView,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        let kept = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let onto = |view| {
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops: kept })
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("record"),
            color_attachments: &self.views.each_ref().map(onto),
            depth_stencil_attachment: Some(target::before(depths, false, wgpu::StoreOp::Store)),
            timestamp_writes: times,
            ..Default::default()
        })
    }
}

/// Records triangles of one material.
#[derive(Debug)]
pub(super) struct Recorder {
    /// The material.
    pub(super) material: usize,
    /// For all triangles, and for those that face the eye.
    pipelines: [wgpu::RenderPipeline; 2],
}

impl Recorder {
    /// For a material whose maps have so many columns and rows; `room` has the layout of bind group 0, and that of group 2 is there
    /// where a relief is seen.
    pub(super) fn new(
        gpu: &Gpu,
        room: &Room,
        relief: Option<&wgpu::BindGroupLayout>,
        (material, maps): (usize, [usize; 2]),
    ) -> Self {
        let pipelines = [false, true].map(|hides_backs| pipeline(gpu, room, relief, maps, hides_backs));
        Self { material, pipelines }
    }

    /// Record those of the meshes that wear the material.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, meshes: &[(DeviceMesh, usize)], eye: Vec3) {
        for (mesh, _) in meshes.iter().filter(|(_, material)| *material == self.material) {
            pass.set_pipeline(&self.pipelines[usize::from(mesh.hides_backs(eye))]);
            mesh.draw(pass);
        }
    }
}

fn pipeline(
    gpu: &Gpu,
    room: &Room,
    relief: Option<&wgpu::BindGroupLayout>,
    [columns, rows]: [usize; 2],
    hides_backs: bool,
) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "record", &slots::recorder(relief.is_some()), "");
    let mut constants = vec![("COLUMNS", columns as f64), ("ROWS", rows as f64)];
    constants.extend(relief.map(|_| ("RELIEF_STEPS", f64::from(room.options.parallax_steps.max(1)))));
    let groups = [Some(&room.frame), None, relief];
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("record"),
        bind_group_layouts: &groups[..if relief.is_some() { 3 } else { 1 }],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("record"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place"),
            compilation_options: Default::default(),
            buffers: &[Some(mesh::LAYOUT)],
        },
        primitive: mesh::sides(hides_backs),
        depth_stencil: Some(target::depth(wgpu::CompareFunction::Greater, true)),
        multisample: Shading::Pixels.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("record"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                ..Default::default()
            },
            targets: &FORMATS.map(|format| Some(format.into())),
        }),
        multiview_mask: None,
        cache: None,
    })
}
