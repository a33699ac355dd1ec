//! One set: evaluated, encoded and written. The next one is evaluated while the last maps of this one are encoded.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use rayon::{Scope, ThreadPool};

use super::Job;
use crate::base::watch::Watch;
use crate::base::{Domain, MapKind};
use crate::cli::args::{Generate, NormalArg};
use crate::cli::exit::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::cli::render;
use crate::eval::{self, Control, MapRows, Stopped};
use crate::graph::Graph;
use crate::io::{IoError, ManifestEntry, MapHead, Output, Parts, SetWriter, Staged, WriteOptions};
use crate::maps::{MapImage, NormalFormat, SetId};
use crate::plan::{Order, Plan, Slabs};

/// A set to make.
pub(super) struct Set<'a> {
    pub(super) graph: Graph,
    pub(super) wanted: &'a [MapKind],
    pub(super) domain: Domain,
}

impl<'a> Set<'a> {
    /// An individual of a preset.
    pub(super) fn new(args: &Generate, job: &'a Job, seed: u64) -> Self {
        let graph = job.graph.clone().with_seed(seed);
        let domain = args.size.domain(graph.girth_mm, graph.length_mm);
        Self { graph, wanted: &job.wanted, domain }
    }

    pub(super) fn order(&self) -> Order<'_> {
        Order { graph: &self.graph, wanted: self.wanted, domain: self.domain }
    }
}

/// What every set of a run shares.
pub(super) struct Maker<'a> {
    pub(super) args: &'a Generate,
    pub(super) options: &'a WriteOptions,
    pub(super) stop: &'a AtomicBool,
    pub(super) progress: &'a Progress,
    pub(super) watch: Option<&'a dyn Watch>,
}

/// A set that is written.
pub(super) struct Made {
    pub(super) set: SetId,
    pub(super) files: Vec<ManifestEntry>,
    pub(super) plan: Plan,
    pub(super) evaluate_ms: f64,
    pub(super) write_ms: f64,
}

/// A set whose maps are evaluated; some of them are still encoded.
pub(super) struct Evaluated<'a> {
    id: SetId,
    pub(super) plan: Plan,
    writer: SetWriter<'a>,
    files: Files,
    start: Instant,
    evaluate_ms: f64,
}

/// The files of a set.
enum Files {
    /// Written.
    Staged(Vec<Staged>),
    /// So many maps are encoded by the pool.
    Encoding(usize, Receiver<Encoded>),
}

/// A map of a set: its kind, and which of its forms.
type Place = (MapKind, usize);

/// A map that is written aside, or why not.
type Encoded = (Place, Result<Done, Failure>);

