//! `generate`: presets to texture sets.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::args::{self, CompressArg, ExrCompressArg, Format, Generate, MapsArg, NormalArg};
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::progress::Progress;
use super::render_scene::folder;
use super::trace::{self, Recorder, Stats};
use super::{memory, render, signal};
use crate::base::watch::Watch;
use crate::base::{Domain, MapKind};
use crate::eval::{self, Control, MapRows, Stopped};
use crate::graph::{self, Graph};
use crate::io::{
    ExrCompression, IoError, ManifestEntry, MapHead, Output, Parts, PngCompression, SetWriter, Staged,
    WriteOptions,
};
use crate::maps::{MapImage, NormalFormat, SetId};
use crate::plan::{Plan, PlanError, Slabs};

/// Make every set. All presets are read, checked and planned before the first file is written.
pub(super) fn run(args: &Generate) -> Result<Exit, Failure> {
    let options = write_options(args)?;
    let budget = memory::budget(args.memory);
    args.trace.as_deref().map_or(Ok(()), folder)?;
    let pool = pool(args.threads)?;
    // Plans count what each thread of the pool works in.
    let jobs = pool.install(|| prepare(args, &options, budget))?;
    let count = args.seeds.as_ref().map_or(1, |s| s.0.end - s.0.start).saturating_mul(jobs.len() as u64);
    let stop = signal::stop_flag();
    let progress = Progress::new(args.quiet);
    let recorder = (args.stats || args.trace.is_some()).then(Recorder::new);
    let mut times = Vec::new();
    let mut number = 0;
    for job in &jobs {
        let seeds = match &args.seeds {
            Some(seeds) => seeds.0.clone(),
            None => job.graph.seed..job.graph.seed.saturating_add(1),
        };
        let watch = recorder.as_ref().map(|recorder| recorder as &dyn Watch);
        let shared =
            Shared { args, options: &options, wanted: &job.wanted, budget, stop, progress: &progress, watch };
        for seed in seeds {
            number += 1;
            let graph = job.graph.clone().with_seed(seed);
            let name = &graph.name;
            progress.start(if count > 1 { format!("{number}/{count} {name}") } else { name.clone() });
            let begin = watch.map_or(0, |watch| watch.begin());
            let made = pool.install(|| shared.set(&graph))?;
            let set = recorder.as_ref().map(|r| r.set(format!("{name} seed {seed}"), begin));
            let stats = set.as_ref().filter(|_| args.stats).map(|set| set.stats(&made.plan, &made.files));
            // Of a long run only a trace wants every piece.
            times.extend(set.filter(|_| args.trace.is_some()));
            if args.json || !args.quiet {
                progress.suspend(|| report(args, &made, stats.as_ref()))?;
            }
        }
    }
    if let Some(path) = &args.trace {
        trace::write(path, &times)?;
    }
    Ok(Exit::Done)
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
    plan_set(options, &graph, &wanted, domain, budget)?;
    Ok(Job { graph, wanted })
}

/// Plan a set: slab by slab where its planes do not fit and its files can take rows as they come.
fn plan_set(
    options: &WriteOptions,
    graph: &Graph,
    wanted: &[MapKind],
    domain: Domain,
    budget: Option<u64>,
) -> Result<(Plan, Option<Slabs>), Failure> {
    if options.outputs == [Output::Png].into() {
        let again = options.png.most_strip_rows(domain.width);
        return Plan::in_slabs(graph, wanted, domain, budget, again)
            .map_err(|error| refused(graph, domain, error, SMALLER));
    }
    let plan = Plan::new(graph, wanted, domain, budget)
        .map_err(|error| refused(graph, domain, error, OTHER_FORMAT))?;
    Ok((plan, None))
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

/// What every set of a run shares.
struct Shared<'a> {
    args: &'a Generate,
    options: &'a WriteOptions,
    wanted: &'a [MapKind],
    budget: Option<u64>,
    stop: &'a AtomicBool,
    progress: &'a Progress,
    watch: Option<&'a dyn Watch>,
}

/// A set that is written.
struct Made {
    set: SetId,
    files: Vec<ManifestEntry>,
    plan: Plan,
    evaluate_ms: f64,
    write_ms: f64,
}

