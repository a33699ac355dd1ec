//! `preview`: a skin on the subject of a scene, drawn by a graphics adapter, or by the path tracer where there is none.

use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::args::{BackendArg, Preview};
use super::exit::{Exit, Failure};
use super::progress::Progress;
use super::render_scene::{MAP_SIZE, folder, screen, trace, wanted};
use super::stage::{self, Skin, Source};
use super::{generate, render, signal};
use crate::base::MapKind;
use crate::io;
use crate::preview::{Gpu, Options, PreviewError, Renderer, enough_triangles};
use crate::reference::{self, Settings, Stage, Transport};
use crate::scene::{Scene, bloom::bloom, spec::SceneSpec};

/// Most samples per pixel of the path tracer: no more can be seen.
const SAMPLES: u32 = 256;

/// A picture, and who drew it.
struct Drawn {
    texels: Vec<[f32; 3]>,
    /// The adapter's name, or how many samples the path tracer took.
    by: String,
    gpu: bool,
    /// Samples of each pixel; of the path tracer, the most.
    samples: u32,
    passes: Vec<(&'static str, Option<f64>)>,
    /// The same of another frame, which needs less; if it was asked for.
    again: Vec<(&'static str, Option<f64>)>,
    /// Milliseconds of each frame, with the way back to memory.
    frames_ms: Vec<f64>,
    slots: Vec<Vec<&'static str>>,
    resources: Vec<(String, u64)>,
}

/// Draw the picture and write it.
pub(super) fn run(args: &Preview) -> Result<Exit, Failure> {
    if !args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        let message = format!("{}: a preview is written as .png", args.output.display());
        return Err(Failure::usage(message, "for example -o snake.png; `render` writes .exr"));
    }
    folder(&args.output)?;
    stage::refuse_for_sets(
        &args.skin,
        &[
            ("--set", !args.set.settings.is_empty()),
            ("--seed", args.seed.is_some()),
            ("--map-size", args.map_size.is_some()),
        ],
    )?;
    let start = Instant::now();
    let displacement = args.displace.map(|amount| format!("subject.displacement={amount:?}"));
    let over: Vec<String> = args.scene_settings.iter().cloned().chain(displacement).collect();
    let mut text = stage::text(&args.scene, &over)?;
    let render = &text.spec.render;
    let size = args.size.map_or([render.width as usize, render.height as usize], |s| s.0);
    if !over.iter().any(|setting| setting.starts_with("subject.triangles")) {
        // Where the scene's own number is not asked for.
        let subject = &mut text.spec.subject;
        subject.triangles = subject.triangles.min(enough_triangles(size, subject.displacement > 0.0));
    }
    let spec = &text.spec;
    let mesh = args.mesh.as_deref().map(stage::mesh).transpose()?;
    let pool = generate::pool(args.threads)?;
    let progress = Progress::new(args.quiet);
    let stop = signal::stop_flag();
    progress.start("skin".into());
    let map_size = args.map_size.unwrap_or(MAP_SIZE);
    let source = Source { word: &args.skin, settings: &args.set.settings, seed: args.seed, size: map_size };
    let mut maps = wanted(Stage::All, spec);
    if args.parallax.is_some() && !maps.contains(&MapKind::Height) {
        maps.push(MapKind::Height);
    }
    // A driver takes a while to start: meanwhile the maps are made.
    let (gpu, skin) = std::thread::scope(|scope| {
        let gpu = (args.backend != BackendArg::Cpu).then(|| scope.spawn(|| Gpu::new(None)));
        let skin = Skin::load(&source, &maps, stop, &progress, &pool);
        let lost = |_| Err(PreviewError::Lost("the driver's thread ended".into()));
        (gpu.map(|gpu| gpu.join().unwrap_or_else(lost)), skin)
    });
    let skin = skin?;
    progress.start(spec.name.clone());
    let scene = stage::build(&text, &skin, mesh)?;
    let on_gpu = gpu.map(|gpu| gpu.and_then(|gpu| pool.install(|| draw(&gpu, &scene, size, args))));
    let mut drawn = match on_gpu {
        Some(Ok(drawn)) => drawn,
        Some(Err(error)) if args.backend == BackendArg::Gpu => {
            return Err(Failure::usage(error, "--backend auto or cpu draws without a graphics adapter"));
        }
        other => {
            if let Some(Err(error)) = other {
                let told = || writeln!(anstream::stderr(), "{error}: the path tracer draws in its place");
                progress.suspend(told)?;
            }
            let renderer = reference::Renderer::new(&scene)
                .map_err(|e| Failure::usage(e, "see [material] of the scene"))?;
            let settings = Settings {
                width: size[0],
                height: size[1],
                samples: SAMPLES,
                transport: Transport::Direct { environment_shadows: args.occlusion.unwrap_or(false) },
                ..Settings::default()
            };
            let film = trace(&renderer, &settings, Some(args.budget), stop, &progress, &pool);
            Drawn {
                texels: film.rgb(),
                by: format!("{:.1} samples per pixel", film.samples_per_pixel()),
                gpu: false,
                samples: settings.samples,
                passes: Vec::new(),
                again: Vec::new(),
                frames_ms: Vec::new(),
                slots: Vec::new(),
                resources: Vec::new(),
            }
        }
    };
    if spec.render.bloom > 0.0 {
        let start = Instant::now();
        bloom(&mut drawn.texels, size[0], spec.render.bloom);
        drawn.passes.push(("bloom, on the CPU", Some(1e3 * start.elapsed().as_secs_f64())));
    }
    let exposure = spec.render.exposure(&drawn.texels) + args.exposure_ev.unwrap_or(0.0);
    let pixels = pool.install(|| screen(&drawn.texels, args.tone.unwrap_or(spec.render.tone), exposure));
    io::write_picture(&args.output, size, &pixels)?;
    drop(progress);
    let relief = drawn.resources.iter().any(|(name, _)| name == "relief");
    if args.parallax.is_some_and(|amount| amount != 0.0) && !relief {
        let (why, help) = match drawn.gpu {
            true => ("the skin has no relief", "it needs a height map that is not even, and a finite amount"),
            false => ("the path tracer drew it", "--displace moves the surface itself"),
        };
        render::warning(&format!("the picture is without parallax: {why}"), help);
    }
    if args.json || !args.quiet {
        let seconds = start.elapsed().as_secs_f64();
        report(args, &skin, spec, &drawn, Told { size, seconds, exposure, output: &args.output })?;
    }
    Ok(if stop.load(Ordering::Relaxed) { Exit::Interrupted } else { Exit::Done })
}

/// The picture by a graphics adapter.
fn draw(gpu: &Gpu, scene: &Scene, size: [usize; 2], args: &Preview) -> Result<Drawn, PreviewError> {
    let suited = Options::of(gpu);
    let occlusion_slices = match args.occlusion {
        Some(true) => Options::SLICES,
        Some(false) => 0,
        None => suited.occlusion_slices,
    };
    let (samples, parallax) = (args.samples.unwrap_or(suited.samples), args.parallax.unwrap_or(0.0));
    let options = Options { samples, occlusion_slices, parallax, ..suited };
    let mut renderer = Renderer::new(gpu, scene, &options)?;
    let mut frames_ms = Vec::new();
    let mut frame = || {
        let start = Instant::now();
        let picture = renderer.render(&scene.camera, size)?;
        frames_ms.push(1e3 * start.elapsed().as_secs_f64());
        Ok::<_, PreviewError>(picture)
    };
    let picture = frame()?;
    // A window draws many: all but the first have their shadow maps, and a driver that has compiled its shaders.
    let again = if args.explain { frame()?.passes } else { Vec::new() };
    Ok(Drawn {
        texels: picture.texels,
        by: gpu.info.name.clone(),
        gpu: true,
        samples: options.samples,
        passes: picture.passes,
        again,
        frames_ms,
        slots: renderer.slots(),
        resources: renderer.resources(),
    })
}

struct Told<'a> {
    size: [usize; 2],
    seconds: f64,
    exposure: f32,
    output: &'a Path,
}

