//! Steps to stages: what can share a pass over memory, where every lane lives, and the bytes that takes.

use std::collections::BTreeMap;

use super::lower::Lowered;
use super::{Home, LaneId, LaneSource, MapPlan, Pass, Plan, Stage, Step};
use crate::base::{Domain, MapKind};
use crate::node::{Assets, Reach};

/// Scratch of one band, bytes: what a second cache of 1 MiB holds beside what the nodes keep. Measured with one at 2048 x 2048: with
/// 256 KiB 1.04 of the CPU time that 512 take, with 768 and 1024 0.97, with 2048 1.00.
const BAND_BYTES: usize = 768 << 10;
/// Rows of a band at most, so that small maps still spread over threads.
const BAND_ROWS: usize = 32;

pub(super) fn stage(lowered: Lowered, domain: Domain, assets: Assets) -> Plan {
    let Lowered { steps, maps, lanes } = lowered;
    let producer = producers(&steps, lanes);
    let stage_of = assign(&steps, &producer);
    let count = stage_of.iter().map(|s| s + 1).max().unwrap_or(0);

    let mut homes = home_planes(&steps, &maps, &producer, &stage_of);
    let mut stages = Vec::with_capacity(count);
    for k in 0..count {
        let members: Vec<usize> = (0..steps.len()).filter(|&s| stage_of[s] == k).collect();
        let (whole, rows): (Vec<_>, Vec<_>) =
            members.into_iter().partition(|&s| steps[s].reach == Reach::Whole);
        let scratch_slots = assign_scratch(&steps, &rows, &mut homes);
        stages.push(Stage {
            band_rows: band_rows(&domain, scratch_slots),
            whole,
            rows,
            scratch_slots,
            frees: Vec::new(),
        });
    }
    free_after_last_read(&steps, &maps, &homes, &stage_of, &mut stages);
    let peak_bytes = peak_bytes(&steps, &maps, &homes, &stages, &domain);
    Plan { domain, steps, stages, homes, maps, peak_bytes, assets }
}

fn band_rows(domain: &Domain, slots: usize) -> usize {
    let row_bytes = domain.width * 4 * slots.max(1);
    (BAND_BYTES / row_bytes).clamp(1, BAND_ROWS)
}

pub(super) fn lanes_read(step: &Step) -> impl Iterator<Item = LaneId> + '_ {
    step.passes.iter().flat_map(|p| &p.inputs).filter_map(LaneSource::lane)
}

pub(super) fn lanes_written(step: &Step) -> impl Iterator<Item = LaneId> + '_ {
    step.passes.iter().flat_map(|p| &p.outputs).filter_map(|id| *id)
}

fn producers(steps: &[Step], lanes: usize) -> Vec<usize> {
    let mut producer = vec![usize::MAX; lanes];
    for (s, step) in steps.iter().enumerate() {
        for lane in lanes_written(step) {
            producer[lane] = s;
        }
    }
    producer
}

/// Whether `reader` can run in the stage of `writer`: both row-wise, and the reader looks at its own texel only.
fn fusable(writer: &Step, reader: &Step) -> bool {
    writer.reach != Reach::Whole && reader.reach == Reach::Point
}

/// As early as possible for what maps read directly, as late as possible for the rest: fewer planes stay alive.
fn assign(steps: &[Step], producer: &[usize]) -> Vec<usize> {
    let mut earliest = vec![0usize; steps.len()];
    for (s, step) in steps.iter().enumerate() {
        for lane in lanes_read(step) {
            let writer = producer[lane];
            let gap = usize::from(!fusable(&steps[writer], step));
            earliest[s] = earliest[s].max(earliest[writer] + gap);
        }
    }
    let mut latest = vec![usize::MAX; steps.len()];
    for s in (0..steps.len()).rev() {
        if latest[s] == usize::MAX {
            latest[s] = earliest[s];
        }
        for lane in lanes_read(&steps[s]) {
            let writer = producer[lane];
            let gap = usize::from(!fusable(&steps[writer], &steps[s]));
            latest[writer] = latest[writer].min(latest[s] - gap);
        }
    }
    latest
}

/// Lanes that must be planes; the others get a provisional scratch slot.
fn home_planes(
    steps: &[Step],
    maps: &BTreeMap<MapKind, MapPlan>,
    producer: &[usize],
    stage_of: &[usize],
) -> Vec<Home> {
    let mut homes = vec![Home::Scratch(usize::MAX); producer.len()];
    for map in maps.values() {
        for source in &map.lanes {
            if let LaneSource::Lane(id) = source {
                homes[*id] = Home::Plane;
            }
        }
    }
    for (s, step) in steps.iter().enumerate() {
        for lane in lanes_read(step) {
            if stage_of[producer[lane]] != stage_of[s] {
                homes[lane] = Home::Plane;
            }
        }
        if step.reach == Reach::Whole {
            for lane in lanes_written(step) {
                homes[lane] = Home::Plane;
            }
        }
    }
    homes
}