impl Shared<'_> {
    fn set(&self, graph: &Graph) -> Result<Made, Failure> {
        let domain = self.args.size.domain(graph.girth_mm, graph.length_mm);
        let (plan, slabs) = plan_set(self.options, graph, self.wanted, domain, self.budget)?;
        let id = SetId {
            domain,
            preset: graph.name.clone(),
            seed: graph.seed,
            preset_hash: graph::preset_hash(graph),
            optics: graph.optics,
        };
        // Names and directory are refused before the work is done.
        let writer =
            SetWriter::new(&self.args.output, id.clone(), self.wanted.iter().copied(), self.options)?
                .watched_by(self.watch);
        let start = Instant::now();
        let (staged, evaluate_ms) = match &slabs {
            None => self.whole(&plan, &writer)?,
            Some(slabs) => self.slabs(&plan, slabs, &writer)?,
        };
        if self.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let files = writer.finish(staged)?;
        Ok(Made { set: id, files, plan, evaluate_ms, write_ms: ms(start) - evaluate_ms })
    }

    /// Every map whole: it is encoded and written while the next one is computed, and its planes are given back then.
    fn whole(&self, plan: &Plan, writer: &SetWriter<'_>) -> Result<(Vec<Staged>, f64), Failure> {
        let start = Instant::now();
        let show = |share: f32, step: &str| self.progress.evaluated(share, step);
        let control = Control { cancel: Some(self.stop), progress: Some(&show), watch: self.watch };
        let written = Written { shared: self, writer, count: self.files(), done: Mutex::default() };
        let evaluate_ms = rayon::in_place_scope(|scope| {
            let ready = |kind, planes| {
                for (i, image) in
                    with_normals(MapImage::of(kind, planes), self.args.normal).into_iter().enumerate()
                {
                    let written = &written;
                    scope.spawn(move |_| written.write((kind, i), image));
                }
            };
            eval::run_each(plan, control, ready).map(|()| ms(start)).map_err(|_| interrupted())
        })?;
        Ok((written.finish()?, evaluate_ms))
    }

    /// All maps together, some hundred rows at a time, straight into their files; what is evaluated and what is written takes
    /// turns, so the time of both is told as one.
    fn slabs(
        &self,
        plan: &Plan,
        slabs: &Slabs,
        writer: &SetWriter<'_>,
    ) -> Result<(Vec<Staged>, f64), Failure> {
        let start = Instant::now();
        let show = |share: f32, step: &str| self.progress.evaluated(share, step);
        let control = Control { cancel: Some(self.stop), progress: Some(&show), watch: self.watch };
        let heads: Vec<MapHead> =
            plan.maps.iter().flat_map(|(&kind, map)| self.heads(kind, map.range)).collect();
        let mut parts = Parts::new(writer, &heads, [plan.domain.width, plan.domain.height])?;
        let ready = |maps: &BTreeMap<MapKind, MapRows<'_>>, end: usize| -> Result<_, IoError> {
            let wanted = parts.rows(|kind| maps[&kind].lanes.clone(), end)?;
            // Of two files of one map the one that lags tells what must be kept.
            let mut least = BTreeMap::new();
            for (kind, row) in wanted {
                let kept = least.entry(kind).or_insert(row);
                *kept = row.min(*kept);
            }
            Ok(least)
        };
        eval::run_slabs(plan, slabs, control, ready).map_err(|stopped| match stopped {
            Stopped::Cancelled(_) => interrupted(),
            Stopped::By(error) => Failure::from(error),
        })?;
        let evaluate_ms = ms(start);
        let staged = parts.finish()?;
        for file in &staged {
            self.progress.written(&file.entry().file, self.files());
            if let ([map], Some(extremes)) = (&file.entry().maps[..], file.extremes())
                && map.normal_format != Some(NormalFormat::Dx)
            {
                self.warn_of_clipping(map.map, map.range, extremes);
            }
        }
        Ok((staged, evaluate_ms))
    }

    /// The files of a map: of normals those asked for.
    fn heads(&self, kind: MapKind, range: [f32; 2]) -> Vec<MapHead> {
        let head = |normal_format| MapHead { kind, range, normal_format };
        match self.args.normal {
            _ if kind != MapKind::Normal => vec![head(None)],
            NormalArg::Gl => vec![head(Some(NormalFormat::Gl))],
            NormalArg::Dx => vec![head(Some(NormalFormat::Dx))],
            NormalArg::Both => [NormalFormat::Gl, NormalFormat::Dx].map(|f| head(Some(f))).to_vec(),
        }
    }

    /// Files of a set, but for one of all maps.
    fn files(&self) -> usize {
        let both = self.args.normal == NormalArg::Both && self.wanted.contains(&MapKind::Normal);
        (self.wanted.len() + usize::from(both)) * self.options.outputs.len()
    }

    /// Integers hold the map's range only: tell what lies outside of it.
    fn warn_of_clipping(&self, kind: MapKind, [low, high]: [f32; 2], [least, most]: [f32; 2]) {
        // Filters ring and rounding is rounding: a step of 8 bits is nothing to tell.
        let slack = (high - low) / 256.0;
        if kind != MapKind::ScaleId && (least < low - slack || most > high + slack) {
            let unit = if kind.unit().is_empty() { String::new() } else { format!(" {}", kind.unit()) };
            let message = format!(
                "{kind} goes from {least:.4} to {most:.4}{unit}, beyond its range {low} to {high}{unit}: it is cut off"
            );
            let help = format!("set [maps] {kind} = {{ from = \"…\", range = [low, high] }}");
            self.progress.suspend(|| render::warning(&message, &help));
        }
    }
}

