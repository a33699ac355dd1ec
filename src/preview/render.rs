//! A scene on the device, and pictures of it.

use bytemuck::Zeroable;
use glam::Mat4;
use wgpu::util::DeviceExt;

use super::background::Background;
use super::edges::Edges;
use super::frame::FrameUniform;
use super::lamps::{Casters, Lamps, hammersley};
use super::mesh::{self, DeviceMesh};
use super::program::{SkinOptions, SkinProgram, Slot};
use super::shadows::Shadows;
use super::slots::{self, Has, Lit, Sky};
use super::target::{self, Shading, Target};
use super::textures::{self, Surface};
use super::timing::Timing;
use super::{Gpu, PreviewError, binding, environment, material::SkinData};
use crate::scene::{Camera, Material, Scene, SceneFeatures};

/// What is chosen rather than found in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Of materials.
    pub skin: SkinOptions,
    /// Small lights that a rectangle becomes, at least 1; four times as many where 16 pictures or more are averaged, as no
    /// more of them shine in one.
    pub rectangle_samples: usize,
    /// Texels of a side of a sun's shadow map.
    pub shadow_size: u32,
    /// Texels of a side of the shadow map of a small light of a rectangle; these blur each other's edges.
    pub rectangle_shadow_size: u32,
    /// Most samples of a map along a slanted view, 1 to 16.
    pub anisotropy: u16,
    /// Whether colours are computed once for each pixel before edges are smoothed, not once for each triangle in it.
    pub once: bool,
    /// Pictures that are averaged, each of another place within pixels, at least 1. A multiple of 4 costs least: in each of
    /// four pictures other ones of a rectangle's small lights shine.
    pub samples: u32,
    /// Whether the environment lights objects; it is seen behind them in any case.
    pub environment: bool,
    /// Whether suns and rectangles light objects.
    pub lamps: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            skin: SkinOptions::default(),
            rectangle_samples: 16,
            shadow_size: 1024,
            rectangle_shadow_size: 512,
            anisotropy: 8,
            once: false,
            samples: 1,
            environment: true,
            lamps: true,
        }
    }
}

impl Options {
    /// What suits an adapter. One that is a program on the CPU shades pixels once (Mesa 22.3 shades all that is hidden, too,
    /// where pixels have samples: measured, four times the time of all else), and gets maps without anisotropy (some slanted
    /// samples of it read the whole map there: measured, 39 s for a picture that takes 2 without).
    pub fn of(gpu: &Gpu) -> Self {
        let all = Self::default();
        if gpu.is_software() {
            Self { anisotropy: 1, once: true, ..all }
        } else {
            Self { samples: 16, ..all }
        }
    }
}

/// Linear light, as the scene has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row from the top.
    pub texels: Vec<[f32; 3]>,
    /// What was drawn for it, and how long that took on the device, ms, where the adapter tells.
    pub passes: Vec<(&'static str, Option<f64>)>,
}

/// A scene on the device.
#[derive(Debug)]
pub struct Renderer<'g> {
    gpu: &'g Gpu,
    /// With the index of the material.
    meshes: Vec<(DeviceMesh, usize)>,
    materials: Vec<Option<Shaded>>,
    frame: FrameUniform,
    frame_block: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    shadows: Vec<Shadows>,
    depth: wgpu::RenderPipeline,
    shading: Shading,
    edges: Option<Edges>,
    background: Background,
    target: Option<Target>,
    timing: Option<Timing>,
    samples: u32,
    /// In each of so many samples other ones of the small lights of rectangles shine.
    place_step: u32,
    resources: Vec<(String, u64)>,
}

/// A material ready to be drawn with.
#[derive(Debug)]
struct Shaded {
    pipeline: wgpu::RenderPipeline,
    material: wgpu::BindGroup,
    surface: wgpu::BindGroup,
    slots: Vec<&'static str>,
    left_out: Vec<&'static str>,
}