impl<'a> Maker<'a> {
    /// Evaluate a set, on the pool that this is called on; the threads of `scope` encode its maps.
    pub(super) fn evaluate<'s>(
        &'s self,
        set: &Set<'_>,
        plan: Plan,
        slabs: Option<&Slabs>,
        scope: &Scope<'s>,
    ) -> Result<Evaluated<'a>, Failure> {
        let id = SetId::new(&set.graph, set.domain);
        // Names and directory are refused before the work is done.
        let writer = SetWriter::new(&self.args.output, id.clone(), set.wanted.iter().copied(), self.options)?
            .watched_by(self.watch);
        let both = self.args.normal == NormalArg::Both && set.wanted.contains(&MapKind::Normal);
        let count = (set.wanted.len() + usize::from(both)) * self.options.outputs.len();
        let start = Instant::now();
        let (files, evaluate_ms) = match slabs {
            None => self.whole(&plan, &writer, count, scope)?,
            Some(slabs) => self.slabs(&plan, slabs, &writer, count)?,
        };
        Ok(Evaluated { id, plan, writer, files, start, evaluate_ms })
    }

    /// Every map whole: it is encoded and written while the next one is computed, and its planes are given back then.
    fn whole<'s>(
        &'s self,
        plan: &Plan,
        writer: &SetWriter<'a>,
        count: usize,
        scope: &Scope<'s>,
    ) -> Result<(Files, f64), Failure> {
        let start = Instant::now();
        let show = |share: f32, step: &str| self.progress.evaluated(share, step);
        let control = Control { cancel: Some(self.stop), progress: Some(&show), watch: self.watch };
        let (sender, receiver) = channel();
        let mut maps = 0;
        let ready = |kind, planes| {
            let forms = with_normals(MapImage::of(kind, planes), self.args.normal);
            for (i, image) in forms.into_iter().enumerate() {
                maps += 1;
                let (writer, sender) = (writer.clone(), sender.clone());
                scope.spawn(move |_| self.encode(&writer, (kind, i), image, count, &sender));
            }
        };
        eval::run_each(plan, control, ready).map_err(|_| interrupted())?;
        Ok((Files::Encoding(maps, receiver), ms(start)))
    }

    /// Write a map aside, and tell the set of it.
    fn encode(
        &self,
        writer: &SetWriter<'_>,
        place: Place,
        image: MapImage,
        count: usize,
        to: &Sender<Encoded>,
    ) {
        // Nobody listens any more where the set was given up.
        let _ = to.send((place, self.encoded(writer, place.1, image, count)));
    }

    fn encoded(
        &self,
        writer: &SetWriter<'_>,
        form: usize,
        image: MapImage,
        count: usize,
    ) -> Result<Done, Failure> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let files = writer.write_map(&image)?;
        for file in &files {
            self.progress.written(&file.entry().file, count);
        }
        // Both normals say the same, and layers have one normal map: the first.
        if let (0, Some(extremes)) = (form, files.iter().find_map(Staged::extremes)) {
            self.warn_of_clipping(image.kind, image.range, extremes);
        }
        let layered = form == 0 && self.options.outputs.contains(&Output::ExrLayers);
        Ok(Done { files, image: layered.then_some(image), at: Instant::now() })
    }

    /// All maps together, some hundred rows at a time, straight into their files; what is evaluated and what is written takes
    /// turns, so the time of both is told as one.
    fn slabs(
        &self,
        plan: &Plan,
        slabs: &Slabs,
        writer: &SetWriter<'_>,
        count: usize,
    ) -> Result<(Files, f64), Failure> {
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
            self.progress.written(&file.entry().file, count);
            if let ([map], Some(extremes)) = (&file.entry().maps[..], file.extremes())
                && map.normal_format != Some(NormalFormat::Dx)
            {
                self.warn_of_clipping(map.map, map.range, extremes);
            }
        }
        Ok((Files::Staged(staged), evaluate_ms))
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

/// A map that is written aside.
struct Done {
    files: Vec<Staged>,
    /// Kept where a file of all maps is still to be written.
    image: Option<MapImage>,
    at: Instant,
}

impl Evaluated<'_> {
    /// Wait until every map is encoded, and put the files in their place. Not to be called by a thread of the pool.
    pub(super) fn finish(self, pool: &ThreadPool, stop: &AtomicBool) -> Result<Made, Failure> {
        let Self { id, plan, writer, files, start, evaluate_ms } = self;
        let mut end = Instant::now();
        let staged = match files {
            Files::Staged(staged) => staged,
            Files::Encoding(maps, receiver) => {
                let done: BTreeMap<Place, _> = receiver.into_iter().collect();
                assert_eq!(done.len(), maps, "an encoder has panicked");
                let (mut staged, mut images, mut last) = (Vec::new(), Vec::new(), None);
                // The first error in the order of the maps.
                for done in done.into_values() {
                    let done = done?;
                    staged.extend(done.files);
                    images.extend(done.image);
                    last = last.max(Some(done.at));
                }
                // What was done before anybody asked took no longer.
                end = last.unwrap_or(end);
                if !images.is_empty() {
                    let layers: Vec<&MapImage> = images.iter().collect();
                    staged.extend(pool.install(|| writer.write_layers(&layers))?);
                    end = Instant::now();
                }
                staged
            }
        };
        if stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let files = writer.finish(staged)?;
        let write_ms = (millis(end - start) - evaluate_ms).max(0.0);
        Ok(Made { set: id, files, plan, evaluate_ms, write_ms })
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
    millis(start.elapsed())
}

fn millis(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}
