//! `report`: error against time, as one page and the numbers beside it.

use std::io::Write as _;

use super::args::{Report, ReportKind, SizeArg};
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::progress::Progress;
use super::render_scene::wanted;
use super::stage::{self, Skin, Source};
use super::{generate, signal};
use crate::io;
use crate::reference::Stage;
use crate::report;
use crate::report::optics::{self, Effort};

/// Measure, and write the files.
pub(super) fn run(args: &Report) -> Result<Exit, Failure> {
    // What cannot be written is told before the minutes of work.
    std::fs::create_dir_all(&args.output).map_err(|e| Failure::Message {
        exit: Exit::File,
        message: format!("{} cannot be made: {}", args.output.display(), super::load::plain(&e)),
        help: None,
    })?;
    let progress = Progress::new(args.quiet || args.json);
    progress.start("report".into());
    let mut watch = |share: f32, step: &str| progress.evaluated(share, step);
    let effort = if args.quick { Effort::Quick } else { Effort::Full };
    let report = match args.kind {
        ReportKind::Optics => optics::report(effort, &mut watch),
        ReportKind::Convergence => convergence(args, effort, &progress, &mut watch)?,
        ReportKind::Textures => textures(args, &mut watch)?,
        #[cfg(feature = "preview")]
        ReportKind::Preview => preview(args, effort, &progress, &mut watch)?,
    };
    let files = report.files();
    files.iter().try_for_each(|(name, text)| io::write_text(&args.output.join(name), text))?;
    drop(progress);
    let mut out = anstream::stdout();
    if args.json {
        writeln!(out, "{}", report.json())?;
    } else if !args.quiet {
        write!(out, "{}", report.summary)?;
        writeln!(out, "{}", args.output.join(&files[0].0).display())?;
    }
    Ok(if report.failures.is_empty() { Exit::Done } else { Exit::Differs })
}

/// The path tracer on the scene that was asked for.
fn convergence(
    args: &Report,
    effort: Effort,
    progress: &Progress,
    watch: report::Watch<'_>,
) -> Result<report::Report, Failure> {
    let text = stage::text(args.subject.as_deref().unwrap_or("studio"), &[])?;
    let source = Source { word: &args.skin, settings: &[], seed: None, size: SizeArg::Longer(1024) };
    let pool = generate::pool(None)?;
    let skin = Skin::load(&source, &wanted(Stage::All, &text.spec), signal::stop_flag(), progress, &pool)?;
    let scene = stage::build(&text, &skin, None)?;
    report::convergence::report(&scene, effort, watch)
        .map_err(|e| Failure::usage(e, "see `ophidian schema --scene` for what a scene says"))
}

/// The maps of the preset that was asked for.
fn textures(args: &Report, watch: report::Watch<'_>) -> Result<report::Report, Failure> {
    let word = args.subject.as_deref().unwrap_or("lampropeltis_triangulum");
    let graph = Preset::open(word, &[])?.graph()?;
    let (longer, rounds) = if args.quick { (256, 2) } else { (1024, 5) };
    let size = args.size.unwrap_or(SizeArg::Longer(longer));
    let domain = size.domain(graph.girth_mm, graph.length_mm);
    // Times are of one thread.
    generate::pool(Some(1))?
        .install(|| report::textures::report(&graph, domain, rounds, watch))
        .map_err(|e| Failure::usage(e, "choose another --size or another preset"))
}

/// Built-in scenes and skins, drawn and traced.
#[cfg(feature = "preview")]
fn preview(
    args: &Report,
    effort: Effort,
    progress: &Progress,
    watch: report::Watch<'_>,
) -> Result<report::Report, Failure> {
    use crate::base::MapKind;
    use crate::preview::Gpu;
    use crate::report::preview::{Case, Relief, report};
    use crate::scene::builtin::BUILTIN;

    const SKIN: &str = "lampropeltis_triangulum";
    /// Times the height map.
    const RELIEF: f32 = 2.0;
    let gpu = Gpu::new(None).map_err(|e| Failure::usage(e, "this report needs a graphics adapter"))?;
    let quick = effort == Effort::Quick;
    let (texels, triangles) = if quick { (128, 2000) } else { (1024, 40_000) };
    let triangles = format!("subject.triangles={triangles}");
    let pool = generate::pool(None)?;
    let skin = |word: &str, spec: &crate::scene::SceneSpec| {
        let source = Source { word, settings: &[], seed: None, size: SizeArg::Longer(texels) };
        let maps = [wanted(Stage::All, spec), vec![MapKind::Height]].concat();
        Skin::load(&source, &maps, signal::stop_flag(), progress, &pool)
    };
    let case = |scene: &str, over: &[String], skin: &Skin| -> Result<Case, Failure> {
        let over: Vec<String> = over.iter().chain([&triangles]).cloned().collect();
        let text = stage::text(scene, &over)?;
        let (render, scene) = (&text.spec.render, stage::build(&text, skin, None)?);
        Ok(Case { skin: skin.name.clone(), scene, exposure_ev: render.exposure(&[]), tone: render.tone })
    };
    let coil = stage::text("coil", &[])?.spec;
    let first = skin(SKIN, &coil)?;
    let mut cases = vec![case("coil", &[], &first)?];
    if !quick {
        for word in ["epicrates_cenchria", "xenopeltis_unicolor", "bitis_gabonica"] {
            cases.push(case("coil", &[], &skin(word, &coil)?)?);
        }
        for (scene, _) in BUILTIN.iter().filter(|(scene, _)| *scene != "coil") {
            cases.push(case(scene, &[], &first)?);
        }
    }
    // Once with its relief as triangles.
    let relief = Relief {
        amount: RELIEF,
        flat: case("macro", &[], &first)?,
        displaced: case("macro", &[format!("subject.displacement={RELIEF:?}")], &first)?,
    };
    let mut plain = case("thesis", &[], &first)?;
    plain.scene.materials.iter_mut().for_each(|material| material.maps = None);
    let size = args.size.map(|size| match size {
        SizeArg::Longer(n) => [n, (3 * n / 4).max(1)],
        SizeArg::Exact(width, height) => [width, height],
    });
    pool.install(|| report(&gpu, &cases, (&plain, &relief), (effort, size), watch))
        .map_err(|e| Failure::usage(e, "see `ophidian preview --explain` for what the adapter holds"))
}
