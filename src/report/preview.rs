//! The report on the preview: its pictures against the path tracer's, and what every shortcut of it saves and costs.

mod gratings;
mod shortcuts;
mod sky;

use std::time::Instant;

use glam::Vec3;

use super::metric::{ColorErrors, FlipError, PIXELS_PER_DEGREE, flip};
use super::optics::Effort;
use super::table::{Cell, Table};
use super::{Page, Report, Watch, picture};
use crate::base::{LinearRgb, Srgb8, num};
use crate::preview::{Gpu, Options, PreviewError, Renderer, SkinOptions};
use crate::reference::{self, Control, RenderError, Settings, Transport};
use crate::scene::Scene;
use crate::scene::tone::ToneMap;

/// A skin on the subject of a scene, and how it is shown.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the skin.
    pub skin: String,
    /// The scene with it.
    pub scene: Scene,
    /// Power of two before the tone curve.
    pub exposure_ev: f32,
    /// Tone curve.
    pub tone: ToneMap,
}

/// A skin whose relief is seen: drawn on `flat` by parallax, and as triangles of `displaced`.
#[derive(Clone, Debug)]
pub struct Relief {
    /// Times the height map.
    pub amount: f32,
    /// On the surface of the subject.
    pub flat: Case,
    /// On a surface that the height map has moved.
    pub displaced: Case,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The preview cannot draw a scene.
    #[error(transparent)]
    Preview(#[from] PreviewError),
    /// The path tracer cannot.
    #[error(transparent)]
    Reference(#[from] RenderError),
    /// Pictures cannot be compared.
    #[error(transparent)]
    Flip(#[from] FlipError),
    /// Pictures cannot be laid on the page.
    #[error(transparent)]
    Picture(#[from] png::EncodingError),
}

/// How large, and how many samples.
struct Sizes {
    /// Columns and rows of pictures that are compared.
    compared: [usize; 2],
    /// Samples per pixel of the path tracer, by direct light and by all light.
    samples: [u32; 2],
    /// Columns and rows of pictures whose shortcuts are timed, and of a frame.
    shortcuts: [usize; 2],
    frame: [usize; 2],
}

/// Light as a rasteriser draws it, and all of it.
const DIRECT: Transport = Transport::Direct { environment_shadows: false };
const FULL: Transport = Transport::Full { bounces: 8 };
/// Film thickness of the thesis's figures 5.5 to 5.13, nm, and absorption of figure 5.14.
const THICKNESSES_NM: [f32; 6] = [200.0, 400.0, 600.0, 0.0, 2400.0, 2.4e6];
const ABSORPTIONS: [f32; 2] = [0.1, 0.7];
/// Snakes of the thesis's table 5.3, and its milliseconds.
const SNAKES: [(usize, f64); 4] = [(0, 0.09), (1, 0.17), (5, 0.18), (20, 0.21)];

/// Draw and trace all cases, pictures that are compared in columns and rows of `compared` unless those of the effort will do.
/// Shortcuts are those of the first case; `plain` is an even skin under a film, for the gallery.
///
/// # Errors
/// If a scene cannot be drawn or traced.
pub fn report(
    gpu: &Gpu,
    cases: &[Case],
    (plain, relief): (&Case, &Relief),
    (effort, compared): (Effort, Option<[usize; 2]>),
    watch: Watch<'_>,
) -> Result<Report, Problem> {
    let mut sizes = match effort {
        Effort::Full => {
            Sizes { compared: [192, 144], samples: [64, 24], shortcuts: [640, 360], frame: [1920, 1080] }
        }
        Effort::Quick => {
            Sizes { compared: [48, 36], samples: [16, 16], shortcuts: [96, 54], frame: [96, 54] }
        }
    };
    sizes.compared = compared.unwrap_or(sizes.compared);
    // The first truth is without.
    let options = Options { occlusion_slices: 0, ..Options::of(gpu) };
    let [width, height] = sizes.compared;
    let mut page = Page::new("The preview: how wrong its pictures are, and what they take");
    page.prose(format!(
        "Pictures of the preview on {} against the path tracer's, at {width} x {height} pixels and {} samples per pixel of \
         it by direct and {} by all light, whose noise is in all numbers. The first truth is light straight from its source \
         in red, green and blue, which is what the preview draws; the second is all light, wavelength by wavelength. RMSE is \
         of linear light after exposure and tone curve; CIEDE2000 of 1 is about what an eye can tell; FLIP is in [0, 1]. \
         Those of *inner* pixels are without silhouettes, where a pixel sees two surfaces. Milliseconds are of one frame, after a first one, with the way back to memory.",
        gpu.info.name, sizes.samples[0], sizes.samples[1]
    ));

    let mut table = Table::new("scenes", "Scenes and skins", &ERRORS);
    let mut strips = Vec::new();
    let mut summary = format!("{}\n", gpu.info.name);
    let mut first = None;
    for (i, case) in cases.iter().enumerate() {
        watch(0.65 * i as f32 / cases.len() as f32, &format!("{} on {}", case.skin, case.scene.name));
        let drawn = draw(gpu, case, &options, sizes.compared)?;
        let frame = time(gpu, case, &options, sizes.frame)?;
        let tracer = reference::Renderer::new(&case.scene)?;
        let inner = inner(case, &sizes)?;
        let mut strip = vec![("preview".to_owned(), srgb(&drawn))];
        for (name, transport) in [("direct", DIRECT), ("all light", FULL)] {
            let truth = trace(&tracer, case, &sizes, transport);
            let apart = Apart::new(&drawn, &truth, &inner, width)?;
            let mut row = vec![
                Cell::text(&case.skin),
                Cell::text(&case.scene.name),
                Cell::text(name),
                Cell::Fixed(frame, 1),
            ];
            row.extend(apart.cells());
            table.row(row);
            strip.push((name.to_owned(), srgb(&truth)));
            strip.push((format!("{name}: 4 times the difference"), difference(&drawn, &truth)));
            if transport == DIRECT {
                summary += &format!(
                    "{} on {}: dE {:.2}, FLIP {:.3} of direct light, dE {:.2}, FLIP {:.3} without silhouettes, {frame:.1} ms\n",
                    case.skin, case.scene.name, apart.delta_e, apart.flip, apart.inner[0], apart.inner[1]
                );
                first.get_or_insert_with(|| (truth, inner.clone()));
            }
        }
        strips.push(strip);
    }
    page.heading("Scenes and skins");
    let [frame_width, frame_height] = sizes.frame;
    page.prose(format!("Frames are of {frame_width} x {frame_height} pixels."));
    page.table(table);
    let strips = picture::rows(sizes.compared, 180, &strips)?;
    let rows: Vec<String> =
        cases.iter().map(|case| format!("{} on {}", case.skin, case.scene.name)).collect();
    page.figure(
        "pictures",
        strips,
        format!("Preview, direct light and all light, and the differences from them: {}.", rows.join(", ")),
    );

    if let Some((case, (truth, inner))) = cases.first().zip(first) {
        page.heading("Shortcuts");
        page.prose(format!(
            "Each is changed alone, on `{}`, {} on it. What a shortcut costs is the difference of its error from that of the \
             first row, what it saves that of their milliseconds, at {} x {} pixels.",
            case.scene.name, case.skin, sizes.shortcuts[0], sizes.shortcuts[1]
        ));
        page.table(shortcuts::table(gpu, case, (&truth, &inner), &options, &sizes, watch)?);
    }

    if let Some(case) = cases.first() {
        watch(0.79, "occlusion");
        page.heading("What hides the environment");
        page.prose(format!(
            "Ambient occlusion of `{}`, {} on it, against direct light that objects do keep off each other, and against all \
             light. Light that goes from surface to surface is in the last one only.",
            case.scene.name, case.skin
        ));
        page.table(occlusion(gpu, case, &options, &sizes)?);
    }

    if let Some(case) = cases.first() {
        watch(0.792, "environment");
        page.heading("The environment in gloss");
        page.prose(format!(
            "`{}` by its environment alone, the skin even and under a film, by {} samples of each pixel: what gloss shows of the \
             environment, blurred beforehand times what the film reflects of even light (a split sum, 0 directions), and in so \
             many directions of its lobe in each sample, each with what the film reflects of it. The truth has {} times the \
             samples of others.",
            case.scene.name,
            sky::SAMPLES,
            sky::TRUTH
        ));
        page.table(sky::table(gpu, (case, plain), &options, &sizes)?);
    }

    watch(0.795, "relief");
    page.heading("Relief");
    page.prose(format!(
        "The height map {} times as high on `{}`, {} on it, against direct light on a surface that is moved by it: maps looked up \
         on the even surface, where the view meets the relief, compared at so many heights (parallax occlusion mapping), and the \
         moved surface itself, with {} triangles in place of {}.",
        relief.amount,
        relief.flat.scene.name,
        relief.flat.skin,
        triangles(&relief.displaced),
        triangles(&relief.flat)
    ));
    page.table(reliefs(gpu, relief, &options, &sizes)?);

    watch(0.8, "films");
    let (table, figure) = gallery(gpu, plain, &options, &sizes)?;
    page.heading("Films and absorption of the thesis");
    page.table(table);
    page.figure(
        "gallery",
        figure,
        "Film thickness, and optical depth of the layer: preview, path tracer (direct light).",
    );

    watch(0.92, "gratings");
    page.heading("Gratings");
    page.prose(
        "Ridges on the same skin, drawn by so many wavelengths; 0 is without ridges. The path tracer sums over 32, without \
         the tents that the preview has between its own."
            .to_owned(),
    );
    page.table(gratings::table(gpu, plain, &options, &sizes)?);

    watch(0.95, "snakes");
    let mut table =
        Table::new("snakes", "The thesis's table 5.3", &["snakes", "triangles", "ms", "thesis, ms"]);
    for (count, thesis) in SNAKES {
        let case = Case { scene: snakes(&plain.scene, count), ..plain.clone() };
        let triangles = case.scene.objects.iter().map(|o| o.mesh.triangles.len() as u64).sum();
        let ms = time(gpu, &case, &Options { samples: 1, ..options }, sizes.frame)?;
        table.row([
            Cell::Count(count as u64),
            Cell::Count(triangles),
            Cell::Fixed(ms, 2),
            Cell::Fixed(thesis, 2),
        ]);
    }
    page.heading("Many snakes");
    page.prose(format!(
        "One sample of each pixel on {}, {frame_width} x {frame_height} pixels, with the way back to memory. The thesis \
         measured in Unity, on another machine, and only the pass itself.",
        gpu.info.name
    ));
    page.table(table);
    watch(1.0, "");
    Ok(Report { page, name: "preview", summary, failures: Vec::new() })
}

/// Columns of [`Apart::cells`] after what is compared.
const ERRORS: [&str; 12] = [
    "skin",
    "scene",
    "truth",
    "ms",
    "RMSE",
    "FLIP",
    "dE mean",
    "dE 50%",
    "dE 95%",
    "dE 99%",
    "FLIP inner",
    "dE inner",
];

/// How far a picture is from the true one.
struct Apart {
    rmse: f64,
    flip: f64,
    delta_e: f64,
    quantiles: [f64; 3],
    /// CIEDE2000 and FLIP of inner pixels, means.
    inner: [f64; 2],
}

impl Apart {
    fn new(
        picture: &[[f32; 3]],
        truth: &[[f32; 3]],
        inner: &[bool],
        width: usize,
    ) -> Result<Self, FlipError> {
        let mut errors = ColorErrors::default();
        let mut inner_errors = ColorErrors::default();
        for ((a, b), inner) in picture.iter().zip(truth).zip(inner) {
            let (a, b) = (a.map(f64::from), b.map(f64::from));
            errors.add(a, b);
            if *inner {
                inner_errors.add(a, b);
            }
        }
        let seen = flip(truth, picture, width, PIXELS_PER_DEGREE)?;
        // Silhouettes are the truth's in both, so that no difference of theirs is seen around them.
        let pairs = picture.iter().zip(truth).zip(inner);
        let within: Vec<_> = pairs.map(|((a, b), inner)| if *inner { *a } else { *b }).collect();
        let seen_within = flip(truth, &within, width, PIXELS_PER_DEGREE)?;
        let kept = seen_within.iter().zip(inner).filter(|(_, inner)| **inner);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, n), (v, _)| (sum + f64::from(*v), n + 1.0));
        Ok(Self {
            rmse: errors.rmse(),
            flip: seen.iter().map(|v| f64::from(*v)).sum::<f64>() / seen.len() as f64,
            delta_e: errors.delta_e_mean(),
            quantiles: [0.5, 0.95, 0.99].map(|share| errors.delta_e_quantile(share)),
            inner: [inner_errors.delta_e_mean(), sum / f64::max(count, 1.0)],
        })
    }

    fn cells(&self) -> [Cell; 8] {
        let [half, most, nearly_all] = self.quantiles.map(|q| Cell::Fixed(q, 2));
        let (rmse, flip) = (Cell::Scientific(self.rmse, 2), Cell::Fixed(self.flip, 4));
        let [delta_e, inner_flip] = [Cell::Fixed(self.inner[0], 3), Cell::Fixed(self.inner[1], 4)];
        [rmse, flip, Cell::Fixed(self.delta_e, 3), half, most, nearly_all, inner_flip, delta_e]
    }
}

/// Pixels that see one surface. Normal maps lean everywhere, so that they are left out.
fn inner(case: &Case, sizes: &Sizes) -> Result<Vec<bool>, RenderError> {
    const SAMPLES: u32 = 32;
    // Normals of one surface in a pixel are as one.
    const LEAST_LENGTH: f32 = 0.98;
    let mut scene = case.scene.clone();
    scene.materials.iter_mut().for_each(|material| material.maps = None);
    let [width, height] = sizes.compared;
    let settings = Settings { width, height, samples: SAMPLES, transport: DIRECT, ..Settings::default() };
    let film = reference::Renderer::new(&scene)?.render(&settings, Control::default());
    let length = |p: &reference::Pixel| Vec3::from(p.normal).length() / p.count.max(1) as f32;
    // What meets nothing has no normal, and is one, too.
    Ok(film.pixels.iter().map(|p| p.hits == 0 || length(p) > LEAST_LENGTH).collect())
}

/// As a screen shows it, still linear.
fn shown(case: &Case, texels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let gain = num::exp2(case.exposure_ev);
    texels.iter().map(|t| case.tone.map(LinearRgb(t.map(|c| c * gain))).0).collect()
}

fn srgb(picture: &[[f32; 3]]) -> Vec<Srgb8> {
    picture.iter().map(|t| Srgb8::from(LinearRgb(*t))).collect()
}

/// On grey.
fn difference(picture: &[[f32; 3]], truth: &[[f32; 3]]) -> Vec<Srgb8> {
    let pairs = picture.iter().zip(truth);
    pairs.map(|(a, b)| Srgb8::from(LinearRgb([0, 1, 2].map(|c| 0.2 + 4.0 * (a[c] - b[c]))))).collect()
}

fn draw(gpu: &Gpu, case: &Case, options: &Options, size: [usize; 2]) -> Result<Vec<[f32; 3]>, PreviewError> {
    Ok(shown(case, &linear(gpu, case, options, size)?))
}

fn linear(
    gpu: &Gpu,
    case: &Case,
    options: &Options,
    size: [usize; 2],
) -> Result<Vec<[f32; 3]>, PreviewError> {
    Ok(Renderer::new(gpu, &case.scene, options)?.render(&case.scene.camera, size)?.texels)
}

/// Milliseconds of the second picture.
fn time(gpu: &Gpu, case: &Case, options: &Options, size: [usize; 2]) -> Result<f64, PreviewError> {
    let mut renderer = Renderer::new(gpu, &case.scene, options)?;
    renderer.render(&case.scene.camera, size)?;
    let start = Instant::now();
    renderer.render(&case.scene.camera, size)?;
    Ok(1e3 * start.elapsed().as_secs_f64())
}

fn trace(
    tracer: &reference::Renderer<'_>,
    case: &Case,
    sizes: &Sizes,
    transport: Transport,
) -> Vec<[f32; 3]> {
    let [width, height] = sizes.compared;
    let samples = sizes.samples[usize::from(transport == FULL)];
    let settings = Settings { width, height, samples, transport, ..Settings::default() };
    shown(case, &tracer.render(&settings, Control::default()).rgb())
}

/// Occlusion in the picture against that of the scene.
fn occlusion(gpu: &Gpu, case: &Case, options: &Options, sizes: &Sizes) -> Result<Table, Problem> {
    let columns: Vec<&str> = ["planes"].iter().chain(&ERRORS[2..]).copied().collect();
    let inner = inner(case, sizes)?;
    let mut table = Table::new("occlusion", "Ambient occlusion", &columns);
    let tracer = reference::Renderer::new(&case.scene)?;
    let truths = [("direct, hidden", Transport::Direct { environment_shadows: true }), ("all light", FULL)]
        .map(|(name, transport)| (name, trace(&tracer, case, sizes, transport)));
    for occlusion_slices in [0, 1, Options::SLICES, 4] {
        let options = Options { occlusion_slices, ..*options };
        let drawn = draw(gpu, case, &options, sizes.compared)?;
        let ms = time(gpu, case, &options, sizes.shortcuts)?;
        for (name, truth) in &truths {
            let apart = Apart::new(&drawn, truth, &inner, sizes.compared[0])?;
            let row = [Cell::Count(occlusion_slices.into()), Cell::text(name), Cell::Fixed(ms, 1)];
            table.row(row.into_iter().chain(apart.cells()));
        }
    }
    Ok(table)
}

/// Relief by parallax and by displacement.
fn reliefs(gpu: &Gpu, relief: &Relief, options: &Options, sizes: &Sizes) -> Result<Table, Problem> {
    let Relief { amount, flat, displaced } = relief;
    let columns: Vec<&str> = ["relief"].iter().chain(&ERRORS[3..]).copied().collect();
    let mut table = Table::new("relief", "Relief by parallax", &columns);
    let inner = inner(displaced, sizes)?;
    let truth = trace(&reference::Renderer::new(&displaced.scene)?, displaced, sizes, DIRECT);
    let parallax = |parallax_steps| Options { parallax: *amount, parallax_steps, ..*options };
    for (name, case, options) in [
        ("none", flat, *options),
        ("parallax, 4 heights", flat, parallax(4)),
        ("parallax, 8 heights", flat, parallax(8)),
        ("parallax, 16 heights", flat, parallax(16)),
        ("parallax, 64 heights", flat, parallax(64)),
        ("displacement", displaced, *options),
    ] {
        let apart =
            Apart::new(&draw(gpu, case, &options, sizes.compared)?, &truth, &inner, sizes.compared[0])?;
        let ms = time(gpu, case, &options, sizes.shortcuts)?;
        table.row([Cell::text(name), Cell::Fixed(ms, 1)].into_iter().chain(apart.cells()));
    }
    Ok(table)
}

fn triangles(case: &Case) -> usize {
    case.scene.objects.first().map_or(0, |object| object.mesh.triangles.len())
}

/// The thesis's films and absorptions, also with fewer terms of the film's series.
fn gallery(gpu: &Gpu, plain: &Case, options: &Options, sizes: &Sizes) -> Result<(Table, String), Problem> {
    let columns: Vec<&str> =
        ["film, nm", "absorption", "terms"].iter().chain(&ERRORS[4..]).copied().collect();
    let inner = inner(plain, sizes)?;
    let mut table = Table::new("films", "Films and absorption against direct light", &columns);
    let usual = THICKNESSES_NM[1];
    let films = THICKNESSES_NM.map(|thickness_nm| (thickness_nm, 0.0));
    let absorbing = ABSORPTIONS.map(|absorption| (usual, absorption));
    let mut strips = Vec::new();
    for (thickness_nm, absorption) in films.into_iter().chain(absorbing) {
        let mut case = plain.clone();
        for material in &mut case.scene.materials {
            material.thickness_nm = thickness_nm;
            material.constants.absorption = [absorption; 3];
        }
        let truth = trace(&reference::Renderer::new(&case.scene)?, &case, sizes, DIRECT);
        for film_order in [3, 2, 1] {
            let skin = SkinOptions { film_order, ..options.skin };
            let drawn = draw(gpu, &case, &Options { skin, ..*options }, sizes.compared)?;
            let apart = Apart::new(&drawn, &truth, &inner, sizes.compared[0])?;
            let (film, depth) =
                (Cell::Fixed(f64::from(thickness_nm), 0), Cell::Fixed(f64::from(absorption), 1));
            table.row([film, depth, Cell::Count(film_order.into())].into_iter().chain(apart.cells()));
            if film_order == 3 {
                let words = format!("{thickness_nm} nm, {absorption}");
                strips.push((words, srgb(&drawn)));
                strips.push(("path tracer".to_owned(), srgb(&truth)));
            }
        }
    }
    let strips: Vec<_> = strips.chunks(4).map(<[_]>::to_vec).collect();
    Ok((table, picture::rows(sizes.compared, 220, &strips)?))
}

/// So many of the scene's subject in rows, seen from as far away as there are in a row.
fn snakes(scene: &Scene, count: usize) -> Scene {
    let mut scene = scene.clone();
    if scene.objects.is_empty() {
        return scene;
    }
    let subject = scene.objects.remove(0);
    let [low, high] = subject.mesh.bounds();
    let side = (1..).find(|side| side * side >= count).unwrap_or(1);
    let middle = 0.5 * (side as f32 - 1.0);
    for i in 0..count {
        let mut one = subject.clone();
        let step = 1.1 * (high - low);
        let [x, z] = [(i % side) as f32 - middle, (i / side) as f32 - middle];
        let shift = Vec3::new(step.x * x, 0.0, step.z * z);
        one.mesh.positions.iter_mut().for_each(|p| *p += shift);
        scene.objects.push(one);
    }
    let camera = &mut scene.camera;
    camera.position = camera.target + (camera.position - camera.target) * side.max(1) as f32;
    scene
}
