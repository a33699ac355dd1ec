//! Smooth edges of a picture whose pixels were shaded once: the depths of samples tell what each pixel shows, and its
//! neighbours in what colour.

use glam::Vec3;

use super::mesh::{self, DeviceMesh};
use super::program::Slot;
use super::target::{self, Target};
use super::{Gpu, slots, textures, whole};

/// Two passes: depths of samples, and the picture. See edges.wgsl.
#[derive(Debug)]
pub(super) struct Edges {
    /// For all triangles, and for those that face the eye.
    depths: [wgpu::RenderPipeline; 2],
    picture: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

impl Edges {
    /// `frame` is the layout of bind group 0 of objects.
    pub(super) fn new(gpu: &Gpu, frame: &wgpu::BindGroupLayout) -> Self {
        let texture = |binding, sample_type, multisampled| {
            let view_dimension = wgpu::TextureViewDimension::D2;
            textures::entry(binding, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled })
        };
        let color = wgpu::TextureSampleType::Float { filterable: false };
        let depth = wgpu::TextureSampleType::Depth;
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("edges"),
            entries: &[
                texture(0, color, false),
                texture(1, depth, false),
                texture(2, depth, true),
                textures::entry(3, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)),
            ],
        });
        let objects = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("depths of samples"),
            bind_group_layouts: &[Some(frame)],
            immediate_size: 0,
        });
        let place = slots::module(gpu, "depth", &slots::slots!["frame", "depth"], "");
        let depths = [false, true].map(|hides_backs| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("depths of samples"),
                layout: Some(&objects),
                vertex: wgpu::VertexState {
                    module: &place,
                    entry_point: Some("place_depth"),
                    compilation_options: Default::default(),
                    buffers: &[Some(mesh::PLACES)],
                },
                primitive: mesh::sides(hides_backs),
                depth_stencil: Some(target::depth(wgpu::CompareFunction::Greater, true)),
                multisample: target::Shading::Triangles.multisample(),
                fragment: None,
                multiview_mask: None,
                cache: None,
            })
        });
        let file = (&slots::slots!["edges"][..], "smoothed");
        let picture = whole::pipeline(gpu, "edges", file, &[&layout], target::FORMAT, &[]);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor::default());
        Self { depths, picture, layout, sampler }
    }

    /// Draw the depths of meshes that this eye sees; `frame` is bind group 0 of objects.
    pub(super) fn depths(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &wgpu::BindGroup,
        meshes: &[(DeviceMesh, usize)],
        eye: Vec3,
    ) {
        pass.set_bind_group(0, frame, &[]);
        for (mesh, _) in meshes {
            pass.set_pipeline(&self.depths[usize::from(mesh.hides_backs(eye))]);
            mesh.draw(pass);
        }
    }

    /// Draw the picture of what was shaded, whose samples have these depths.
    pub(super) fn picture(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        target: &Target,
        samples: &wgpu::TextureView,
    ) {
        let views = [&target.color, &target.depth, samples].map(wgpu::BindingResource::TextureView);
        let bound = views.into_iter().chain([wgpu::BindingResource::Sampler(&self.sampler)]);
        whole::draw(pass, &self.picture, &[&textures::group(gpu, "edges", &self.layout, bound)]);
    }
}
