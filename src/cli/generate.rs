//! `generate`: presets to texture sets.

mod set;

use std::io::Write as _;
use std::path::Path;

use self::set::{Evaluated, Made, Maker, Set};
use super::args::{self, CompressArg, ExrCompressArg, Format, Generate, MapsArg, NormalArg};
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::progress::Progress;
use super::render_scene::folder;
use super::trace::{self, Recorder, Stats};
use super::{memory, render, signal};
use crate::base::watch::Watch;
use crate::base::{Domain, MapKind};
use crate::graph::Graph;
use crate::io::{ExrCompression, Output, PngCompression, WriteOptions};
use crate::plan::{Order, Plan, PlanError, Shelf, Slabs};

/// Make every set. All presets are read, checked and planned before the first file is written.
pub(super) fn run(args: &Generate) -> Result<Exit, Failure> {
    let options = write_options(args)?;
    let budget = memory::budget(args.memory);
    args.trace.as_deref().map_or(Ok(()), folder)?;
    let pool = pool(args.threads)?;
    // Plans count what each thread of the pool works in.
    let jobs = pool.install(|| prepare(args, &options, budget))?;
    let count = args.seeds.as_ref().map_or(1, |s| s.0.end - s.0.start).saturating_mul(jobs.len() as u64);
    let progress = Progress::new(args.quiet);
    let recorder = (args.stats || args.trace.is_some()).then(Recorder::new);
    let watch = recorder.as_ref().map(|recorder| recorder as &dyn Watch);
    let maker = Maker { args, options: &options, stop: signal::stop_flag(), progress: &progress, watch };
    let mut times = Vec::new();
    pool.in_place_scope(|scope| -> Result<(), Failure> {
        let mut sets = sets(args, &jobs).peekable();
        let mut shelf = Shelf::default();
        // The set before, as long as its last maps are encoded.
        let mut last: Option<Evaluated<'_>> = None;
        let mut number = 0;
        while let Some(set) = sets.next() {
            number += 1;
            let name = set.graph.name.clone();
            let planned = || plan_set(&options, set.order(), sets.peek().map(Set::order), &shelf, budget);
            let (plan, slabs, kept) = pool.install(planned)?;
            let fits = |last: &Evaluated<'_>| {
                budget.is_none_or(|budget| last.plan.peak_bytes.saturating_add(plan.peak_bytes) <= budget)
            };
            if let Some(last) = last.take_if(|last| !fits(last)) {
                tell(args, &progress, &last.finish(&pool, maker.stop)?, None)?;
            }
            progress.start(if count > 1 { format!("{number}/{count} {name}") } else { name.clone() });
            let begin = watch.map_or(0, |watch| watch.begin());
            let next = pool.install(|| maker.evaluate(&set, plan, slabs.as_ref(), scope));
            if let Some(last) = last.take() {
                tell(args, &progress, &last.finish(&pool, maker.stop)?, None)?;
            }
            shelf = kept;
            let next = next?;
            let Some(recorder) = &recorder else {
                last = Some(next);
                continue;
            };
            // A set that is timed is made alone.
            let made = next.finish(&pool, maker.stop)?;
            let set = recorder.set(format!("{name} seed {}", set.graph.seed), begin);
            let stats = args.stats.then(|| set.stats(&made.plan, &made.files));
            tell(args, &progress, &made, stats.as_ref())?;
            // Of a long run only a trace wants every piece.
            times.extend(args.trace.is_some().then_some(set));
        }
        last.map_or(Ok(()), |last| tell(args, &progress, &last.finish(&pool, maker.stop)?, None))
    })?;
    if let Some(path) = &args.trace {
        trace::write(path, &times)?;
    }
    Ok(Exit::Done)
}

/// Every set in turn: all presets of one individual, then of the next, since those have more in common.
fn sets<'a>(args: &'a Generate, jobs: &'a [Job]) -> impl Iterator<Item = Set<'a>> {
    let seeds = args.seeds.as_ref().map_or(0..1, |seeds| seeds.0.clone());
    let own = args.seeds.is_none();
    seeds.flat_map(move |seed| {
        jobs.iter().map(move |job| Set::new(args, job, if own { job.graph.seed } else { seed }))
    })
}

/// Report a set that is made.
fn tell(args: &Generate, progress: &Progress, made: &Made, stats: Option<&Stats>) -> Result<(), Failure> {
    if args.json || !args.quiet {
        progress.suspend(|| report(args, made, stats))?;
    }
    Ok(())
}

/// A preset that can be made.
struct Job {
    graph: Graph,
    wanted: Vec<MapKind>,
}

/// Read, check and plan every preset; everything that is wrong is told.
fn prepare(args: &Generate, options: &WriteOptions, budget: Option<u64>) -> Result<Vec<Job>, Failure> {
    let mut jobs: Vec<Job> = Vec::new();
    let mut worst: Option<Failure> = None;
    for word in &args.presets {
        match prepare_one(args, options, word, budget) {
            Ok(job) => {
                if jobs.iter().any(|other| other.graph.name == job.graph.name) {
                    let message =
                        format!("two presets are named `{}`: their files would be the same", job.graph.name);
                    return Err(Failure::usage(
                        message,
                        "give one of them another `name`, or make them apart",
                    ));
                }
                jobs.push(job);
            }
            Err(failure) => {
                render::failure(&failure);
                let exit = failure.exit().max(worst.map_or(Exit::Done, |w| w.exit()));
                worst = Some(Failure::Told(exit));
            }
        }
    }
    worst.map_or(Ok(jobs), Err)
}

