//! A scene on the device, and pictures of it.

use bytemuck::Zeroable;
use glam::{Mat4, Vec3};
use rayon::prelude::*;
use wgpu::util::DeviceExt;

use super::background::Background;
use super::deferred::Recorder;
use super::develop::{self, Developer, Development};
use super::edges::Edges;
use super::frame::{FrameUniform, lens_of};
use super::lamps::{Casters, Lamps, hammersley};
use super::mesh::DeviceMesh;
use super::occlusion::Occlusion;
use super::options::{FEWER_STEP, MOST_STEP, Options};
use super::shaded::{self, Room, Shaded};
use super::shadows::Shadows;
use super::slots::{Lit, Places, Sky};
use super::target::{Shading, Target};
use super::timing::Timing;
use super::{Gpu, PreviewError, constants, deferred, environment, occlusion, textures};
use crate::scene::{Camera, Material, Scene};

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
    /// And whether what wears them casts shadows.
    materials: Vec<(Option<Shaded>, bool)>,
    room: Room,
    frame: FrameUniform,
    frame_block: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    shadows: Vec<Shadows>,
    depth: wgpu::RenderPipeline,
    /// What records triangles before they are shaded.
    deferred: Option<Recorder>,
    shading: Shading,
    edges: Option<Edges>,
    occlusion: Option<Occlusion>,
    background: Background,
    target: Option<Target>,
    developer: Developer,
    timing: Option<Timing>,
    samples: u32,
    /// In each of so many samples other ones of the small lights of rectangles shine.
    place_step: u32,
    resources: Vec<(String, u64)>,
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
            discs: lamps.discs.len() as u32,
            sky_layers: environment::LAYERS as f32,
            even: scene.environment.mean_radiance().0,
            sharper: options.sharper(),
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
            (true, Some(_)) if options.directions() > 0 => Sky::Sampled,
            (true, Some(_)) => Sky::Image,
        };
        let places = match place_step >= FEWER_STEP {
            true => Places::Each,
            false if options.shared_shadows && place_step == 1 && lamps.have_quarters() => Places::Shared,
            false => Places::Middle,
        };
        let rectangles = rectangle_maps.is_some().then_some(places);
        let hidden = options.occlusion_slices > 0 && sky != Sky::Dark;
        let lit = Lit { suns: sun_maps.is_some(), rectangles, sky, hidden };
        let maps = [sun_maps.as_ref(), rectangle_maps.as_ref(), sky_view.as_ref()];
        let bound = Bound::new(gpu, &frame_block, &lamps, maps);

        let planes = (options.occlusion_slices, occlusion::has_floor(scene));
        let occlusion = hidden.then(|| Occlusion::new(gpu, &bound.layout, planes, samples));
        let shading = Shading::of(options.once, samples);
        // Either group 3 has what was recorded, or what hides the environment.
        let defers = options.once && options.deferred && !hidden;
        let deferred = defers.then(|| most_worn(&meshes)).flatten();
        let room = Room {
            lit,
            lamps: [lamps.suns.len(), lamps.rectangles.len()],
            lamp_text: constants::text(&lamps),
            frame: bound.layout.clone(),
            openings: occlusion.as_ref().map(|o| o.layout.clone()),
            records: deferred.map(|_| deferred::layout(gpu)),
            options: *options,
        };
        let mut materials = Vec::new();
        for (i, material) in scene.materials.iter().enumerate() {
            let worn = meshes.iter().any(|(_, m)| *m == i);
            let casts = casters.objects.iter().any(|o| scene.objects[*o].material == i);
            let make = || Shaded::new(gpu, &room, (material, casts, deferred == Some(i)), None);
            materials.push((worn.then(make).transpose()?, casts));
        }
        let recorder = deferred.map(|material| {
            let relief = materials[material].0.as_ref().and_then(|shaded: &Shaded| shaded.relief.as_ref());
            Recorder::new(gpu, &room, relief, (material, size_of_maps(&scene.materials[material])))
        });
        let background = Background::new(gpu, scene, &lamps, &bound.layout, shading, &mut resources)?;
        let renderer = Self {
            gpu,
            meshes,
            materials,
            room,
            frame,
            frame_block,
            frame_group: bound.group,
            shadows,
            depth: shaded::depth(gpu, &bound.layout, shading),
            deferred: recorder,
            shading,
            edges: (shading == Shading::Pixels).then(|| Edges::new(gpu, &bound.layout)),
            occlusion,
            background,
            target: None,
            developer: Developer::default(),
            timing: Timing::new(gpu),
            samples,
            place_step,
            resources,
        };
        gpu.wait()?;
        Ok(renderer)
    }

    /// Draw the scene from a camera. A lens blurs by as many points of it as there are samples; with one, all is sharp. Times of passes are those of all samples
    /// together.
    ///
    /// # Errors
    /// If the size is 0 or more than the adapter holds, or the device fails.
    pub fn render(&mut self, camera: &Camera, [width, height]: [usize; 2]) -> Result<Picture, PreviewError> {
        let target = self.fitted([width, height])?;
        let mut sum = Vec::new();
        let mut passes: Vec<(&'static str, Option<f64>)> = Vec::new();
        for sample in 0..self.samples {
            for (name, time) in self.sample(&target, camera, sample, true)? {
                match passes.iter_mut().find(|(n, _)| *n == name) {
                    Some((_, total)) => *total = total.zip(time).map(|(a, b)| a + b),
                    None => passes.push((name, time)),
                }
            }
            target.add_to(self.gpu, &mut sum)?;
        }
        if self.samples > 1 {
            let scale = 1.0 / self.samples as f32;
            sum.par_iter_mut().for_each(|texel: &mut [f32; 3]| *texel = texel.map(|c| c * scale));
        }
        self.target = Some(target);
        Ok(Picture { width, height, texels: sum, passes })
    }

    /// Draw one sample of each pixel, and leave the picture on the device for [`Renderer::develop`].
    ///
    /// # Errors
    /// If the size is 0 or more than the adapter holds, or the device fails.
    pub fn keep(&mut self, camera: &Camera, size: [usize; 2]) -> Result<(), PreviewError> {
        let target = self.fitted(size)?;
        self.sample(&target, camera, 0, false)?;
        self.target = Some(target);
        Ok(())
    }

    /// What a screen shows of the last sample that was drawn, row by row from the top: red, green, blue and 255. `None` if none
    /// was.
    ///
    /// # Errors
    /// If the device fails.
    pub fn develop(&mut self, development: &Development) -> Result<Option<Vec<u8>>, PreviewError> {
        let Some(target) = &self.target else { return Ok(None) };
        develop::develop(self.gpu, &mut self.developer, &target.pixels, development).map(Some)
    }

    /// A target of a size, the last one if it has it.
    fn fitted(&mut self, size: [usize; 2]) -> Result<Target, PreviewError> {
        let target = match self.target.take().filter(|t| t.size() == size) {
            Some(target) => target,
            None => Target::new(self.gpu, size, self.shading, self.deferred.is_some())?,
        };
        if let Some(occlusion) = &mut self.occlusion {
            occlusion.fit(self.gpu, &target);
        }
        Ok(target)
    }

    /// Draw one of the samples of each pixel, tell the passes' times, and copy it to memory if it is wanted there.
    fn sample(
        &mut self,
        target: &Target,
        camera: &Camera,
        sample: u32,
        copied: bool,
    ) -> Result<Vec<(&'static str, Option<f64>)>, PreviewError> {
        let shift = hammersley(sample as usize, self.samples as usize).map(|t| t - 0.5);
        let (block, offset) = (sample / self.place_step, sample % self.place_step);
        let visits = self.samples.div_ceil(self.place_step);
        let frame = FrameUniform {
            discs: self.frame.discs,
            sky_layers: self.frame.sky_layers,
            even: self.frame.even,
            sharper: self.frame.sharper,
            // Not the same ones in the same part of pixels each time.
            first_place: (offset + block) % self.place_step,
            place_step: self.place_step,
            place_shift: hammersley(block as usize, visits as usize).map(|t| t - 0.5),
            sample,
            ..FrameUniform::new(camera, target.size(), shift, lens_of(sample, self.samples))
        };
        self.gpu.queue.write_buffer(&self.frame_block, 0, bytemuck::bytes_of(&frame));
        self.draw(target, Vec3::from(frame.eye), copied)
    }

    /// Draw one sample of each pixel as this eye sees it, and tell the passes' times.
    fn draw(
        &mut self,
        target: &Target,
        eye: Vec3,
        copied: bool,
    ) -> Result<Vec<(&'static str, Option<f64>)>, PreviewError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut names = Vec::new();
        for shadows in self.shadows.iter_mut().filter(|s| !s.drawn) {
            shadows.draw(&mut encoder, &self.meshes, self.timing.as_ref().map(|t| t.pair(names.len())));
            names.push(shadows.name);
        }
        if let Some(occlusion) = &self.occlusion {
            let first = names.len();
            let times = |i: usize| self.timing.as_ref().map(|t| t.pair(first + i));
            occlusion.draw(self.gpu, &mut encoder, target, (&self.frame_group, &self.meshes), times);
            names.extend(occlusion.passes());
        }
        if let Some((recorder, recorded)) = self.deferred.as_ref().zip(target.recorded.as_ref()) {
            let times = |place: usize| self.timing.as_ref().map(|t| t.pair(place));
            let mut pass = recorded.begin(&mut encoder, &target.depth, times(names.len()));
            pass.set_bind_group(0, &self.frame_group, &[]);
            if let Some((Some(shaded), _)) = self.materials.get(recorder.material) {
                shaded.set_relief(&mut pass);
            }
            recorder.draw(&mut pass, &self.meshes, eye);
            drop(pass);
            names.push("record");
            let mut pass = target.begin_deferred(&mut encoder, times(names.len()));
            if let Some((Some(shaded), _)) = self.materials.get(recorder.material) {
                pass.set_bind_group(0, &self.frame_group, &[]);
                shaded.set(&mut pass);
                pass.set_bind_group(3, &recorded.group, &[]);
                pass.draw(0..3, 0..1);
            }
            drop(pass);
            names.push("deferred");
        }
        self.shade(&mut encoder, target, names.len());
        names.push("picture");
        if let Some((edges, samples)) = self.edges.as_ref().zip(target.samples.as_ref()) {
            let times = |place: usize| self.timing.as_ref().map(|t| t.pair(place));
            let mut pass = Target::begin_depths(samples, &mut encoder, times(names.len()));
            edges.depths(&mut pass, &self.frame_group, &self.meshes, eye);
            drop(pass);
            names.push("depths of samples");
            let mut pass = target.begin_whole(&mut encoder, times(names.len()));
            edges.picture(self.gpu, &mut pass, target, samples);
            drop(pass);
            names.push("edges");
        }
        if copied {
            target.copy(&mut encoder);
        }
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
        let measured = self.occlusion.is_some() && self.shading != Shading::Triangles;
        let mut pass = target.begin(encoder, measured, self.timing.as_ref().map(|t| t.pair(place)));
        pass.set_bind_group(0, &self.frame_group, &[]);
        let done = self.deferred.as_ref().map(|recorder| recorder.material);
        let left = || self.meshes.iter().filter(|(_, material)| Some(*material) != done);
        if !measured {
            // Depth alone first, so that only what is seen is shaded.
            pass.set_pipeline(&self.depth);
            left().for_each(|(mesh, _)| mesh.draw(&mut pass));
        }
        if let Some(occlusion) = &self.occlusion {
            occlusion.bind(&mut pass);
        }
        for (mesh, material) in left() {
            if let Some((Some(shaded), _)) = self.materials.get(*material) {
                shaded.set(&mut pass);
                mesh.draw(&mut pass);
            }
        }
        self.background.draw(&mut pass);
    }

    /// Dress everything that wears the material of an index in another one; nothing if nobody does. Much quicker than a new
    /// renderer: meshes, light and shadows stay as they are, displacement by the maps of the old one, too, and so does the
    /// shader where the new one needs no other.
    ///
    /// # Errors
    /// If the material is out of range, its maps are larger than the adapter holds, or the device fails. Then the old one stays.
    pub fn wear(&mut self, index: usize, material: &Material) -> Result<(), PreviewError> {
        let Some((Some(before), casts)) = self.materials.get(index) else { return Ok(()) };
        let how = (material, *casts, before.is_recorded());
        let shaded = Shaded::new(self.gpu, &self.room, how, Some(before))?;
        // Records have the levels of maps of one size.
        let record =
            || Recorder::new(self.gpu, &self.room, shaded.relief.as_ref(), (index, size_of_maps(material)));
        let recorder = how.2.then(record);
        self.gpu.wait()?;
        self.deferred = recorder.or(self.deferred.take());
        self.materials[index].0 = Some(shaded);
        Ok(())
    }

    /// Materials that something wears.
    fn worn(&self) -> impl Iterator<Item = &Shaded> {
        self.materials.iter().filter_map(|(shaded, _)| shaded.as_ref())
    }

    /// What lies on the device, with bytes.
    pub fn resources(&self) -> Vec<(String, u64)> {
        let target = self.target.as_ref().map(|t| ("picture and depth".to_owned(), t.bytes()));
        let openings = self.occlusion.as_ref().map(|o| ("occlusion".to_owned(), o.bytes()));
        let worn = self.worn().flat_map(|material| material.resources.iter().cloned());
        self.resources.iter().cloned().chain(worn).chain(target).chain(openings).collect()
    }

    /// The files of each material's shader, and of the background's.
    pub fn slots(&self) -> Vec<Vec<&'static str>> {
        let materials = self.worn().map(|m| m.slots.clone());
        materials.chain([self.background.slots()]).collect()
    }
}

/// The material that most triangles wear.
fn most_worn(meshes: &[(DeviceMesh, usize)]) -> Option<usize> {
    let worn = |material: usize| {
        meshes.iter().filter(|m| m.1 == material).map(|m| u64::from(m.0.triangles())).sum::<u64>()
    };
    meshes.iter().map(|m| m.1).max_by_key(|material| worn(*material))
}

/// Columns and rows of a material's maps.
fn size_of_maps(material: &Material) -> [usize; 2] {
    material.maps.as_ref().map_or([1, 1], |maps| [maps.width, maps.height])
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
