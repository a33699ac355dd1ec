//! What hides the environment from what a picture shows, by its own depths: passes between depths and colours. See
//! occlusion.wgsl.

use glam::Vec3;

use super::mesh::{self, DeviceMesh};
use super::program::Slot;
use super::target::{self, Shading, Target};
use super::{Gpu, slots, textures, whole};
use crate::scene::Scene;

/// Normals; and a direction of the opening and its share.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Places that are looked at on either side of a pixel in each plane.
const STEPS: u32 = 8;
/// Where so many pictures are averaged, each looks into other directions, and neighbours are left alone.
const ENOUGH: u32 = 16;

/// Two passes, or three: depths, openings, and their mean over neighbours.
#[derive(Debug)]
pub(super) struct Occlusion {
    /// Of bind group 3 of objects.
    pub(super) layout: wgpu::BindGroupLayout,
    facing: wgpu::RenderPipeline,
    search: (wgpu::RenderPipeline, wgpu::BindGroupLayout),
    mean: Option<(wgpu::RenderPipeline, wgpu::BindGroupLayout)>,
    views: Option<Views>,
}

/// What a target of one size needs.
#[derive(Debug)]
struct Views {
    size: [usize; 2],
    /// Where samples are shaded their depths are of no use.
    own_depths: Option<wgpu::TextureView>,
    normals: wgpu::TextureView,
    found: wgpu::TextureView,
    averaged: Option<wgpu::TextureView>,
    /// What objects read.
    group: wgpu::BindGroup,
}

impl Occlusion {
    /// With so many planes, and perhaps a floor, for each of so many pictures that are averaged; `frame` is the layout of bind group
    /// 0 of objects.
    pub(super) fn new(
        gpu: &Gpu,
        frame: &wgpu::BindGroupLayout,
        (slices, floor): (u32, bool),
        pictures: u32,
    ) -> Self {
        let layout = |label, types: &[wgpu::TextureSampleType]| {
            let entry = |(binding, sample_type): (usize, &wgpu::TextureSampleType)| {
                let view_dimension = wgpu::TextureViewDimension::D2;
                let ty = wgpu::BindingType::Texture {
                    sample_type: *sample_type,
                    view_dimension,
                    multisampled: false,
                };
                textures::entry(binding as u32, ty)
            };
            let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let (color, depth) =
            (wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureSampleType::Depth);
        let read = layout("depths", &[depth, color]);
        let (slices, floor) = (f64::from(slices.max(1)), f64::from(u8::from(floor)));
        let constants = [("SLICES", slices), ("STEPS", f64::from(STEPS)), ("FLOOR", floor)];
        let pipeline =
            |file: (&[Slot], &str), groups: &[&wgpu::BindGroupLayout], constants: &[(&str, f64)]| {
                whole::pipeline(gpu, "occlusion", file, groups, FORMAT, constants)
            };
        let search = pipeline((&slots::slots!["frame", "occlusion"], "search"), &[frame, &read], &constants);
        let mean = (pictures < ENOUGH).then(|| {
            let read = layout("openings of neighbours", &[depth, color]);
            (pipeline((&slots::slots!["occlusion_mean"], "average"), &[&read], &[]), read)
        });
        Self {
            layout: layout("openings", &[color]),
            facing: facing(gpu, frame),
            search: (search, read),
            mean,
            views: None,
        }
    }

    /// What the passes are called, in their order.
    pub(super) fn passes(&self) -> impl Iterator<Item = &'static str> {
        ["depths", "occlusion"].into_iter().chain(self.mean.as_ref().map(|_| "mean of occlusion"))
    }

    /// Have textures of a target's size.
    pub(super) fn fit(&mut self, gpu: &Gpu, target: &Target) {
        let size = target.size();
        if self.views.as_ref().is_some_and(|v| v.size == size) {
            return;
        }
        let texture = |label, format| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size[0] as u32,
                    height: size[1] as u32,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let (normals, found) = (texture("normals", FORMAT), texture("openings", FORMAT));
        let averaged = self.mean.as_ref().map(|_| texture("openings", FORMAT));
        let shown = wgpu::BindingResource::TextureView(averaged.as_ref().unwrap_or(&found));
        let group = textures::group(gpu, "openings", &self.layout, [shown]);
        let own_depths =
            (target.shading == Shading::Triangles).then(|| texture("depths of middles", target::DEPTH));
        self.views = Some(Views { size, own_depths, normals, found, averaged, group });
    }