fn prepare_one(
    args: &Generate,
    options: &WriteOptions,
    word: &str,
    budget: Option<u64>,
) -> Result<Job, Failure> {
    let preset = Preset::open(word, &args.set.settings)?;
    let mut graph = preset.graph()?;
    if let Some(seed) = args.seed {
        graph = graph.with_seed(seed);
    }
    let wanted: Vec<MapKind> = match &args.maps {
        MapsArg::All => graph.maps.keys().copied().collect(),
        MapsArg::List(list) => list.clone(),
    };
    if wanted.is_empty() {
        let message = format!("{} has no maps", graph.name);
        return Err(Failure::usage(message, "add a section [maps], such as color = \"some_node\""));
    }
    let domain = args.size.domain(graph.girth_mm, graph.length_mm);
    plan_set(options, Order { graph: &graph, wanted: &wanted, domain }, None, &Shelf::default(), budget)?;
    Ok(Job { graph, wanted })
}

/// Plan a set of a series: slab by slab where its planes do not fit and its files can take rows as they come.
fn plan_set(
    options: &WriteOptions,
    order: Order<'_>,
    next: Option<Order<'_>>,
    before: &Shelf,
    budget: Option<u64>,
) -> Result<(Plan, Option<Slabs>, Shelf), Failure> {
    let slabs = options.outputs == [Output::Png].into();
    let again = slabs.then(|| options.png.most_strip_rows(order.domain.width));
    let help = if slabs { SMALLER } else { OTHER_FORMAT };
    Plan::in_series(order, next, before, budget, again)
        .map_err(|error| refused(order.graph, order.domain, error, help))
}

/// Plan, with the refusal as a message.
pub(super) fn plan(
    graph: &Graph,
    wanted: &[MapKind],
    domain: Domain,
    budget: Option<u64>,
) -> Result<Plan, Failure> {
    Plan::new(graph, wanted, domain, budget).map_err(|error| refused(graph, domain, error, SMALLER))
}

/// What helps where nothing else would take less memory.
const SMALLER: &str = "choose a smaller --size or fewer --maps, or allow more by --memory";

/// What helps a set that could be made slab by slab, were all its files PNG.
const OTHER_FORMAT: &str =
    "choose PNG files only, a smaller --size or fewer --maps, or allow more by --memory";

fn refused(graph: &Graph, domain: Domain, error: PlanError, less_memory: &str) -> Failure {
    match error {
        PlanError::Memory { .. } => Failure::Message {
            exit: Exit::Memory,
            message: format!("{} at {} x {}: {error}", graph.name, domain.width, domain.height),
            help: Some(less_memory.into()),
        },
        PlanError::NoSuchMap { .. } => Failure::usage(error, "choose among these by --maps"),
        PlanError::Size { .. } => Failure::usage(error, "choose another --size"),
    }
}

fn write_options(args: &Generate) -> Result<WriteOptions, Failure> {
    let several = args.seeds.as_ref().is_some_and(|s| s.0.end - s.0.start > 1);
    let mut options = WriteOptions {
        outputs: args
            .format
            .iter()
            .map(|format| match format {
                Format::Png => Output::Png,
                Format::Exr => Output::Exr,
                Format::ExrLayers => Output::ExrLayers,
            })
            .collect(),
        names: args::names(args.name.as_deref(), several)?,
        png: match args.compress {
            CompressArg::Fast => PngCompression::Fast,
            CompressArg::Balanced => PngCompression::Balanced,
            CompressArg::Small => PngCompression::Small,
        },
        verify: args.verify,
        ..WriteOptions::default()
    };
    if args.normal == NormalArg::Both && args.name.as_ref().is_some_and(|name| !name.contains("{map}")) {
        let help = "put {map} into it: {preset}_{map}.{ext}";
        return Err(Failure::usage("--name gives both normal maps the same file name", help));
    }
    options.exr.compression = match args.exr_compress {
        ExrCompressArg::Piz => ExrCompression::Piz,
        ExrCompressArg::Zip => ExrCompression::Zip,
        ExrCompressArg::None => ExrCompression::None,
    };
    if let Some(depth) = &args.depth {
        options.encode.depths = depth.0.iter().copied().collect();
    }
    Ok(options)
}

/// A pool of so many threads, all cores unless set.
pub(super) fn pool(threads: Option<u16>) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .build()
        .map_err(|e| Failure::usage(format!("no threads can be started: {e}"), "choose fewer --threads"))
}

fn report(args: &Generate, made: &Made, stats: Option<&Stats>) -> Result<(), Failure> {
    let Made { set, files, .. } = made;
    let bytes: u64 = files.iter().map(|f| f.bytes).sum();
    let (width, height) = (set.domain.width, set.domain.height);
    let mut out = anstream::stdout();
    if args.json {
        let hash: String = set.preset_hash.iter().map(|b| format!("{b:02x}")).collect();
        let mut object = serde_json::json!({
            "preset": set.preset,
            "seed": set.seed,
            "size": [width, height],
            "size_mm": [set.domain.girth_mm, set.domain.length_mm],
            "preset_blake3": hash,
            "directory": directory(&args.output),
            "bytes": bytes,
            "peak_bytes": made.plan.peak_bytes,
            "ms": { "evaluate": made.evaluate_ms, "write": made.write_ms },
            "files": files,
        });
        if let Some(stats) = stats {
            object["stats"] = serde_json::json!(stats);
        }
        writeln!(out, "{object}")?;
        return Ok(());
    }
    writeln!(
        out,
        "{} seed {}: {} files, {width} x {height}, {:.1} MB in {:.2} s, {}",
        set.preset,
        set.seed,
        files.len(),
        bytes as f64 * 1e-6,
        (made.evaluate_ms + made.write_ms) * 1e-3,
        directory(&args.output)
    )?;
    if let Some(stats) = stats {
        writeln!(out, "\n{stats}")?;
    }
    Ok(())
}

fn directory(path: &Path) -> String {
    path.display().to_string()
}
