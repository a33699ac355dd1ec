//! The shaders of skin against `optics`, on whatever adapter there is; and all of them against naga without one.

mod facets;
mod gratings;
mod programs;

use super::Gpu;
use super::binding;
use super::device::tests::gpu;
use super::lobe;
use super::material::{self, SkinData};
use super::program::{SkinOptions, SkinProgram};
use crate::base::hash;
use crate::optics::base_layer::Tint;
use crate::optics::layered::{Albedo, Constants, Energy, LEAST_ROUGHNESS, Parts, Point};
use crate::optics::{Base, Film, FilmColor, Grating, Layers, Method, ggx};
use crate::scene::SceneFeatures;

/// What a shader is asked, and how it lies in memory.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Question {
    albedo: [f32; 3],
    roughness: f32,
    wo: [f32; 3],
    thickness_nm: f32,
    wi: [f32; 3],
    spread_nm: f32,
}

const PROBE: &str = "
struct Question {
    albedo: vec3f, roughness: f32,
    wo: vec3f, thickness_nm: f32,
    wi: vec3f, spread_nm: f32,
}
@group(0) @binding(0) var<storage, read> questions: array<Question>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4f>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&questions) {
        return;
    }
    let q = questions[id.x];
    let s = skin_view(SurfacePoint(q.albedo, q.roughness, q.thickness_nm, q.spread_nm, 0.0), q.wo);
    answers[4u * id.x] = vec4f(skin_eval(s, q.wi), skin_alpha(s));
    answers[4u * id.x + 1u] = vec4f(skin_shine(s, q.wi), 0.0);
    answers[4u * id.x + 2u] = vec4f(skin_ambient(s, vec3f(1.0), vec3f(0.0)), 0.0);
    answers[4u * id.x + 3u] = vec4f(skin_ambient(s, vec3f(0.0), gloss_ambient(s)), 0.0);
}
";

/// What a shader answers.
#[derive(Clone, Copy, Debug)]
struct Answer {
    eval: [f32; 3],
    alpha: f32,
    shine: [f32; 3],
    /// By even light from all around: from the base, and from the film.
    base: [f32; 3],
    gloss: [f32; 3],
}

fn ask(gpu: &Gpu, program: &SkinProgram, data: &SkinData, questions: &[Question]) -> Vec<Answer> {
    let rgb = |t: [f32; 4]| [t[0], t[1], t[2]];
    let answer = |t: [[f32; 4]; 4]| Answer {
        eval: rgb(t[0]),
        alpha: t[0][3],
        shine: rgb(t[1]),
        base: rgb(t[2]),
        gloss: rgb(t[3]),
    };
    ask_by(gpu, program, data, questions, PROBE).into_iter().map(answer).collect()
}

/// By another probe, four texels for each question.
fn ask_by(
    gpu: &Gpu,
    program: &SkinProgram,
    data: &SkinData,
    questions: &[Question],
    probe: &str,
) -> Vec<[[f32; 4]; 4]> {
    use wgpu::util::DeviceExt;
    let device = &gpu.device;
    let source = program.source() + probe;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let size = questions.len() as u64 * 64;
    let input = buffer(bytemuck::cast_slice(questions), wgpu::BufferUsages::STORAGE);
    let output = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let storage = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[storage(0, true), storage(1, false)],
    });
    let materials = binding::layout(gpu, data);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&own), Some(&materials)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &module,
        entry_point: Some("probe"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &program.constants(),
            ..Default::default()
        },
        cache: None,
    });
    let buffers = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &own,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
        ],
    });
    let material = binding::group(gpu, &materials, data);
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &buffers, &[]);
        pass.set_bind_group(1, &material, &[]);
        pass.dispatch_workgroups(questions.len().div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &back, 0, size);
    gpu.queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("mapped"));
    gpu.wait().expect("the device answers");
    let bytes = back.slice(..).get_mapped_range().expect("mapped");
    bytemuck::cast_slice(&bytes).to_vec()
}

/// A uniform number in [0, 1) for each counter.
fn unit(counter: u32) -> f32 {
    (hash::pcg(hash::pcg(counter) ^ 0x51ed_270b) >> 8) as f32 / (1 << 24) as f32
}

