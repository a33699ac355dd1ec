//! Running a plan: bands of rows in parallel, planes from a pool.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;
use smallvec::SmallVec;

use super::slabs::{Window, cuts};
use crate::base::kept::Kept;
use crate::base::watch::{Watch, Watched, Work};
use crate::base::{MapKind, Plane, Rows};
use crate::node::{Cx, Inputs, Outputs, Prepared};
use crate::plan::{Home, LaneSource, Plan, Stage, Step};

/// A map's planes: one, or three for colours and vectors.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlanes {
    /// The channels.
    pub planes: Vec<Plane>,
    /// Physical values that integer files map to 0 and 1.
    pub range: [f32; 2],
}

/// What [`run`] hands out.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The wanted maps.
    pub maps: BTreeMap<MapKind, MapPlanes>,
}

/// The caller asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Told how far a plan is, from any thread.
pub type OnProgress<'a> = &'a (dyn Fn(f32, &str) + Sync);

/// What a caller can say while a plan runs.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Set it to stop at the next band.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with the share of the planned cost that is done, in [0, 1], and the name of a step at work.
    pub progress: Option<OnProgress<'a>>,
    /// Told of every piece of work.
    pub watch: Option<&'a dyn Watch>,
}

impl Control<'_> {
    fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }
}

/// Run a plan on the current rayon pool. The bytes do not depend on the number of threads.
///
/// # Errors
/// [`Cancelled`] if the caller's flag was set.
pub fn run(plan: &Plan, control: Control<'_>) -> Result<Evaluation, Cancelled> {
    let mut maps = BTreeMap::new();
    run_each(plan, control, |kind, planes| drop(maps.insert(kind, planes)))?;
    Ok(Evaluation { maps })
}

/// As [`run`], handing each map out as soon as nothing reads its planes any more: while it is encoded and written, the
/// next is computed. `ready` is called by the calling thread, between stages.
///
/// # Errors
/// [`Cancelled`] if the caller's flag was set.
pub fn run_each(
    plan: &Plan,
    control: Control<'_>,
    mut ready: impl FnMut(MapKind, MapPlanes),
) -> Result<(), Cancelled> {
    let mut runner = Runner::new(plan, control);
    let of_stage = handed_out(plan);
    for (stage, kinds) in plan.stages.iter().zip(&of_stage) {
        runner.stage(stage)?;
        for &kind in kinds {
            ready(kind, runner.hand_out(kind));
        }
    }
    // Maps that are one number took no stage.
    for &kind in plan.maps.keys().filter(|kind| !of_stage.iter().flatten().any(|k| k == *kind)) {
        ready(kind, runner.hand_out(kind));
    }
    Ok(())
}

/// The maps whose lanes are all written, and read by no later stage, after each stage.
fn handed_out(plan: &Plan) -> Vec<Vec<MapKind>> {
    let mut last_use = vec![0; plan.homes.len()];
    for (k, stage) in plan.stages.iter().enumerate() {
        for pass in stage.whole.iter().chain(&stage.rows).flat_map(|&s| &plan.steps[s].passes) {
            let read = pass.inputs.iter().filter_map(LaneSource::lane);
            for lane in read.chain(pass.outputs.iter().flatten().copied()) {
                last_use[lane] = k;
            }
        }
    }
    let mut of_stage = vec![Vec::new(); plan.stages.len()];
    for (&kind, map) in &plan.maps {
        if let Some(k) = map.lanes.iter().filter_map(LaneSource::lane).map(|lane| last_use[lane]).max() {
            of_stage[k].push(kind);
        }
    }
    of_stage
}

/// Rows that an output is written to, out of the list that they are kept in.
enum Taken<'a> {
    /// Nobody reads it.
    None,
    Scratch(Vec<f32>),
    Own(&'a mut [f32]),
}

pub(super) struct Runner<'a> {
    pub(super) plan: &'a Plan,
    control: Control<'a>,
    planes: Vec<Option<Plane>>,
    /// Of lanes that are made slab by slab.
    pub(super) windows: Vec<Option<Window>>,
    pool: Vec<Vec<f32>>,
    /// Rows of scratch lanes that bands work in, kept from stage to stage.
    scratch: Kept<Vec<Vec<f32>>>,
    prepared: Vec<Option<Prepared>>,
    /// Maps that are still to show each lane.
    shown_by: BTreeMap<usize, usize>,
    total_cost: f32,
    done_cost: AtomicU64,
}

