//! `generate`: presets to texture sets.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::args::{self, CompressArg, ExrCompressArg, Format, Generate, MapsArg, NormalArg};
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::progress::Progress;
use super::{memory, render, signal};
use crate::base::{Domain, MapKind};
use crate::eval::{self, Control};
use crate::graph::{self, Graph};
use crate::io::{ExrCompression, ManifestEntry, Output, PngCompression, SetWriter, Staged, WriteOptions};
use crate::maps::{MapImage, NormalFormat, SetId, assemble};
use crate::plan::{Plan, PlanError};

/// Make every set. All presets are read, checked and planned before the first file is written.
pub(super) fn run(args: &Generate) -> Result<Exit, Failure> {
    let options = write_options(args)?;
    let budget = memory::budget(args.memory);
    let jobs = prepare(args, budget)?;
    let count = args.seeds.as_ref().map_or(1, |s| s.0.end - s.0.start).saturating_mul(jobs.len() as u64);
    let pool = pool(args.threads)?;
    let stop = signal::stop_flag();
    let progress = Progress::new(args.quiet);
    let mut number = 0;
    for job in &jobs {
        let seeds = match &args.seeds {
            Some(seeds) => seeds.0.clone(),
            None => job.graph.seed..job.graph.seed.saturating_add(1),
        };
        let work = Work { args, options: &options, wanted: &job.wanted, budget, stop, progress: &progress };
        for seed in seeds {
            number += 1;
            let graph = job.graph.clone().with_seed(seed);
            let name = &graph.name;
            progress.start(if count > 1 { format!("{number}/{count} {name}") } else { name.clone() });
            let made = pool.install(|| work.set(&graph))?;
            if args.json || !args.quiet {
                progress.suspend(|| report(args, &made))?;
            }
        }
    }
    Ok(Exit::Done)
}

/// A preset that can be made.
struct Job {
    graph: Graph,
    wanted: Vec<MapKind>,
}