fn direction(z: f32, turns: f32) -> [f32; 3] {
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * turns).sin_cos();
    [r * cos, r * sin, z]
}

/// Thousands of points, views and lights: even ones, and extremes of each in all mixtures.
fn questions(thickness_nm: Option<f32>) -> Vec<Question> {
    let mut all: Vec<Question> = (0..4000)
        .map(|i| {
            let u = |k: u32| unit(i * 16 + k);
            Question {
                albedo: [u(0), u(1), u(2)],
                roughness: u(3),
                wo: direction(u(4), u(5)),
                thickness_nm: thickness_nm.unwrap_or(1500.0 * u(6)),
                wi: direction(u(7), u(8)),
                spread_nm: 0.0,
            }
        })
        .collect();
    // Near the mirror direction, where the lobe is.
    let mirrored: Vec<Question> = all
        .iter()
        .map(|q| {
            let wi = direction((q.wo[2] + 0.02).min(1.0), 0.0);
            let r = (q.wo[0] * q.wo[0] + q.wo[1] * q.wo[1]).sqrt().max(1e-9);
            let scale = -wi[0] / r;
            Question { wi: [q.wo[0] * scale, q.wo[1] * scale, wi[2]], ..*q }
        })
        .collect();
    all.extend(mirrored);
    for albedo in [0.0, 1.0] {
        for roughness in [0.01, 1.0] {
            for wo in [-0.5, 0.0, 1e-6, 1e-3, 1.0] {
                for wi in [-0.5, 0.0, 1e-6, 1e-3, 1.0] {
                    for thickness in [0.0, 0.1, 400.0, 2400.0, 2.4e6, 1e9] {
                        all.push(Question {
                            albedo: [albedo; 3],
                            roughness,
                            wo: direction(wo, 0.1),
                            thickness_nm: thickness_nm.unwrap_or(thickness),
                            wi: direction(wi, 0.6),
                            spread_nm: 0.0,
                        });
                    }
                }
            }
        }
    }
    all
}

/// Greatest error of `got` against `expected`, as a share of it; of what is less than `floor`, of that.
fn error(got: [f32; 3], expected: [f32; 3], floor: f32) -> f32 {
    assert!(got.iter().all(|x| x.is_finite() && *x >= 0.0), "{got:?} for {expected:?}");
    let scale = expected.iter().fold(floor, |m, x| m.max(*x));
    (0..3).map(|c| (got[c] - expected[c]).abs() / scale).fold(0.0, f32::max)
}

fn point(q: &Question, constants: &Constants, thicker: f32) -> Point<f32, 3> {
    Point {
        thickness_nm: q.thickness_nm * thicker,
        roughness: q.roughness.max(LEAST_ROUGHNESS as f32),
        albedo: q.albedo,
        absorption: constants.absorption,
    }
}