/// A map of a set: its kind, and which of its forms.
type Place = (MapKind, usize);

/// The files of a set, as its maps become ready.
struct Written<'a> {
    shared: &'a Shared<'a>,
    writer: &'a SetWriter<'a>,
    count: usize,
    done: Mutex<BTreeMap<Place, Result<Done, Failure>>>,
}

/// A map that is written aside.
struct Done {
    files: Vec<Staged>,
    /// Kept where a file of all maps is still to be written.
    image: Option<MapImage>,
}

impl Written<'_> {
    fn write(&self, place: Place, image: MapImage) {
        let done = self.write_one(place, image);
        self.done.lock().unwrap_or_else(PoisonError::into_inner).insert(place, done);
    }

    fn write_one(&self, (_, form): Place, image: MapImage) -> Result<Done, Failure> {
        let shared = self.shared;
        if shared.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let files = self.writer.write_map(&image)?;
        for file in &files {
            shared.progress.written(&file.entry().file, self.count);
        }
        // Both normals say the same, and layers have one normal map: the first.
        if let (0, Some(extremes)) = (form, files.iter().find_map(Staged::extremes)) {
            shared.warn_of_clipping(image.kind, image.range, extremes);
        }
        let layered = form == 0 && shared.options.outputs.contains(&Output::ExrLayers);
        Ok(Done { files, image: layered.then_some(image) })
    }

    /// All files, and the one of all maps; the first error in the order of the maps.
    fn finish(self) -> Result<Vec<Staged>, Failure> {
        let (mut files, mut images) = (Vec::new(), Vec::new());
        for done in self.done.into_inner().unwrap_or_else(PoisonError::into_inner).into_values() {
            let done = done?;
            files.extend(done.files);
            images.extend(done.image);
        }
        let layers: Vec<&MapImage> = images.iter().collect();
        files.extend(self.writer.write_layers(&layers)?);
        Ok(files)
    }
}

/// The forms of a map that are written: of normals those asked for.
fn with_normals(map: MapImage, normal: NormalArg) -> Vec<MapImage> {
    match normal {
        _ if map.kind != MapKind::Normal => vec![map],
        NormalArg::Gl => vec![map],
        NormalArg::Dx => vec![map.to_normal_format(NormalFormat::Dx)],
        NormalArg::Both => vec![map.clone(), map.to_normal_format(NormalFormat::Dx)],
    }
}

fn interrupted() -> Failure {
    Failure::Message {
        exit: Exit::Interrupted,
        message: "stopped; the set at work was not written".into(),
        help: None,
    }
}

fn ms(start: Instant) -> f64 {
    (start.elapsed().as_secs_f64() * 1e6).round() / 1e3
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
