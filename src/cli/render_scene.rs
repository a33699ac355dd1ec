//! `render`: a skin on the subject of a scene, by the path tracer.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::args::{Render, SizeArg, StageArg, TransportArg};
use super::exit::{Exit, Failure};
use super::progress::Progress;
use super::stage::{self, Skin, Source};
use super::{generate, signal};
use crate::base::{LinearRgb, MapKind, Srgb8};
use crate::io;
use crate::reference::{Control, Film, Renderer, Settings, Stage, Transport};
use crate::scene::bloom::bloom;
use crate::scene::spec::SceneSpec;
use crate::scene::tone::ToneMap;

/// Of the maps of a preset, where none is given.
pub(super) const MAP_SIZE: SizeArg = SizeArg::Longer(2048);

/// Make the picture and write it, also the unfinished one after Ctrl-C or at the end of the time.
pub(super) fn run(args: &Render) -> Result<Exit, Failure> {
    let files = Files::new(&args.output)?;
    stage::refuse_for_sets(
        &args.skin,
        &[
            ("--set", !args.set.settings.is_empty()),
            ("--seed", args.seed.is_some()),
            ("--map-size", args.map_size.is_some()),
        ],
    )?;
    let displacement = args.displace.map(|amount| format!("subject.displacement={amount:?}"));
    let over: Vec<String> = args.scene_settings.iter().cloned().chain(displacement).collect();
    let text = stage::text(&args.scene, &over)?;
    let spec = &text.spec;
    let settings = settings(args, spec);
    let mesh = args.mesh.as_deref().map(stage::mesh).transpose()?;
    let pool = generate::pool(args.threads)?;
    let progress = Progress::new(args.quiet);
    let stop = signal::stop_flag();
    progress.start("skin".into());
    let size = args.map_size.unwrap_or(MAP_SIZE);
    let source = Source { word: &args.skin, settings: &args.set.settings, seed: args.seed, size };
    let skin = Skin::load(&source, &wanted(settings.stage, spec), stop, &progress, &pool)?;
    progress.start(spec.name.clone());
    let scene = stage::build(&text, &skin, mesh)?;
    let renderer = Renderer::new(&scene).map_err(|e| Failure::usage(e, "see [material] of the scene"))?;

    let start = Instant::now();
    let film = trace(&renderer, &settings, args.budget, stop, &progress, &pool);
    let seconds = start.elapsed().as_secs_f64();
    let mut texels = film.rgb();
    bloom(&mut texels, settings.width, spec.render.bloom);
    let exposure = spec.render.exposure(&texels) + args.exposure_ev.unwrap_or(0.0);
    files.write(&film, &screen(&texels, args.tone.unwrap_or(spec.render.tone), exposure))?;
    drop(progress);
    if args.json || !args.quiet {
        report(
            args,
            &Made { skin: &skin, spec, settings: &settings, film: &film, seconds, exposure },
            &files,
        )?;
    }
    Ok(if stop.load(Ordering::Relaxed) { Exit::Interrupted } else { Exit::Done })
}

/// Trace paths until all samples are there, `budget` seconds are over, or someone wants it to stop.
pub(super) fn trace(
    renderer: &Renderer<'_>,
    settings: &Settings,
    budget: Option<f64>,
    stop: &AtomicBool,
    progress: &Progress,
    pool: &rayon::ThreadPool,
) -> Film {
    let start = Instant::now();
    let limit = budget.map(Duration::from_secs_f64);
    let done = AtomicBool::new(false);
    pool.install(|| {
        let told = |share: f32| {
            // At least a sample of each pixel, so that the picture is whole.
            let whole = share * settings.samples as f32 > 0.999;
            let late = || limit.is_some_and(|limit| start.elapsed() > limit);
            if stop.load(Ordering::Relaxed) || (whole && late()) {
                done.store(true, Ordering::Relaxed);
            }
            progress.share(share, "tracing paths");
        };
        renderer.render(settings, Control { cancel: Some(&done), progress: Some(&told) })
    })
}

/// Linear light as screens show it.
pub(super) fn screen(texels: &[[f32; 3]], tone: ToneMap, exposure_ev: f32) -> Vec<Srgb8> {
    let shown = |c: &[f32; 3]| tone.encode(LinearRgb(*c), exposure_ev).map(|v| (v * 255.0 + 0.5) as u8);
    texels.par_iter().map(|c| Srgb8(shown(c))).collect()
}