/// The materials of the tests: everything alone, and together; and what the shader may differ by.
fn materials() -> Vec<(Constants, SceneFeatures, f32)> {
    let plain = Constants::default();
    let features = SceneFeatures { interface: true, base: true, ..SceneFeatures::default() };
    let film = SceneFeatures { film: true, thickness_map: true, ..features };
    let absorbing = |f: SceneFeatures| SceneFeatures { absorber: true, ..f };
    let wrapped = |f: SceneFeatures| SceneFeatures { wrapped_base: true, ..f };
    let coupled = |f: SceneFeatures| SceneFeatures { coupled_energy: true, ..f };
    let total = |f: SceneFeatures| SceneFeatures { total_reflection: true, ..f };
    let dispersive = |f: SceneFeatures| SceneFeatures { dispersion: true, ..f };
    // Ten times keratin's: it has to be seen.
    let dispersed = |c: Constants| Constants { dispersion_nm2: [58_900.0, 90_000.0], ..c };
    let curved = |thickness_mm| Base::Curved { curvature_per_mm: 0.3, thickness_mm };
    let half = |tint| Base::HalfLambert { blood: [0.9, 0.4, 0.1], tint };
    let even = SceneFeatures { thickness_map: false, ..film };
    vec![
        (plain, features, SHARE),
        (Constants { absorption: [0.1, 0.6, 3.0], ..plain }, absorbing(features), SHARE),
        (plain, film, SHARE),
        (plain, even, SHARE),
        (
            Constants { albedo: Albedo::Intrinsic, absorption: [0.0, 0.7, 100.0], ..plain },
            absorbing(film),
            SHARE,
        ),
        (Constants { indices: [1.0, 1.33, 1.0], absorption: [0.2; 3], ..plain }, absorbing(film), SHARE),
        (Constants { indices: [1.0, 1.55, 1.4], ..plain }, film, SHARE),
        (Constants { indices: [1.33, 1.55, 1.4], ..plain }, film, SHARE),
        (
            Constants { indices: [1.0; 3], ..plain },
            SceneFeatures { base: true, ..SceneFeatures::default() },
            SHARE,
        ),
        (Constants { base: half(Tint::FromNormal), ..plain }, wrapped(film), SHARE),
        (
            Constants { base: half(Tint::FromHorizon), absorption: [0.3; 3], ..plain },
            wrapped(absorbing(even)),
            SHARE,
        ),
        (Constants { base: curved(f32::INFINITY), ..plain }, wrapped(film), SHARE),
        (
            Constants { base: curved(0.5), absorption: [0.3; 3], ..plain },
            SceneFeatures { translucent_base: true, ..wrapped(absorbing(film)) },
            SHARE,
        ),
        // Tables of `optics` have a kink.
        (Constants { indices: [1.5, 1.0, 1.4], ..plain }, total(film), 1e-3),
        (Constants { indices: [1.5, 1.55, 1.3], ..plain }, total(film), 1e-3),
        (dispersed(plain), dispersive(film), SHARE),
        (dispersed(plain), dispersive(features), SHARE),
        (dispersed(Constants { absorption: [0.1, 0.6, 3.0], ..plain }), dispersive(absorbing(even)), SHARE),
        (
            dispersed(Constants { indices: [1.33, 1.55, 1.4], absorption: [0.2; 3], ..plain }),
            dispersive(absorbing(film)),
            SHARE,
        ),
        (
            dispersed(Constants { base: half(Tint::FromNormal), absorption: [0.3; 3], ..plain }),
            dispersive(wrapped(absorbing(film))),
            5e-3,
        ),
        (dispersed(Constants { indices: [1.5, 1.0, 1.4], ..plain }), dispersive(total(film)), 5e-3),
        (Constants { energy: Energy::Coupled, ..plain }, coupled(film), ROUGH),
        (
            Constants { energy: Energy::Coupled, absorption: [0.3; 3], ..plain },
            absorbing(coupled(features)),
            ROUGH,
        ),
    ]
}

/// The questions for a material. Where energy is coupled both sides have tables, which are coarse where smooth surfaces
/// graze: not those.
fn asked_of(features: &SceneFeatures, thickness_nm: Option<f32>) -> Vec<Question> {
    let mut asked = questions(thickness_nm);
    // Thicker ones have more fringes than there are wavelengths, and f32 digits of their phases.
    if features.dispersion {
        // And of light that nearly grazes, what a sum of 32 wavelengths leaves of 1 has few.
        asked.retain(|q| q.thickness_nm <= 2400.0 && (q.wo[2] <= 0.0 || q.wo[2] >= 1e-3));
    }
    if features.coupled_energy {
        asked.retain(|q| q.roughness >= 0.1 && q.wo[2] > 0.1 && q.wi[2] > 0.1);
    }
    asked
}

/// What the shader and `optics` may differ by: rounding, and tables that are coarser by turns.
const SHARE: f32 = 3e-4;
/// The same where the three mirrors of a lobe stand against a table of its integrals.
const ROUGH: f32 = 2e-2;