impl<'g> Renderer<'g> {
    /// Copy a scene to the device, and make what its pictures need. The scene's meshes must be sound.
    ///
    /// # Errors
    /// If a material is out of range, something is larger than the adapter holds, or the device fails.
    pub fn new(gpu: &'g Gpu, scene: &Scene, options: &Options) -> Result<Self, PreviewError> {
        let mut resources = Vec::new();
        let mut meshes = Vec::new();
        // As each object in the scene, also those without triangles.
        let mut of_objects = Vec::new();
        for object in &scene.objects {
            let mesh = DeviceMesh::new(gpu, &object.name, &object.mesh)?;
            of_objects.push(mesh.as_ref().map(|_| meshes.len()));
            if let Some(mesh) = mesh {
                resources
                    .push((format!("mesh of {}, {} triangles", object.name, mesh.triangles()), mesh.bytes()));
                meshes.push((mesh, object.material));
            }
        }

        let samples = options.samples.max(1);
        // A power of two that divides them.
        let place_step = (1 << samples.trailing_zeros()).min(MOST_STEP);
        let casters = Casters::new(scene);
        let lamps = match options.lamps {
            true => {
                let sizes = [options.shadow_size, options.rectangle_shadow_size];
                // Shadows are no smoother than these are many.
                let places = options.rectangle_samples * (place_step / FEWER_STEP).max(1) as usize;
                Lamps::new(scene, &casters, places, samples / place_step, sizes)?
            }
            false => Lamps::default(),
        };
        let drawn: Vec<usize> = casters.objects.iter().filter_map(|i| of_objects[*i]).collect();
        let mut shadows = Vec::new();
        let mut maps = |name: &'static str, seen: &[Mat4], size: u32| -> Result<_, PreviewError> {
            if seen.is_empty() {
                return Ok(None);
            }
            let maps = Shadows::new(gpu, name, seen, drawn.clone(), size)?;
            resources.push((name.to_owned(), maps.bytes()));
            let view = maps.all.clone();
            shadows.push(maps);
            Ok(Some(view))
        };
        let suns: Vec<Mat4> = lamps.suns.iter().map(|sun| Mat4::from_cols_array_2d(&sun.shadow)).collect();
        let sun_maps = maps("shadow maps of suns", &suns, options.shadow_size)?;
        let rectangle_maps = maps("shadow maps of rectangles", &lamps.seen, options.rectangle_shadow_size)?;
        let sky = if options.environment { environment::layers(scene) } else { None };
        let environment = options.environment && !scene.environment.is_black();
        let frame = FrameUniform {
            suns: lamps.suns.len() as u32,
            rectangles: lamps.rectangles.len() as u32,
            discs: lamps.discs.len() as u32,
            sky_layers: environment::LAYERS as f32,
            even: scene.environment.mean_radiance().0,
            sharper: sharper(samples),
            ..FrameUniform::zeroed()
        };
        let frame_block = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sky_view = sky.map(|texels| {
            resources.push(("environment by roughness".into(), 2 * texels.len() as u64));
            environment::texture(gpu, &texels)
        });
        let sky = match (environment, &sky_view) {
            (false, _) => Sky::Dark,
            (true, None) => Sky::Even,
            (true, Some(_)) => Sky::Image,
        };
        let lit = Lit {
            suns: sun_maps.is_some(),
            rectangles: rectangle_maps.is_some(),
            tints_each: place_step >= FEWER_STEP,
            sky,
        };
        let maps = [sun_maps.as_ref(), rectangle_maps.as_ref(), sky_view.as_ref()];
        let bound = Bound::new(gpu, &frame_block, &lamps, maps);

