//! A plan whose maps are made slab by slab: a few hundred rows of everything at once, from the first row to the last.
//!
//! A node that looks around a texel needs rows above and below the slab. They are kept from the slab before, so that only
//! the rows beyond the seam of the torus are evaluated twice.

use super::stage::{lanes_read, lanes_written};
use super::{Home, LaneId, LaneSource, Plan};
use crate::node::Reach;

/// How a plan is run where its planes would not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slabs {
    /// Rows of a slab.
    pub rows: usize,
    /// So many stages run whole first: they hold what other nodes read from anywhere.
    pub whole: usize,
    /// Rows that a stage is ahead of the slab, and behind it at the first one.
    pub ahead: Vec<usize>,
    /// Rows of each lane that are kept from slab to slab at most; 0 for lanes that have no window.
    pub kept: Vec<usize>,
}

/// Rows of a slab, the greatest that fits is taken.
const ROWS: [usize; 6] = [1024, 512, 256, 128, 64, 32];
/// How to run a plan slab by slab within a budget, bytes, and the bytes that this takes; or the least bytes that it
/// would take.
pub(super) fn slabs(plan: &Plan, budget: u64, again: usize) -> Result<(Slabs, u64), u64> {
    let mut least = plan.peak_bytes;
    for rows in ROWS.into_iter().filter(|&rows| rows < plan.domain.height) {
        let slabs = Slabs::new(plan, rows, again);
        let bytes = slabs.peak_bytes(plan);
        if bytes <= budget {
            return Ok((slabs, bytes));
        }
        least = least.min(bytes);
    }
    Err(least)
}

impl Slabs {
    /// Slabs of so many rows, of which the reader of the maps may want so many `again` with the next slab.
    pub fn new(plan: &Plan, rows: usize, again: usize) -> Self {
        let stage_of = stages_of(plan);
        let whole = whole_stages(plan, &stage_of);
        let mut ahead = vec![0; plan.stages.len()];
        let mut kept = vec![0; plan.homes.len()];
        // Readers come after what they read: from the last stage to the first.
        for k in (whole..plan.stages.len()).rev() {
            for &s in &plan.stages[k].rows {
                let step = &plan.steps[s];
                for lane in lanes_read(step).filter(|&lane| stage_of[lane] < k) {
                    let from = stage_of[lane];
                    ahead[from] = ahead[from].max(ahead[k] + Self::reach(step.reach));
                }
            }
        }
        let mut keep = |lane: LaneId, rows: usize| kept[lane] = rows.max(kept[lane]);
        for k in whole..plan.stages.len() {
            for &s in &plan.stages[k].rows {
                let step = &plan.steps[s];
                for lane in lanes_read(step).filter(|&lane| (whole..k).contains(&stage_of[lane])) {
                    // The reader's next row is `ahead[k]` rows ahead of the slab, the lane's `ahead` of its own stage.
                    keep(lane, ahead[stage_of[lane]] + Self::reach(step.reach) - ahead[k]);
                }
            }
        }
        for lane in plan.maps.values().flat_map(|m| &m.lanes).filter_map(LaneSource::lane) {
            if stage_of[lane] >= whole {
                keep(lane, ahead[stage_of[lane]] + again);
            }
        }
        Self { rows, whole, ahead, kept }
    }

    /// Greatest number of bytes held at once, as [`crate::eval::run_slabs`] takes them on the current rayon pool. Planes that
    /// are given back go to a pool, so all that was ever taken counts.
    pub fn peak_bytes(&self, plan: &Plan) -> u64 {
        let row = 4 * plan.domain.width as u64;
        let (height, threads) = (plan.domain.height, rayon::current_num_threads());
        let planes = |s: usize| lanes_written(&plan.steps[s]).filter(|&lane| plan.homes[lane] == Home::Plane);
        let own = |s: usize, rows: usize| plan.steps[s].node.own_bytes(&plan.domain, rows);
        let (mut alive, mut planes_taken, mut windows, mut working) = (0u64, 0u64, 0u64, 0u64);
        for (k, stage) in plan.stages.iter().enumerate() {
            let slab = k >= self.whole;
            for &s in &stage.whole {
                alive += planes(s).count() as u64;
                working = working.max(own(s, height));
            }
            for lane in stage.rows.iter().flat_map(|&s| planes(s)) {
                if slab {
                    windows += row * self.window_rows(k, lane) as u64;
                } else {
                    alive += 1;
                }
            }
            planes_taken = planes_taken.max(alive);
            if !slab {
                alive -= stage.frees.len() as u64;
            }
            let bands = if slab { self.rows } else { height }.div_ceil(stage.band_rows).min(threads);
            let own = stage.rows.iter().map(|&s| own(s, stage.band_rows)).max().unwrap_or(0);
            let scratch = (stage.scratch_slots * stage.band_rows) as u64 * row;
            working = working.max(bands as u64 * (scratch + own));
        }
        planes_taken * row * height as u64 + windows + working
    }

    /// Rows that a node of a slab reads to each side.
    pub fn reach(reach: Reach) -> usize {
        match reach {
            Reach::Around { y, .. } => y,
            _ => 0,
        }
    }

    /// Rows that the window of a lane of stage `k` has at most.
    pub fn window_rows(&self, k: usize, lane: LaneId) -> usize {
        // The first slab starts as far behind the seam as the stage is ahead.
        self.rows + (2 * self.ahead[k]).max(self.kept[lane])
    }
}

/// The stage that writes each lane.
fn stages_of(plan: &Plan) -> Vec<usize> {
    let mut stage_of = vec![0; plan.homes.len()];
    for (k, stage) in plan.stages.iter().enumerate() {
        for pass in stage.whole.iter().chain(&stage.rows).flat_map(|&s| &plan.steps[s].passes) {
            for lane in pass.outputs.iter().flatten() {
                stage_of[*lane] = k;
            }
        }
    }
    stage_of
}

/// Stages up to the last that has a node of whole planes, or a plane that another node reads from anywhere.
fn whole_stages(plan: &Plan, stage_of: &[usize]) -> usize {
    let of_nodes = plan.stages.iter().rposition(|stage| !stage.whole.is_empty()).map_or(0, |k| k + 1);
    let anywhere = plan.steps.iter().filter(|step| step.reach == Reach::Anywhere).flat_map(lanes_read);
    // Scratch is read in its own stage, at its own texel.
    let planes = anywhere.filter(|&lane| plan.homes[lane] == Home::Plane);
    planes.map(|lane| stage_of[lane] + 1).fold(of_nodes, usize::max)
}