#[test]
fn shaders_give_what_optics_gives() {
    let Some(gpu) = gpu() else { return };
    let colors = FilmColor::<f32>::new(Method::Series(3));
    for (constants, features, share) in materials() {
        let program = SkinProgram::new(&features, &SkinOptions::default());
        let even = (!features.thickness_map).then_some(if features.film { 430.0 } else { 0.0 });
        let data = SkinData::new(&constants, even.unwrap_or(0.0), &program).expect("a material");
        let asked = asked_of(&features, even);
        let answers = ask(&gpu, &program, &data, &asked);
        let layers = Layers::<f32>::new(&constants).expect("a material");
        let (mut worst, mut thicker) = (0.0f32, 0.0f32);
        for (q, answer) in asked.iter().zip(&answers) {
            let at = |factor: f32| point(q, &constants, factor);
            let value = |factor: f32| layers.view(&colors, &at(factor), q.wo, Parts::All).eval(q.wi);
            // Reflectances below a thousandth are all rounding.
            let roughness = at(1.0).roughness;
            let whole = ggx_lobe(roughness * roughness, q.wo, q.wi);
            let floor = 0.01f32.max(1e-3 * whole);
            let (expected, nl) = (value(1.0), q.wi[2]);
            // At the horizon a wrapped base has no BRDF.
            let cosine = if features.wrapped_base { nl.abs().max(1e-7) } else { nl.max(0.0) };
            let one = error(answer.eval, expected, floor).max(error(
                answer.shine,
                expected.map(|f| f * cosine),
                floor * cosine + 1e-9,
            ));
            assert!(one < share, "{constants:?} {q:?}: {answer:?} for {expected:?}, {one:e}");
            worst = worst.max(one);
            thicker = thicker.max(error(answer.eval, value(1.05), floor));
            assert!((answer.alpha - roughness * roughness).abs() < 1e-7);
        }
        println!("{:?}: {worst:e}, 5 % thicker {thicker:e}", program.slots());
        // The control: a film 5 % thicker fails.
        assert_eq!(thicker > 10.0 * share, features.film, "{constants:?} {thicker:e}");
    }
}

/// The lobe of a perfect mirror: D V.
fn ggx_lobe(alpha: f32, wo: [f32; 3], wi: [f32; 3]) -> f32 {
    let (nl, nv) = (wi[2].max(1e-7), wo[2].max(1e-7));
    let sum = [wi[0] + wo[0], wi[1] + wo[1], nl + nv];
    let length = sum.iter().map(|x| x * x).sum::<f32>().sqrt();
    ggx::density_at(alpha, sum.map(|x| x / length)) * ggx::visibility(alpha, nl, nv)
}

#[test]
fn a_mirror_is_shaded_as_the_least_rough_surface() {
    let Some(gpu) = gpu() else { return };
    let (constants, features, _) = materials()[2];
    let program = SkinProgram::new(&features, &SkinOptions::default());
    let data = SkinData::new(&constants, 0.0, &program).expect("a material");
    let with = |roughness: f32| {
        let asked: Vec<_> = questions(None).into_iter().map(|q| Question { roughness, ..q }).collect();
        let shine = |a: &Answer| (a.shine.map(f32::to_bits), a.gloss.map(f32::to_bits), a.alpha.to_bits());
        ask(&gpu, &program, &data, &asked).iter().map(shine).collect::<Vec<_>>()
    };
    assert!(with(0.0) == with(LEAST_ROUGHNESS as f32));
    assert!(with(0.0) != with(0.02));
}

