//! Pipelines that draw objects: a material's colours, and depth alone.

use super::material::SkinData;
use super::options::{FEWER_STEP, Options};
use super::program::{SkinProgram, Slot};
use super::slots::{self, Has, Lit};
use super::target::{self, Shading};
use super::textures::Surface;
use super::{Gpu, PreviewError, binding, mesh};
use crate::scene::{Material, SceneFeatures};

/// What is the same for all materials of a scene.
#[derive(Debug)]
pub(super) struct Room {
    /// What lights objects.
    pub(super) lit: Lit,
    /// Suns and rectangles.
    pub(super) lamps: [usize; 2],
    /// The layout of bind group 0.
    pub(super) frame: wgpu::BindGroupLayout,
    /// Lamps as text of shaders.
    pub(super) lamp_text: String,
    /// That of group 3, where something hides the environment.
    pub(super) openings: Option<wgpu::BindGroupLayout>,
    /// And of what is recorded first.
    pub(super) records: Option<wgpu::BindGroupLayout>,
    /// What was chosen.
    pub(super) options: Options,
}

/// What a pipeline depends on: materials of equal ones draw with the same.
#[derive(Clone, Debug, PartialEq)]
struct Kind {
    program: SkinProgram,
    has: Has,
    casts: bool,
}

/// A material ready to be drawn with.
#[derive(Debug)]
pub(super) struct Shaded {
    /// Draws with it.
    pipeline: wgpu::RenderPipeline,
    /// Bind group 1.
    material: wgpu::BindGroup,
    /// Bind group 2.
    surface: wgpu::BindGroup,
    /// Its layout, where what records it reads a relief there.
    pub(super) relief: Option<wgpu::BindGroupLayout>,
    /// The files of its shader.
    pub(super) slots: Vec<&'static str>,
    /// What lies on the device, with bytes.
    pub(super) resources: Vec<(String, u64)>,
    kind: Kind,
}

impl Shaded {
    /// A material, whether what wears it casts shadows, and whether it is recorded first. The pipeline is that of `before`, if it
    /// suits.
    ///
    /// # Errors
    /// If it is out of range or larger than the adapter holds.
    pub(super) fn new(
        gpu: &Gpu,
        room: &Room,
        (material, casts, recorded): (&Material, bool, bool),
        before: Option<&Self>,
    ) -> Result<Self, PreviewError> {
        let options = &room.options;
        let compact = options.compact_maps && options.samples < FEWER_STEP;
        let program = SkinProgram::new(&SceneFeatures::of_material(material), &options.skin);
        // Where all texels are alike, the light below the film is that of their thickness.
        let data = SkinData::new(&material.constants, material.texel(0.5, 0.5).thickness_nm, &program)
            .map_err(|e| PreviewError::Material(e.to_string()))?;
        let mut resources: Vec<_> =
            data.tables.iter().map(|t| (t.name.to_owned(), 16 * t.texels.len() as u64)).collect();
        let material_layout = binding::layout(gpu, &data);
        let surface = Surface::new(gpu, material, options, compact)?;
        resources.extend(surface.textures.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)));

        let film_table = surface.film_table && (program.has("film_series") || program.has("film_dispersed"));
        let maps = material.maps.is_some();
        let (film_width, relief) = (surface.film_width, surface.relief);
        let has = Has { maps, film_table, film_width, recorded, bytes: compact, relief };
        let files = slots::files(&program, has, room.lit);
        let kind = Kind { program, has, casts };
        let pipeline = match before.filter(|before| before.kind == kind) {
            // Layouts of equal entries are equal.
            Some(before) => before.pipeline.clone(),
            None => pipeline(gpu, room, &kind, &files, [&material_layout, &surface.layout]),
        };
        let material = binding::group(gpu, &material_layout, &data);
        let slots = files.iter().map(|f| f.name).collect();
        let relief = surface.relief.then_some(surface.layout);
        Ok(Self { pipeline, material, surface: surface.group, relief, slots, resources, kind })
    }
}

impl Shaded {
    /// Set a pass to draw with it.
    pub(super) fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(1, &self.material, &[]);
        pass.set_bind_group(2, &self.surface, &[]);
    }

    /// Set a pass to record what wears it.
    pub(super) fn set_relief(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.relief.is_some() {
            pass.set_bind_group(2, &self.surface, &[]);
        }
    }

    /// Whether it is recorded first.
    pub(super) fn is_recorded(&self) -> bool {
        self.kind.has.recorded
    }
}

/// Draws what wears a material of this kind.
fn pipeline(
    gpu: &Gpu,
    room: &Room,
    kind: &Kind,
    files: &[Slot],
    [material, surface]: [&wgpu::BindGroupLayout; 2],
) -> wgpu::RenderPipeline {
    // The table has its own order of the series.
    let mut constants = if kind.has.film_table { Vec::new() } else { kind.program.constants() };
    if !kind.casts {
        constants.push(("SHADOW_LIFT", 0.0));
    }
    if kind.has.relief && !kind.has.recorded {
        constants.push(("RELIEF_STEPS", f64::from(room.options.parallax_steps.max(1))));
    }
    if files.iter().any(|file| file.name == "sky_lobe") {
        let directions = room.options.directions();
        let all = f64::from(directions) * f64::from(room.options.samples.max(1));
        // A lobe's solid angle goes by the square of its width.
        constants.extend([("SKY_DIRECTIONS", f64::from(directions)), ("SKY_PART", all.sqrt().recip())]);
    }
    let (lit, [suns, rectangles]) = (room.lit, room.lamps);
    let counts = [(lit.suns, "SUNS", suns), (lit.rectangles.is_some(), "RECTANGLES", rectangles)];
    constants.extend(counts.iter().filter(|c| c.0).map(|(_, name, count)| (*name, *count as f64)));
    let module = slots::module(gpu, "skin", files, &room.lamp_text);
    let read = if kind.has.recorded { room.records.as_ref() } else { room.openings.as_ref() };
    let groups = [Some(&room.frame), Some(material), Some(surface), read];
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("skin"),
        bind_group_layouts: &groups[..if read.is_some() { 4 } else { 3 }],
        immediate_size: 0,
    });
    let buffers = [Some(mesh::LAYOUT)];
    let (vertex, buffers, compare) = match kind.has.recorded {
        // It is drawn at the far end, and seen where anything is.
        true => ("everywhere", &buffers[..0], wgpu::CompareFunction::Less),
        false => ("place", &buffers[..], wgpu::CompareFunction::Equal),
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("skin"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target::depth(compare, false)),
        multisample: Shading::of(room.options.once, room.options.samples).multisample(),
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
    })
}

/// Draws nothing but depth.
pub(super) fn depth(gpu: &Gpu, frame: &wgpu::BindGroupLayout, shading: Shading) -> wgpu::RenderPipeline {
    let module = slots::module(gpu, "depth", &slots::slots!["frame", "depth"], "");
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
