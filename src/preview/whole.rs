//! Passes over every texel of a texture: one triangle that covers it.

use super::program::Slot;
use super::{Gpu, slots};

/// What draws `entry` of some files at every texel of a texture of this format; `groups` are the layouts of what it reads, and
/// `constants` the files' own.
pub(super) fn pipeline(
    gpu: &Gpu,
    label: &str,
    (files, entry): (&[Slot], &str),
    groups: &[&wgpu::BindGroupLayout],
    format: wgpu::TextureFormat,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    let files = [files, &slots::slots!["whole"]].concat();
    let module = slots::module(gpu, label, &files, "");
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
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
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draw with it, each group at its place.
pub(super) fn draw(
    pass: &mut wgpu::RenderPass<'_>,
    pipeline: &wgpu::RenderPipeline,
    groups: &[&wgpu::BindGroup],
) {
    pass.set_pipeline(pipeline);
    (0..).zip(groups).for_each(|(i, group)| pass.set_bind_group(i, *group, &[]));
    pass.draw(0..3, 0..1);
}
