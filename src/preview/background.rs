//! What is behind everything, and lamps as the eye sees them.

use half::f16;
use wgpu::util::DeviceExt;

use super::lamps::{Disc, Lamps, MOST_LAMPS};
use super::program::Slot;
use super::slots::{self, slots};
use super::target::Shading;
use super::{Gpu, PreviewError, target, textures};
use crate::scene::{Environment, EnvironmentImage, Light, Scene};

/// Most radiance that the target holds.
const BRIGHTEST: f32 = 60_000.0;

/// A corner of a lamp: place and radiance.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Corner {
    position: [f32; 3],
    radiance: [f32; 3],
}

/// The environment and suns, and rectangles.
#[derive(Debug)]
pub(super) struct Background {
    sky: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    lamps: Option<(wgpu::RenderPipeline, wgpu::Buffer)>,
    slots: Vec<&'static str>,
}

impl Background {
    /// Of a scene; `frame` is the layout of bind group 0 and `shading` the target's.
    ///
    /// # Errors
    /// If the environment's picture is larger than the adapter holds.
    pub(super) fn new(
        gpu: &Gpu,
        scene: &Scene,
        lamps: &Lamps,
        frame: &wgpu::BindGroupLayout,
        shading: Shading,
        resources: &mut Vec<(String, u64)>,
    ) -> Result<Self, PreviewError> {
        let mut discs = lamps.discs.clone();
        discs.resize(MOST_LAMPS, Disc::default());
        let block = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("suns"),
            contents: bytemuck::cast_slice(&discs),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let picture = match &scene.environment {
            Environment::Image(image) => Some(picture(gpu, image, resources)?),
            Environment::Constant(_) => None,
        };
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("environment"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let mut described = vec![textures::uniform_entry(0)];
        let mut bound = vec![block.as_entire_binding()];
        if let Some(picture) = &picture {
            let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
            described.push(textures::texture_entry(1, wgpu::TextureViewDimension::D2));
            described.push(textures::entry(2, filtering));
            bound.push(wgpu::BindingResource::TextureView(picture));
            bound.push(wgpu::BindingResource::Sampler(&sampler));
        }
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("background"),
            entries: &described,
        });
        let group = textures::group(gpu, "background", &layout, bound);
        let [frame_file, even, image, end, lamp] =
            slots!["frame", "surroundings_even", "surroundings_image", "background", "lamp"];
        let files = [frame_file, if picture.is_some() { image } else { even }, end];
        let sky = pipeline(gpu, &files, ["behind", "look"], &[frame, &layout], None, shading);
        let mut names: Vec<&'static str> = files.iter().map(|f| f.name).collect();
        let corners = corners(scene);
        let lamps = (!corners.is_empty()).then(|| {
            let files = [frame_file, lamp];
            names.push(lamp.name);
            let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
            let vertices = wgpu::VertexBufferLayout {
                array_stride: size_of::<Corner>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            };
            let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("lamps"),
                contents: bytemuck::cast_slice(&corners),
                usage: wgpu::BufferUsages::VERTEX,
            });
            (pipeline(gpu, &files, ["place_lamp", "glow"], &[frame], Some(vertices), shading), buffer)
        });
        Ok(Self { sky, group, lamps, slots: names })
    }

    /// Draw it where nothing is in front.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some((pipeline, corners)) = &self.lamps {
            pass.set_pipeline(pipeline);
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..(corners.size() / size_of::<Corner>() as u64) as u32, 0..1);
        }
        pass.set_pipeline(&self.sky);
        pass.set_bind_group(1, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// The files of the shaders.
    pub(super) fn slots(&self) -> Vec<&'static str> {
        self.slots.clone()
    }
}

/// Two triangles for each rectangle, counter-clockwise seen from where it shines.
fn corners(scene: &Scene) -> Vec<Corner> {
    let mut corners = Vec::new();
    for light in &scene.lights {
        if let Light::Area { center, u, v, radiance } = *light {
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                corners.push(Corner { position: (center + u * a + v * b).to_array(), radiance: radiance.0 });
            }
        }
    }
    corners
}

/// The picture of the environment on the device.
fn picture(
    gpu: &Gpu,
    image: &EnvironmentImage,
    resources: &mut Vec<(String, u64)>,
) -> Result<wgpu::TextureView, PreviewError> {
    let most = u64::from(gpu.device.limits().max_texture_dimension_2d);
    gpu.fits("a side of the environment in texels", image.width.max(image.height) as u64, most)?;
    let half = |c: f32| f16::from_f32(c.min(BRIGHTEST)).to_bits();
    let texels: Vec<[u16; 4]> =
        image.texels.iter().map(|t| [half(t[0]), half(t[1]), half(t[2]), half(1.0)]).collect();
    let bytes: &[u8] = bytemuck::cast_slice(&texels);
    resources.push(("environment".into(), bytes.len() as u64));
    let texture =
        textures::upload(gpu, "environment", textures::FOUR, [image.width, image.height, 1], 1, bytes);
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

fn pipeline(
    gpu: &Gpu,
    files: &[Slot],
    [vertex, fragment]: [&str; 2],
    groups: &[&wgpu::BindGroupLayout],
    vertices: Option<wgpu::VertexBufferLayout<'_>>,
    shading: Shading,
) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "background", files, "");
    let groups: Vec<_> = groups.iter().map(|g| Some(*g)).collect();
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("background"),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    // Lamps are in the room, the rest is at its end.
    let (cull_mode, write) = match &vertices {
        Some(_) => (Some(wgpu::Face::Back), true),
        None => (None, false),
    };
    let compare = if write { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Equal };
    let buffers = if vertices.is_some() { vec![vertices] } else { Vec::new() };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("background"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState { cull_mode, ..Default::default() },
        depth_stencil: Some(target::depth(compare, write)),
        multisample: shading.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(target::FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