fn settings(args: &Render, spec: &SceneSpec) -> Settings {
    let render = &spec.render;
    let (width, height) =
        args.size.map_or((render.width as usize, render.height as usize), |s| (s.0[0], s.0[1]));
    Settings {
        width,
        height,
        samples: args.spp.unwrap_or(render.samples),
        seed: args.noise,
        transport: match args.transport {
            TransportArg::Full => Transport::Full { bounces: args.bounces.unwrap_or(render.bounces) },
            TransportArg::Direct => Transport::Direct { environment_shadows: true },
            TransportArg::DirectOpen => Transport::Direct { environment_shadows: false },
        },
        clamp: args.clamp,
        technique: args.technique.into(),
        sampler: args.sampler.into(),
        stage: match args.stage {
            StageArg::Diffuse => Stage::Diffuse,
            StageArg::Normal => Stage::Normal,
            StageArg::Film => Stage::Film,
            StageArg::All => Stage::All,
        },
    }
}

/// The maps that a stage reads; no other is evaluated.
pub(super) fn wanted(stage: Stage, spec: &SceneSpec) -> Vec<MapKind> {
    use MapKind::{Color, Height, Iridescence, Normal, Roughness};
    let shading: &[MapKind] = match stage {
        Stage::Diffuse => &[Color],
        Stage::Normal => &[Color, Normal],
        Stage::Film => &[Normal, Roughness, Iridescence],
        Stage::All => &[Color, Normal, Roughness, Iridescence],
    };
    let displaced = spec.subject.displacement != 0.0;
    shading.iter().copied().chain(displaced.then_some(Height)).collect()
}

/// Tell now, not after the work, that the folder of a file is not there.
pub(super) fn folder(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        Some(folder) => Err(Failure::Message {
            exit: Exit::File,
            message: format!("{} is not a directory", folder.display()),
            help: Some("make it, or write the file somewhere else".into()),
        }),
        None => Ok(()),
    }
}

/// Where the picture goes.
struct Files {
    exr: Option<PathBuf>,
    png: Option<PathBuf>,
}

impl Files {
    /// An `.exr` has a `.png` beside it, for eyes.
    fn new(path: &Path) -> Result<Self, Failure> {
        folder(path)?;
        let png = path.with_extension("png");
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("exr") => Ok(Self { exr: Some(path.to_owned()), png: Some(png) }),
            Some("png") => Ok(Self { exr: None, png: Some(path.to_owned()) }),
            _ => Err(Failure::usage(
                format!(
                    "{}: a picture is written as .exr (with a .png beside it) or as .png",
                    path.display()
                ),
                "for example -o snake.exr",
            )),
        }
    }

    fn write(&self, film: &Film, pixels: &[Srgb8]) -> Result<(), Failure> {
        let size = [film.width, film.height];
        // Both or neither.
        let mut staged = Vec::new();
        if let Some(path) = &self.exr {
            staged.push(io::stage_channels(path, size, &film.channels())?);
        }
        if let Some(path) = &self.png {
            staged.push(io::stage_picture(path, size, pixels)?);
        }
        Ok(staged.into_iter().try_for_each(io::Aside::commit)?)
    }
}

struct Made<'a> {
    skin: &'a Skin,
    spec: &'a SceneSpec,
    settings: &'a Settings,
    film: &'a Film,
    seconds: f64,
    exposure: f32,
}

fn report(args: &Render, made: &Made<'_>, files: &Files) -> Result<(), Failure> {
    let Made { skin, spec, settings, film, seconds, exposure } = made;
    let samples: f64 = film.pixels.iter().map(|p| f64::from(p.count)).sum();
    let rate = samples / seconds.max(1e-9) / 1e6;
    let noise = film.noise();
    let written: Vec<String> =
        [&files.exr, &files.png].into_iter().flatten().map(|p| p.display().to_string()).collect();
    let mut out = anstream::stdout();
    if args.json {
        let json = serde_json::json!({
            "scene": spec.name,
            "skin": skin.name,
            "size": [film.width, film.height],
            "samples_per_pixel": film.samples_per_pixel(),
            "seconds": seconds,
            "million_samples_per_second": rate,
            "standard_error": noise,
            "exposure_ev": exposure,
            "files": written,
        });
        writeln!(out, "{json}")?;
        return Ok(());
    }
    writeln!(
        out,
        "{} on {}, {}x{}: {:.1} of {} samples per pixel in {seconds:.2} s ({rate:.2} million/s), standard error {noise:.2e}",
        skin.name,
        spec.name,
        film.width,
        film.height,
        film.samples_per_pixel(),
        settings.samples,
    )?;
    for file in written {
        writeln!(out, "{file}")?;
    }
    Ok(())
}