    /// Size on the device.
    pub(super) fn bytes(&self) -> u64 {
        let Some(views) = &self.views else { return 0 };
        let depths = if views.own_depths.is_some() { 4 } else { 0 };
        let openings = if views.averaged.is_some() { 24 } else { 16 };
        (views.size[0] * views.size[1]) as u64 * (depths + openings)
    }

    /// Draw all passes for a target that was fitted; the target's own depths, too, unless it has samples. `times` is where the
    /// passes put their stamps.
    pub(super) fn draw<'t>(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        (frame, meshes): (&wgpu::BindGroup, &[(DeviceMesh, usize)]),
        times: impl Fn(usize) -> Option<wgpu::RenderPassTimestampWrites<'t>>,
    ) {
        let Some(views) = &self.views else { return };
        let measured = views.own_depths.as_ref().unwrap_or(&target.depth);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depths"),
            color_attachments: &[Some(target::onto(&views.normals, None, wgpu::StoreOp::Store))],
            depth_stencil_attachment: Some(target::before(measured, false, wgpu::StoreOp::Store)),
            timestamp_writes: times(0),
            ..Default::default()
        });
        pass.set_pipeline(&self.facing);
        pass.set_bind_group(0, frame, &[]);
        meshes.iter().for_each(|(mesh, _)| mesh.draw(&mut pass));
        drop(pass);
        let depths = wgpu::BindingResource::TextureView(measured);
        let (search, layout) = &self.search;
        let normals = wgpu::BindingResource::TextureView(&views.normals);
        let group = textures::group(gpu, "depths", layout, [depths.clone(), normals]);
        over(encoder, &views.found, search, &[frame, &group], times(1));
        if let Some(((mean, layout), averaged)) = self.mean.as_ref().zip(views.averaged.as_ref()) {
            let found = wgpu::BindingResource::TextureView(&views.found);
            let group = textures::group(gpu, "openings of neighbours", layout, [depths, found]);
            over(encoder, averaged, mean, &[&group], times(2));
        }
    }

    /// Let objects read what was found for the target's pixels.
    pub(super) fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(views) = &self.views {
            pass.set_bind_group(3, &views.group, &[]);
        }
    }
}

/// A pass over all pixels.
fn over(
    encoder: &mut wgpu::CommandEncoder,
    onto: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    groups: &[&wgpu::BindGroup],
    times: Option<wgpu::RenderPassTimestampWrites<'_>>,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("openings"),
        color_attachments: &[Some(target::onto(onto, None, wgpu::StoreOp::Store))],
        timestamp_writes: times,
        ..Default::default()
    });
    whole::draw(&mut pass, pipeline, groups);
}

/// Draws depths and normals of pixels.
fn facing(gpu: &Gpu, frame: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "facing", &slots::slots!["frame", "facing"], "");
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("depths"),
        bind_group_layouts: &[Some(frame)],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depths"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place_facing"),
            compilation_options: Default::default(),
            buffers: &[Some(mesh::LAYOUT)],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target::depth(wgpu::CompareFunction::Greater, true)),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("face"),
            compilation_options: Default::default(),
            targets: &[Some(FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// How many times as wide as all else a floor is that ends nowhere.
const WIDE: f32 = 10.0;

/// Whether everything stands on a flat object, with y up, that is so wide that it ends nowhere.
pub(super) fn has_floor(scene: &Scene) -> bool {
    let bounds: Vec<[Vec3; 2]> = scene
        .objects
        .iter()
        .filter(|object| !object.mesh.positions.is_empty())
        .map(|object| object.mesh.bounds())
        .collect();
    bounds.iter().enumerate().any(|(i, [low, high])| {
        let others = bounds.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, b)| b);
        let stands = |[l, h]: &[Vec3; 2]| {
            l.y >= high.y
                && WIDE * l.abs().max(h.abs()).max_element()
                    <= (*high).min(-*low).with_y(f32::MAX).min_element()
        };
        low.y == high.y && others.clone().count() > 0 && others.clone().all(stands)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Inputs, builtin};

    #[test]
    fn a_floor_is_wide_and_below_all_else() {
        let mut spec = builtin::scene("sphere").expect("a built-in scene");
        spec.subject.triangles = 1000;
        let built = |spec| Scene::build(&spec, &Inputs::default()).expect("it can be built");
        let mut scene = built(spec.clone());
        assert!(has_floor(&scene));
        scene.objects[0].mesh.positions.iter_mut().for_each(|p| p.y -= 0.1);
        assert!(!has_floor(&scene), "something is below it");
        spec.ground.radius = 2.0;
        assert!(!has_floor(&built(spec.clone())), "a plate");
        spec.ground.show = false;
        assert!(!has_floor(&built(spec)));
        scene.objects.clear();
        assert!(!has_floor(&scene));
    }
}