        let shading = Shading::of(options.once, samples);
        let mut materials = Vec::new();
        for (i, material) in scene.materials.iter().enumerate() {
            let worn = meshes.iter().any(|(_, m)| *m == i);
            let casts = casters.objects.iter().any(|o| scene.objects[*o].material == i);
            let make = || Shaded::new(gpu, (material, casts), lit, &bound.layout, options, &mut resources);
            materials.push(worn.then(make).transpose()?);
        }
        let background = Background::new(gpu, scene, &lamps, &bound.layout, shading, &mut resources)?;
        let renderer = Self {
            gpu,
            meshes,
            materials,
            frame,
            frame_block,
            frame_group: bound.group,
            shadows,
            depth: depth(gpu, &bound.layout, shading),
            shading,
            edges: (shading == Shading::Pixels).then(|| Edges::new(gpu, &bound.layout)),
            background,
            target: None,
            timing: Timing::new(gpu),
            samples,
            place_step,
            resources,
        };
        gpu.wait()?;
        Ok(renderer)
    }

    /// Draw the scene from a camera; everything is sharp, lenses do not count. Times of passes are those of all samples
    /// together.
    ///
    /// # Errors
    /// If the size is 0 or more than the adapter holds, or the device fails.
    pub fn render(&mut self, camera: &Camera, [width, height]: [usize; 2]) -> Result<Picture, PreviewError> {
        let target = match self.target.take().filter(|t| t.size() == [width, height]) {
            Some(target) => target,
            None => Target::new(self.gpu, [width, height], self.shading)?,
        };
        let mut sum = Vec::new();
        let mut passes: Vec<(&'static str, Option<f64>)> = Vec::new();
        for sample in 0..self.samples {
            let shift = hammersley(sample as usize, self.samples as usize).map(|t| t - 0.5);
            let (block, offset) = (sample / self.place_step, sample % self.place_step);
            let visits = self.samples.div_ceil(self.place_step);
            let frame = FrameUniform {
                suns: self.frame.suns,
                rectangles: self.frame.rectangles,
                discs: self.frame.discs,
                sky_layers: self.frame.sky_layers,
                even: self.frame.even,
                sharper: self.frame.sharper,
                // Not the same ones in the same part of pixels each time.
                first_place: (offset + block) % self.place_step,
                place_step: self.place_step,
                place_shift: hammersley(block as usize, visits as usize).map(|t| t - 0.5),
                ..FrameUniform::new(camera, [width, height], shift)
            };
            self.gpu.queue.write_buffer(&self.frame_block, 0, bytemuck::bytes_of(&frame));
            for (name, time) in self.draw(&target)? {
                match passes.iter_mut().find(|(n, _)| *n == name) {
                    Some((_, total)) => *total = total.zip(time).map(|(a, b)| a + b),
                    None => passes.push((name, time)),
                }
            }
            target.add_to(self.gpu, &mut sum)?;
        }
        let scale = 1.0 / self.samples as f32;
        let texels = sum.into_iter().map(|t: [f32; 3]| t.map(|c| c * scale)).collect();
        self.target = Some(target);
        Ok(Picture { width, height, texels, passes })
    }

    /// Draw one sample of each pixel, and tell the passes' times.
    fn draw(&mut self, target: &Target) -> Result<Vec<(&'static str, Option<f64>)>, PreviewError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut names = Vec::new();
        for shadows in self.shadows.iter_mut().filter(|s| !s.drawn) {
            shadows.draw(&mut encoder, &self.meshes, self.timing.as_ref().map(|t| t.pair(names.len())));
            names.push(shadows.name);
        }
        self.shade(&mut encoder, target, names.len());
        names.push("picture");
        if let Some((edges, samples)) = self.edges.as_ref().zip(target.samples.as_ref()) {
            let times = |place: usize| self.timing.as_ref().map(|t| t.pair(place));
            let mut pass = Target::begin_depths(samples, &mut encoder, times(names.len()));
            edges.depths(&mut pass, &self.frame_group, &self.meshes);
            drop(pass);
            names.push("depths of samples");
            let mut pass = target.begin_whole(&mut encoder, times(names.len()));
            edges.picture(self.gpu, &mut pass, target, samples);
            drop(pass);
            names.push("edges");
        }
        target.copy(&mut encoder);
        if let Some(timing) = &self.timing {
            timing.resolve(&mut encoder, names.len());
        }
        self.gpu.queue.submit([encoder.finish()]);
        let times = match &self.timing {
            Some(timing) => timing.read(self.gpu, names.len())?,
            None => vec![None; names.len()],
        };
        Ok(names.into_iter().zip(times).collect())
    }

    /// Draw objects, and what is behind them.
    fn shade(&self, encoder: &mut wgpu::CommandEncoder, target: &Target, place: usize) {
        let mut pass = target.begin(encoder, self.timing.as_ref().map(|t| t.pair(place)));
        pass.set_bind_group(0, &self.frame_group, &[]);
        // Depth alone first, so that only what is seen is shaded.
        pass.set_pipeline(&self.depth);
        self.meshes.iter().for_each(|(mesh, _)| mesh.draw(&mut pass));
        for (mesh, material) in &self.meshes {
            if let Some(Some(shaded)) = self.materials.get(*material) {
                pass.set_pipeline(&shaded.pipeline);
                pass.set_bind_group(1, &shaded.material, &[]);
                pass.set_bind_group(2, &shaded.surface, &[]);
                mesh.draw(&mut pass);
            }
        }
        self.background.draw(&mut pass);
    }

    /// What lies on the device, with bytes.
    pub fn resources(&self) -> Vec<(String, u64)> {
        let target = self.target.as_ref().map(|t| ("picture and depth".to_owned(), t.bytes()));
        self.resources.iter().cloned().chain(target).collect()
    }

    /// What materials have and no shader draws: the picture differs from the reference's by it.
    pub fn left_out(&self) -> Vec<&'static str> {
        let mut all: Vec<_> = self.materials.iter().flatten().flat_map(|m| m.left_out.clone()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The files of each material's shader, and of the background's.
    pub fn slots(&self) -> Vec<Vec<&'static str>> {
        let materials = self.materials.iter().flatten().map(|m| m.slots.clone());
        materials.chain([self.background.slots()]).collect()
    }
}