/// Give every scratch lane of a stage a slot, reusing slots after their last reader; returns the slots used.
fn assign_scratch(steps: &[Step], rows: &[usize], homes: &mut [Home]) -> usize {
    let mut last_reader = vec![0usize; homes.len()];
    for &s in rows {
        for lane in lanes_read(&steps[s]) {
            last_reader[lane] = s;
        }
    }
    let mut free: Vec<usize> = Vec::new();
    let mut slots = 0;
    for &s in rows {
        let over = overwritten(&steps[s], homes, |lane| last_reader[lane] == s);
        for &(lane, by) in &over {
            homes[by] = homes[lane];
        }
        for lane in lanes_written(&steps[s]).filter(|lane| over.iter().all(|(_, by)| by != lane)) {
            if let Home::Scratch(_) = homes[lane] {
                let slot = free.pop().unwrap_or_else(|| {
                    slots += 1;
                    slots - 1
                });
                homes[lane] = Home::Scratch(slot);
            }
        }
        // Slots are given back only now, so that no output shares a slot with an input of its step.
        let mut done: Vec<LaneId> = lanes_read(&steps[s]).filter(|&lane| last_reader[lane] == s).collect();
        done.sort_unstable();
        done.dedup();
        for lane in done.into_iter().filter(|lane| over.iter().all(|(from, _)| from != lane)) {
            if let Home::Scratch(slot) = homes[lane]
                && slot != usize::MAX
            {
                free.push(slot);
            }
        }
    }
    slots
}

/// Lanes of a step that its outputs are written over, and by which: those that nobody else reads, and it once.
fn overwritten(step: &Step, homes: &[Home], is_last: impl Fn(LaneId) -> bool) -> Vec<(LaneId, LaneId)> {
    let pair = |pass: &Pass| {
        let [Some(by)] = pass.outputs[..] else { return None };
        let lane = step.overwritten(pass)?;
        let slots = matches!((homes[lane], homes[by]), (Home::Scratch(_), Home::Scratch(_)));
        let once = lanes_read(step).filter(|read| *read == lane).count() == 1;
        (slots && once && is_last(lane)).then_some((lane, by))
    };
    step.passes.iter().filter_map(pair).collect()
}

fn free_after_last_read(
    steps: &[Step],
    maps: &BTreeMap<MapKind, MapPlan>,
    homes: &[Home],
    stage_of: &[usize],
    stages: &mut [Stage],
) {
    let mut last = vec![None; homes.len()];
    for (s, step) in steps.iter().enumerate() {
        for lane in lanes_read(step) {
            last[lane] = last[lane].max(Some(stage_of[s]));
        }
    }
    for map in maps.values() {
        for source in &map.lanes {
            if let LaneSource::Lane(id) = source {
                last[*id] = None;
            }
        }
    }
    for (lane, stage) in last.into_iter().enumerate() {
        if let (Some(stage), Home::Plane) = (stage, homes[lane]) {
            stages[stage].frees.push(lane);
        }
    }
}

/// Greatest number of bytes held at once, as [`crate::eval::run`] takes them on the current rayon pool: planes are
/// given back to it, not to the system.
fn peak_bytes(
    steps: &[Step],
    maps: &BTreeMap<MapKind, MapPlan>,
    homes: &[Home],
    stages: &[Stage],
    domain: &Domain,
) -> u64 {
    let plane = 4 * domain.texels() as u64;
    let written =
        |s: usize| lanes_written(&steps[s]).filter(|&lane| homes[lane] == Home::Plane).count() as u64;
    let own = |s: usize, rows: usize| steps[s].node.own_bytes(domain, rows);
    let (mut alive, mut taken, mut peak) = (0u64, 0u64, 0u64);
    for stage in stages {
        for &s in &stage.whole {
            alive += written(s);
            taken = taken.max(alive);
            peak = peak.max(taken * plane + own(s, domain.height));
        }
        alive += stage.rows.iter().map(|&s| written(s)).sum::<u64>();
        taken = taken.max(alive);
        // Every thread works on a band.
        let band = (stage.scratch_slots * stage.band_rows * domain.width * 4) as u64
            + stage.rows.iter().map(|&s| own(s, stage.band_rows)).max().unwrap_or(0);
        let bands = domain.height.div_ceil(stage.band_rows).min(rayon::current_num_threads());
        peak = peak.max(taken * plane + bands as u64 * band);
        alive -= stage.frees.len() as u64;
    }
    // At the end constants become planes, and a lane that two maps show becomes two.
    let shown: Vec<LaneSource> = maps.values().flat_map(|map| map.lanes.iter().copied()).collect();
    let mut lanes: Vec<LaneId> = shown.iter().filter_map(LaneSource::lane).collect();
    let constants = shown.len() - lanes.len();
    lanes.sort_unstable();
    let all = lanes.len();
    lanes.dedup();
    peak.max((taken + (constants + all - lanes.len()) as u64) * plane)
}