/// Read, check and plan every preset; everything that is wrong is told.
fn prepare(args: &Generate, budget: Option<u64>) -> Result<Vec<Job>, Failure> {
    let mut jobs: Vec<Job> = Vec::new();
    let mut worst: Option<Failure> = None;
    for word in &args.presets {
        match prepare_one(args, word, budget) {
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

fn prepare_one(args: &Generate, word: &str, budget: Option<u64>) -> Result<Job, Failure> {
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
    plan(&graph, &wanted, domain, budget)?;
    Ok(Job { graph, wanted })
}

/// Plan, with the refusal as a message.
pub(super) fn plan(
    graph: &Graph,
    wanted: &[MapKind],
    domain: Domain,
    budget: Option<u64>,
) -> Result<Plan, Failure> {
    Plan::new(graph, wanted, domain, budget).map_err(|error| match error {
        PlanError::Memory { .. } => Failure::Message {
            exit: Exit::Memory,
            message: format!("{} at {} x {}: {error}", graph.name, domain.width, domain.height),
            help: Some("choose a smaller --size or fewer --maps, or allow more by --memory".into()),
        },
        PlanError::NoSuchMap { .. } => Failure::usage(error, "choose among these by --maps"),
        PlanError::Size { .. } => Failure::usage(error, "choose another --size"),
    })
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
struct Work<'a> {
    args: &'a Generate,
    options: &'a WriteOptions,
    wanted: &'a [MapKind],
    budget: Option<u64>,
    stop: &'a AtomicBool,
    progress: &'a Progress,
}

/// A set that is written.
struct Made {
    set: SetId,
    files: Vec<ManifestEntry>,
    peak_bytes: u64,
    evaluate_ms: f64,
    write_ms: f64,
}

impl Work<'_> {
    fn set(&self, graph: &Graph) -> Result<Made, Failure> {
        let domain = self.args.size.domain(graph.girth_mm, graph.length_mm);
        let plan = plan(graph, self.wanted, domain, self.budget)?;
        let id = SetId {
            domain,
            preset: graph.name.clone(),
            seed: graph.seed,
            preset_hash: graph::preset_hash(graph),
            optics: graph.optics,
        };
        // Names and directory are refused before the work is done.
        let writer =
            SetWriter::new(&self.args.output, id.clone(), self.wanted.iter().copied(), self.options)?;
        let start = Instant::now();
        let show = |share: f32, step: &str| self.progress.evaluated(share, step);
        let control = Control { cancel: Some(self.stop), progress: Some(&show) };
        let evaluation = eval::run(&plan, control).map_err(|_| interrupted())?;
        let peak_bytes = plan.peak_bytes;
        let evaluate_ms = ms(start);
        let start = Instant::now();
        let set = assemble(evaluation, id.clone());
        let files = self.write(writer, set.maps)?;
        Ok(Made { set: id, files, peak_bytes, evaluate_ms, write_ms: ms(start) })
    }

    /// Integers hold the map's range only: tell what lies outside of it.
    fn warn_of_clipping(&self, map: &MapImage, [least, most]: [f32; 2]) {
        let [low, high] = map.range;
        // Filters ring and rounding is rounding: a step of 8 bits is nothing to tell.
        let slack = (high - low) / 256.0;
        if map.kind != MapKind::ScaleId && (least < low - slack || most > high + slack) {
            let kind = map.kind;
            let unit = if kind.unit().is_empty() { String::new() } else { format!(" {}", kind.unit()) };
            let message = format!(
                "{kind} goes from {least:.4} to {most:.4}{unit}, beyond its range {low} to {high}{unit}: it is cut off"
            );
            let help = format!("set [maps] {kind} = {{ from = \"…\", range = [low, high] }}");
            self.progress.suspend(|| render::warning(&message, &help));
        }
    }

    fn write(
        &self,
        writer: SetWriter<'_>,
        maps: BTreeMap<MapKind, MapImage>,
    ) -> Result<Vec<ManifestEntry>, Failure> {
        let images = with_normals(maps.into_values(), self.args.normal);
        let count = images.len() * self.options.outputs.len();
        let staged: Vec<Result<Vec<Staged>, Failure>> = images
            .par_iter()
            .with_max_len(1)
            .map(|map| {
                if self.stop.load(Ordering::Relaxed) {
                    return Err(interrupted());
                }
                let staged = writer.write_map(map)?;
                for file in &staged {
                    self.progress.written(&file.entry().file, count);
                }
                Ok(staged)
            })
            .collect();
        let mut files = Vec::new();
        let mut told = None;
        for (map, staged) in images.iter().zip(staged) {
            let staged = staged?;
            let extremes = staged.iter().find_map(Staged::extremes);
            // Both normals say the same.
            if let Some(extremes) = extremes.filter(|_| told != Some(map.kind)) {
                told = Some(map.kind);
                self.warn_of_clipping(map, extremes);
            }
            files.extend(staged);
        }
        // Layers have one normal map: the first.
        let mut layers: Vec<&MapImage> = images.iter().collect();
        layers.dedup_by_key(|map| map.kind);
        files.extend(writer.write_layers(&layers)?);
        if self.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        Ok(writer.finish(files)?)
    }
}

/// The maps to write: normals as asked for.
fn with_normals(maps: impl Iterator<Item = MapImage>, normal: NormalArg) -> Vec<MapImage> {
    let mut images = Vec::new();
    for map in maps {
        match normal {
            _ if map.kind != MapKind::Normal => images.push(map),
            NormalArg::Gl => images.push(map),
            NormalArg::Dx => images.push(map.to_normal_format(NormalFormat::Dx)),
            NormalArg::Both => {
                images.push(map.clone());
                images.push(map.to_normal_format(NormalFormat::Dx));
            }
        }
    }
    images
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

fn report(args: &Generate, made: &Made) -> Result<(), Failure> {
    let Made { set, files, .. } = made;
    let bytes: u64 = files.iter().map(|f| f.bytes).sum();
    let (width, height) = (set.domain.width, set.domain.height);
    let mut out = anstream::stdout();
    if args.json {
        let hash: String = set.preset_hash.iter().map(|b| format!("{b:02x}")).collect();
        let object = serde_json::json!({
            "preset": set.preset,
            "seed": set.seed,
            "size": [width, height],
            "size_mm": [set.domain.girth_mm, set.domain.length_mm],
            "preset_blake3": hash,
            "directory": directory(&args.output),
            "bytes": bytes,
            "peak_bytes": made.peak_bytes,
            "ms": { "evaluate": made.evaluate_ms, "write": made.write_ms },
            "files": files,
        });
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
    Ok(())
}

fn directory(path: &Path) -> String {
    path.display().to_string()
}