/// One row of each constant that a stage's steps read.
pub(super) struct ConstantRows {
    rows: BTreeMap<u32, Vec<f32>>,
}

impl ConstantRows {
    fn of<'s>(steps: impl Iterator<Item = &'s Step>, width: usize) -> Self {
        Self::of_sources(steps.flat_map(|s| &s.passes).flat_map(|p| &p.inputs), width)
    }

    pub(super) fn of_sources<'s>(sources: impl Iterator<Item = &'s LaneSource>, width: usize) -> Self {
        let mut rows = BTreeMap::new();
        for source in sources {
            if let LaneSource::Const(v) = source {
                rows.entry(v.to_bits()).or_insert_with(|| vec![*v; width]);
            }
        }
        Self { rows }
    }

    pub(super) fn get(&self, v: f32) -> Rows<'_> {
        Rows::broadcast(&self.rows[&v.to_bits()])
    }
}

impl<'a> Runner<'a> {
    pub(super) fn new(plan: &'a Plan, control: Control<'a>) -> Self {
        let mut shown_by = BTreeMap::new();
        for lane in plan.maps.values().flat_map(|m| &m.lanes).filter_map(LaneSource::lane) {
            *shown_by.entry(lane).or_default() += 1;
        }
        Self {
            plan,
            control,
            shown_by,
            planes: vec![None; plan.homes.len()],
            windows: plan.homes.iter().map(|_| None).collect(),
            pool: Vec::new(),
            scratch: Kept::new(),
            prepared: plan.steps.iter().map(|_| None).collect(),
            total_cost: plan.steps.iter().map(Step::cost_ns).sum::<f32>().max(1e-9),
            done_cost: AtomicU64::new(0),
        }
    }

    /// End, and give the pages back beside the caller, who can go on: so many take milliseconds.
    pub(super) fn end(self) {
        let Self { windows, pool, scratch, .. } = self;
        rayon::spawn(move || drop((windows, pool, scratch)));
    }

    /// A plane whose contents will all be written.
    fn take_plane(&mut self) -> Plane {
        let (w, h) = (self.plan.domain.width, self.plan.domain.height);
        match self.pool.pop() {
            Some(data) => Plane::from_vec(w, h, data),
            None => Plane::filled(w, h, 0.0),
        }
    }