fn report(
    args: &Preview,
    skin: &Skin,
    spec: &SceneSpec,
    drawn: &Drawn,
    told: Told<'_>,
) -> Result<(), Failure> {
    let backend = if drawn.gpu { "gpu" } else { "cpu" };
    let file = told.output.display().to_string();
    let [width, height] = told.size;
    let mut out = anstream::stdout();
    if args.json {
        let pass = |(name, ms): &(&str, Option<f64>)| serde_json::json!({ "name": name, "milliseconds": ms });
        let resource = |(name, bytes): &(String, u64)| serde_json::json!({ "name": name, "bytes": bytes });
        let mut json = serde_json::json!({
            "scene": spec.name,
            "skin": skin.name,
            "size": told.size,
            "backend": backend,
            "by": drawn.by,
            "seconds": told.seconds,
            "exposure_ev": told.exposure,
            "files": [file],
        });
        if args.explain {
            json["samples"] = drawn.samples.into();
            json["passes"] = drawn.passes.iter().map(pass).collect();
            json["again"] = drawn.again.iter().map(pass).collect();
            json["frames_ms"] = serde_json::json!(drawn.frames_ms);
            json["slots"] = serde_json::json!(drawn.slots);
            json["resources"] = drawn.resources.iter().map(resource).collect();
        }
        writeln!(out, "{json}")?;
        return Ok(());
    }
    writeln!(
        out,
        "{} on {}, {width}x{height}: {backend} ({}), {:.2} s\n{file}",
        skin.name, spec.name, drawn.by, told.seconds
    )?;
    if args.explain {
        explain(&mut out, drawn)?;
    }
    Ok(())
}

fn explain(out: &mut impl std::io::Write, drawn: &Drawn) -> std::io::Result<()> {
    writeln!(out, "samples  {:9}     of each pixel, all of them in the times below", drawn.samples)?;
    for (frame, ms) in ["first", "again"].into_iter().zip(&drawn.frames_ms) {
        writeln!(out, "{frame}    {ms:9.2} ms  the whole frame, with the way back to memory")?;
    }
    for (word, passes) in [("pass ", &drawn.passes), ("again", &drawn.again)] {
        for (name, milliseconds) in passes {
            match milliseconds {
                Some(ms) => writeln!(out, "{word}    {ms:9.2} ms  {name}")?,
                None => writeln!(out, "{word}            ? ms  {name}")?,
            }
        }
    }
    for slots in &drawn.slots {
        writeln!(out, "shader                {}", slots.join(" "))?;
    }
    for (name, bytes) in &drawn.resources {
        writeln!(out, "memory   {:9.2} MB  {name}", *bytes as f64 / 1e6)?;
    }
    Ok(())
}