/// Even light from all around, by integrals over the BRDF of `optics`, and the gloss by the nodes of the table.
#[test]
fn light_from_all_around_is_the_integral_over_the_brdf() {
    let Some(gpu) = gpu() else { return };
    let colors = FilmColor::<f32>::new(Method::Series(3));
    let table = lobe::table();
    for (constants, features, share) in materials() {
        let program = SkinProgram::new(&features, &SkinOptions::default());
        let even = (!features.thickness_map).then_some(if features.film { 430.0 } else { 0.0 });
        let data = SkinData::new(&constants, even.unwrap_or(0.0), &program).expect("a material");
        let asked = &asked_of(&features, even)[..200];
        let layers = Layers::<f32>::new(&constants).expect("a material");
        let (mut base, mut gloss, mut thicker) = (0.0f32, 0.0f32, 0.0f32);
        for (q, answer) in asked.iter().zip(ask(&gpu, &program, &data, asked)) {
            let integral = |factor: f32| {
                let view = layers.view(&colors, &point(q, &constants, factor), q.wo, Parts::Diffuse);
                // Cosines crowd where light grazes: u = s^2, and u du = 2 s^3 ds.
                let count = 64;
                (0..count).fold([0.0; 3], |sum: [f32; 3], i| {
                    let s = (i as f32 + 0.5) / count as f32;
                    // From below, too, where the base wraps around.
                    let [f, g] = [s * s, -s * s].map(|z| view.eval(direction(z, 0.0)));
                    let weight = std::f32::consts::TAU * 2.0 * s * s * s / count as f32;
                    std::array::from_fn(|c| sum[c] + weight * (f[c] + g[c]))
                })
            };
            base = base.max(error(answer.base, integral(1.0), 0.01));
            thicker = thicker.max(error(answer.base, integral(1.05), 0.01));
            let film = film(&constants, q.thickness_nm);
            let nodes = lobe::interpolated(&table, f64::from(q.roughness.max(0.01)), f64::from(q.wo[2]));
            let reflected = nodes.iter().fold([0.0f32; 3], |sum, (w, c)| {
                let r = material::reflected(&constants, &colors, &film, *c as f32);
                std::array::from_fn(|k| sum[k] + *w as f32 * r[k])
            });
            gloss = gloss.max(error(answer.gloss, reflected, 0.01));
        }
        println!("{:?}: base {base:e}, gloss {gloss:e}, 5 % thicker {thicker:e}", program.slots());
        // The tables of `optics` have 24 directions: few for paths without end, where n2 = n0, and fewer for a critical angle.
        let bound = if features.total_reflection { 0.2 } else { share.max(3e-3) };
        assert!(base < bound && gloss < SHARE, "{constants:?}: {base:e} {gloss:e}");
        assert!(thicker > 1e-2 || !features.film, "{thicker:e}");
    }
}

fn film(constants: &Constants, thickness_nm: f32) -> Film<f32> {
    let [n0, n1, n2] = constants.indices;
    Film::new(n0, n1, n2, thickness_nm).expect("a film")
}

/// A pixel over which the thickness varies shows the mean of its films.
#[test]
fn the_footprint_of_thickness_is_averaged() {
    let Some(gpu) = gpu() else { return };
    let colors = FilmColor::<f32>::new(Method::Series(3));
    // A film whose colours are all in gamut: the mean of colours that are cut is not the mean that is cut.
    let (constants, features, _) = materials()[6];
    let layers = Layers::<f32>::new(&constants).expect("a material");
    let errors = |footprint: bool| {
        let options = SkinOptions { footprint, parts: Parts::Specular, ..SkinOptions::default() };
        let program = SkinProgram::new(&features, &options);
        let data = SkinData::new(&constants, 0.0, &program).expect("a material");
        let spread = |i: usize| [0.0, 1.0, 3.0, 10.0, 60.0, 200.0, 600.0][i % 7];
        let asked: Vec<_> = questions(None)[4000..6000]
            .iter()
            .enumerate()
            .filter(|(_, q)| q.thickness_nm > 320.0 && q.wo[2] > 0.1)
            .map(|(i, q)| Question { spread_nm: spread(i), roughness: 0.3, ..*q })
            .collect();
        let mut worst = 0.0f32;
        for (q, answer) in asked.iter().zip(ask(&gpu, &program, &data, &asked)) {
            let count = 64;
            let mean = (0..count).fold([0.0; 3], |sum: [f32; 3], i| {
                let thickness_nm = q.thickness_nm + q.spread_nm * ((i as f32 + 0.5) / count as f32 - 0.5);
                let point = Point { thickness_nm, ..point(q, &constants, 1.0) };
                let f = layers.view(&colors, &point, q.wo, Parts::Specular).eval(q.wi);
                std::array::from_fn(|c| sum[c] + f[c] / count as f32)
            });
            worst = worst.max(error(answer.eval, mean, 0.01));
        }
        worst
    };
    let (filtered, plain) = (errors(true), errors(false));
    println!("filtered {filtered:e}, not filtered {plain:e}");
    assert!(filtered < 2e-3 && plain > 0.1, "{filtered:e} {plain:e}");
}