    fn cx<'c>(&'c self, step: usize) -> Cx<'c> {
        let s = &self.plan.steps[step];
        Cx {
            domain: self.plan.domain,
            seed: s.seed,
            assets: &self.plan.assets,
            prepared: self.prepared[step].as_ref(),
        }
    }

    fn report(&self, step: &Step, share: f32) {
        if let Some(progress) = self.control.progress {
            // Hundredths of a picosecond per texel: integers add up in any order.
            let add = (step.cost_ns() * share * 1e5) as u64;
            let done = self.done_cost.fetch_add(add, Ordering::Relaxed) + add;
            progress((done as f32 * 1e-5 / self.total_cost).min(1.0), &step.name);
        }
    }

    /// A piece of work of a step.
    fn node<T>(&self, s: usize, piece: impl FnOnce() -> T) -> T {
        let step = Watched { name: &self.plan.steps[s].name, by: self.control.watch };
        step.piece(Work::Node, piece)
    }

    /// Whether to go on.
    pub(super) fn check(&self) -> Result<(), Cancelled> {
        if self.control.cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Let the nodes of a stage make their tables.
    pub(super) fn prepare(&mut self, stage: &Stage) {
        for &s in stage.whole.iter().chain(&stage.rows) {
            let prepared = self.node(s, || self.plan.steps[s].node.prepare(&self.cx(s)));
            self.prepared[s] = prepared;
        }
    }

    pub(super) fn stage(&mut self, stage: &Stage) -> Result<(), Cancelled> {
        self.check()?;
        self.prepare(stage);
        for &s in &stage.whole {
            self.whole(s);
            self.check()?;
        }
        if !stage.rows.is_empty() {
            self.rows(stage)?;
        }
        for &s in stage.whole.iter().chain(&stage.rows) {
            self.prepared[s] = None;
        }
        for &lane in &stage.frees {
            if let Some(plane) = self.planes[lane].take() {
                self.pool.push(plane.into_vec());
            }
        }
        Ok(())
    }

    fn whole(&mut self, s: usize) {
        let step = &self.plan.steps[s];
        let (width, height) = (self.plan.domain.width, self.plan.domain.height);
        let constants = ConstantRows::of(std::iter::once(step), width);
        for pass in &step.passes {
            let mut outputs: Vec<Option<Plane>> =
                pass.outputs.iter().map(|id| id.map(|_| self.take_plane())).collect();
            let lanes: Vec<Rows<'_>> = pass
                .inputs
                .iter()
                .map(|source| match source {
                    LaneSource::Const(v) => constants.get(*v),
                    LaneSource::Lane(id) => plane(&self.planes, *id).rows(),
                })
                .collect();
            let slices = outputs.iter_mut().map(|p| p.as_mut().map(|p| p.data_mut())).collect();
            let mut outs = Outputs::new(&step.output_offsets, slices, width, 0);
            self.node(s, || {
                let ins = Inputs::new(&step.input_offsets, &lanes);
                step.node.eval(&self.cx(s), 0..height as i64, &ins, &mut outs);
            });
            drop(outs);
            for (id, output) in pass.outputs.iter().zip(outputs) {
                if let Some(id) = id {
                    self.planes[*id] = output;
                }
            }
        }
        self.report(step, 1.0);
    }

    /// Lanes of a stage's rows that are planes.
    pub(super) fn planes_of(&self, stage: &Stage) -> Vec<usize> {
        let steps = stage.rows.iter().map(|&s| &self.plan.steps[s]);
        let lanes = steps.flat_map(|s| &s.passes).flat_map(|p| &p.outputs).filter_map(|id| *id);
        lanes.filter(|&id| self.plan.homes[id] == Home::Plane).collect()
    }

    fn rows(&mut self, stage: &Stage) -> Result<(), Cancelled> {
        let height = self.plan.domain.height;
        let ids = self.planes_of(stage);
        let mut written: Vec<Plane> = ids.iter().map(|_| self.take_plane()).collect();
        let cuts = cuts(0..height as i64, stage.band_rows, height, rayon::current_num_threads());
        self.bands(stage, &ids, &cuts, written.iter_mut().map(Plane::data_mut).collect())?;
        for (id, plane) in ids.into_iter().zip(written) {
            self.planes[id] = Some(plane);
        }
        Ok(())
    }

    /// A stage's row-wise steps over bands, given by their first row and number of rows; `parts` are those rows of the lanes
    /// `ids`, one after another.
    pub(super) fn bands(
        &self,
        stage: &Stage,
        ids: &[usize],
        cuts: &[(usize, usize)],
        parts: Vec<&mut [f32]>,
    ) -> Result<(), Cancelled> {
        let (width, height) = (self.plan.domain.width, self.plan.domain.height);
        let constants = ConstantRows::of(stage.rows.iter().map(|&s| &self.plan.steps[s]), width);
        // Where a lane's band stands in a band's list of slices.
        let mut slot_of = vec![None; self.plan.homes.len()];
        ids.iter().enumerate().for_each(|(i, &id)| slot_of[id] = Some(i));
        let mut by_band: Vec<Vec<&mut [f32]>> = cuts.iter().map(|_| Vec::with_capacity(ids.len())).collect();
        for mut rest in parts {
            for (band, (_, rows)) in by_band.iter_mut().zip(cuts) {
                let (part, after) = std::mem::take(&mut rest).split_at_mut(rows * width);
                band.push(part);
                rest = after;
            }
        }
        // Band by band, or the last to get one would hold a quarter of them while the others wait.
        by_band.into_par_iter().zip(cuts).with_max_len(1).for_each_init(
            || {
                let mut scratch = self.scratch.borrow();
                if scratch.len() < stage.scratch_slots {
                    scratch.resize_with(stage.scratch_slots, Vec::new);
                }
                for slot in &mut scratch[..stage.scratch_slots] {
                    slot.resize(stage.band_rows * width, 0.0);
                }
                scratch
            },
            |scratch, (mut own, &(first, rows))| {
                if self.control.cancelled() {
                    return;
                }
                for &s in &stage.rows {
                    self.band(s, first, rows, &constants, &slot_of, &mut own, scratch);
                    self.report(&self.plan.steps[s], rows as f32 / height as f32);
                }
            },
        );
        self.check()
    }

    /// The rows of a lane that are there.
    pub(super) fn read(&self, id: usize) -> Rows<'_> {
        match &self.windows[id] {
            Some(window) => window.rows(self.plan.domain.width, self.plan.domain.height),
            None => plane(&self.planes, id).rows(),
        }
    }

    /// One step on one band.
    #[expect(clippy::too_many_arguments, reason = "a band's whole state, used here only")]
    fn band(
        &self,
        s: usize,
        first: usize,
        rows: usize,
        constants: &ConstantRows,
        slot_of: &[Option<usize>],
        own: &mut [&mut [f32]],
        scratch: &mut [Vec<f32>],
    ) {
        let (width, height) = (self.plan.domain.width, self.plan.domain.height);
        let step = &self.plan.steps[s];
        let len = rows * width;
        for pass in &step.passes {
            // Outputs leave their lists while the inputs are borrowed from the rest.
            let mut taken: SmallVec<[Taken<'_>; 16]> = (pass.outputs.iter())
                .map(|id| match id.map(|id| (self.plan.homes[id], slot_of[id])) {
                    Some((Home::Scratch(slot), _)) => Taken::Scratch(std::mem::take(&mut scratch[slot])),
                    Some((Home::Plane, Some(slot))) => Taken::Own(std::mem::take(&mut own[slot])),
                    Some((Home::Plane, None)) | None => Taken::None,
                })
                .collect();
            // An input in the slot of the output: its rows have left with it.
            let over = (step.overwritten(pass).zip(pass.outputs.first().copied().flatten()))
                .filter(|(lane, by)| self.plan.homes[*lane] == self.plan.homes[*by])
                .map(|(lane, _)| lane);
            let lanes: SmallVec<[Rows<'_>; 16]> = (pass.inputs.iter())
                .map(|source| match source {
                    LaneSource::Const(v) => constants.get(*v),
                    LaneSource::Lane(id) if over == Some(*id) => {
                        Rows::window(&[], width, height, first as i64)
                    }
                    LaneSource::Lane(id) => match (self.plan.homes[*id], slot_of[*id]) {
                        (Home::Scratch(slot), _) => {
                            Rows::window(&scratch[slot][..len], width, height, first as i64)
                        }
                        (Home::Plane, Some(slot)) => {
                            Rows::window(&own[slot][..len], width, height, first as i64)
                        }
                        (Home::Plane, None) => self.read(*id),
                    },
                })
                .collect();
            let slices = (taken.iter_mut())
                .map(|taken| match taken {
                    Taken::None => None,
                    Taken::Scratch(rows) => Some(&mut rows[..len]),
                    Taken::Own(rows) => Some(&mut rows[..len]),
                })
                .collect();
            let mut outs = Outputs::new(&step.output_offsets, slices, width, first as i64);
            let over = over.and(step.node.overwrites());
            self.node(s, || {
                let ins = Inputs::new(&step.input_offsets, &lanes).over(over);
                step.node.eval(&self.cx(s), first as i64..(first + rows) as i64, &ins, &mut outs);
            });
            drop((outs, lanes));
            for (id, taken) in pass.outputs.iter().zip(taken) {
                match (id.map(|id| (self.plan.homes[id], slot_of[id])), taken) {
                    (Some((Home::Scratch(slot), _)), Taken::Scratch(rows)) => scratch[slot] = rows,
                    (Some((_, Some(slot))), Taken::Own(rows)) => own[slot] = rows,
                    _ => {}
                }
            }
        }
    }

    /// The planes of a map. Two maps may show the same lane: the last one takes the plane, earlier ones a copy.
    fn hand_out(&mut self, kind: MapKind) -> MapPlanes {
        let (w, h) = (self.plan.domain.width, self.plan.domain.height);
        let map = &self.plan.maps[&kind];
        let mut planes = Vec::with_capacity(map.lanes.len());
        for source in &map.lanes {
            planes.push(match source {
                LaneSource::Const(v) => Plane::filled(w, h, *v),
                LaneSource::Lane(id) => {
                    let left = self.shown_by.get_mut(id);
                    let last = left.is_none_or(|n| {
                        *n -= 1;
                        *n == 0
                    });
                    let plane = if last { self.planes[*id].take() } else { self.planes[*id].clone() };
                    plane.expect("a map's lane is a plane and was written")
                }
            });
        }
        MapPlanes { planes, range: map.range }
    }
}

fn plane(planes: &[Option<Plane>], id: usize) -> &Plane {
    planes[id].as_ref().expect("a lane is read after it was written and before it is freed")
}