impl Shaded {
    fn new(
        gpu: &Gpu,
        (material, casts): (&Material, bool),
        lit: Lit,
        frame: &wgpu::BindGroupLayout,
        options: &Options,
        resources: &mut Vec<(String, u64)>,
    ) -> Result<Self, PreviewError> {
        let shading = Shading::of(options.once, options.samples);
        let program = SkinProgram::new(&SceneFeatures::of_material(material), &options.skin);
        // Where all texels are alike, the light below the film is that of their thickness.
        let data = SkinData::new(&material.constants, material.texel(0.5, 0.5).thickness_nm, &program)
            .map_err(|e| PreviewError::Material(e.to_string()))?;
        resources.extend(data.tables.iter().map(|t| (t.name.to_owned(), 16 * t.texels.len() as u64)));
        let material_layout = binding::layout(gpu, &data);
        let surface = Surface::new(gpu, material, options.anisotropy)?;
        resources.extend(surface.textures.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)));

        let film_table = surface.film_table && program.has("film_series");
        // The table has its own order of the series.
        let mut constants = if film_table { Vec::new() } else { program.constants() };
        if !casts {
            constants.push(("SHADOW_LIFT", 0.0));
        }
        let has = Has { maps: material.maps.is_some(), film_table, film_width: surface.film_width };
        let files = slots::files(&program, has, lit);
        let module = slots::module(gpu, "skin", &files);
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("skin"),
            bind_group_layouts: &[Some(frame), Some(&material_layout), Some(&surface.layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("skin"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("place"),
                compilation_options: Default::default(),
                buffers: &[Some(mesh::LAYOUT)],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(target::depth(wgpu::CompareFunction::Equal, false)),
            multisample: shading.multisample(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shade"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                targets: &[Some(target::FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let material = binding::group(gpu, &material_layout, &data);
        let slots = files.iter().map(|f| f.name).collect();
        let left_out = program.left_out().to_vec();
        Ok(Self { pipeline, material, surface: surface.group, slots, left_out })
    }
}

/// Most samples over which the small lights of rectangles are spread, and samples from which on few shine in each.
const MOST_STEP: u32 = 16;
const FEWER_STEP: u32 = 4;

/// What is added to the level of maps where so many samples share a pixel: that of a sample's own part of it, and one more,
/// as samples do what is left of the mean. Measured at 4 and 16 samples, mean CIEDE2000: 14 and 18 % less than without, and
/// no more with two levels more.
fn sharper(samples: u32) -> f32 {
    if samples == 1 { 0.0 } else { -0.5 * (samples as f32).log2() - 1.0 }
}

/// Draws nothing but depth.
fn depth(gpu: &Gpu, frame: &wgpu::BindGroupLayout, shading: Shading) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "depth", &slots::slots!["frame", "depth"]);
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("depth"),
        bind_group_layouts: &[Some(frame)],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depth"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place_depth"),
            compilation_options: Default::default(),
            buffers: &[Some(mesh::PLACES)],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target::depth(wgpu::CompareFunction::Greater, true)),
        multisample: shading.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("no_color"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target::FORMAT,
                blend: None,
                write_mask: wgpu::ColorWrites::empty(),
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Bind group 0, and its layout.
struct Bound {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl Bound {
    /// With the shadow maps of suns and of rectangles and the environment's layers, where there are any.
    fn new(
        gpu: &Gpu,
        frame: &wgpu::Buffer,
        lamps: &Lamps,
        [sun_maps, rectangle_maps, sky]: [Option<&wgpu::TextureView>; 3],
    ) -> Self {
        let block = |contents: &[u8]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("lamps"),
                contents,
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let sampler = |compare| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare,
                ..Default::default()
            })
        };
        let (suns, rectangles) = (block(&lamps.sun_block()), block(&lamps.rectangle_block()));
        // Compares depths, and blends four answers.
        let depths = sampler(Some(wgpu::CompareFunction::LessEqual));
        let smooth = sampler(None);
        let mut entries = vec![(textures::uniform_entry(0), frame.as_entire_binding())];
        if let Some(maps) = sun_maps {
            let comparison = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison);
            entries.extend([
                (textures::uniform_entry(1), suns.as_entire_binding()),
                (Shadows::entry(2), wgpu::BindingResource::TextureView(maps)),
                (textures::entry(3, comparison), wgpu::BindingResource::Sampler(&depths)),
            ]);
        }
        if let Some(sky) = sky {
            let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
            let array = wgpu::TextureViewDimension::D2Array;
            entries.extend([
                (textures::texture_entry(4, array), wgpu::BindingResource::TextureView(sky)),
                (textures::entry(5, filtering), wgpu::BindingResource::Sampler(&smooth)),
            ]);
        }
        if let Some(maps) = rectangle_maps {
            entries.extend([
                (textures::uniform_entry(6), rectangles.as_entire_binding()),
                (Shadows::entry(7), wgpu::BindingResource::TextureView(maps)),
            ]);
        }
        let described: Vec<_> = entries.iter().map(|e| e.0).collect();
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &described,
        });
        let resources: Vec<_> = entries
            .into_iter()
            .map(|(entry, resource)| wgpu::BindGroupEntry { binding: entry.binding, resource })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layout,
            entries: &resources,
        });
        Self { layout, group }
    }
}
