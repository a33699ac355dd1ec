//! Smooth edges of a picture whose pixels were shaded once: the depths of samples tell what each pixel shows, and its
//! neighbours in what colour.

use glam::Vec3;

use super::mesh::{self, DeviceMesh};
use super::program::Slot;
use super::target::{self, Target};
use super::{Gpu, slots, textures};

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
        let groups = |group| {
            gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("edges"),
                bind_group_layouts: &[Some(group)],
                immediate_size: 0,
            })
        };
        let place = slots::module(gpu, "depth", &slots::slots!["frame", "depth"], "");
        let depths = [false, true].map(|hides_backs| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("depths of samples"),
                layout: Some(&groups(frame)),
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
        let module = slots::module(gpu, "edges", &slots::slots!["edges"], "");
        let picture = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("edges"),
            layout: Some(&groups(&layout)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("whole"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("smoothed"),
                compilation_options: Default::default(),
                targets: &[Some(target::FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
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
        pass.set_pipeline(&self.picture);
        pass.set_bind_group(0, &textures::group(gpu, "edges", &self.layout, bound), &[]);
        pass.draw(0..3, 0..1);
    }
}
