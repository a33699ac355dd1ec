//! What two sets in a row have in common: it is evaluated once, for both.
//!
//! A lane is known by what it computes. Of the lanes of the next set's plan those are looked for that this one computes,
//! too, as near to the maps as they are found; a step of this plan keeps each of them as it is made, and a step of the next
//! one shows it instead of all that it took.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::lower::{Lowered, drop_unread};
use super::stage::{lanes_read, lanes_written};
use super::{LaneId, LaneSource, Pass, Step};
use crate::base::Domain;
use crate::node::{Category, Cx, Inputs, Node, Outputs, ParamError, Prepared, Reach, Spec};

/// What a lane computes: a hash of its operation, its settings, its inputs and the grid.
type Content = [u8; 32];

/// Keeping a lane and showing it again cost about as much as so many nanoseconds a texel; what saves less is not shared.
const LANE_NS: f32 = 2.0;

/// Lanes that a plan keeps for the next one. They are there once it has run.
#[derive(Clone, Debug, Default)]
pub struct Shelf {
    lanes: BTreeMap<Content, Arc<Lane>>,
}

impl Shelf {
    /// Whether nothing is kept.
    pub fn is_empty(&self) -> bool {
        self.lanes.is_empty()
    }

    /// Bytes of what is kept on one of two shelves, on this grid.
    pub(super) fn bytes_with(&self, other: &Self, domain: &Domain) -> u64 {
        let both: BTreeSet<&Content> = self.lanes.keys().chain(other.lanes.keys()).collect();
        4 * both.len() as u64 * domain.texels() as u64
    }
}

/// A lane that is kept, row by row.
#[derive(Debug)]
struct Lane {
    rows: Vec<OnceLock<Box<[f32]>>>,
}

impl Lane {
    fn new(height: usize) -> Arc<Self> {
        Arc::new(Self { rows: (0..height).map(|_| OnceLock::new()).collect() })
    }
}

/// What each lane computes; lanes that depend on files are not known.
pub(super) fn contents(lowered: &Lowered, domain: &Domain) -> BTreeMap<LaneId, Content> {
    let mut of: BTreeMap<LaneId, Content> = BTreeMap::new();
    for step in lowered.steps.iter().filter(|step| step.node.files().is_empty()) {
        let spec = step.node.spec();
        let seed = if spec.random { step.seed } else { 0 };
        let what = format!("{} {seed} {domain:?} {:?}", spec.name, step.node.settings());
        for pass in &step.passes {
            let mut hasher = blake3::Hasher::new();
            hasher.update(what.as_bytes());
            let known = pass.inputs.iter().all(|source| match source {
                LaneSource::Const(value) => {
                    hasher.update(b"=").update(&value.to_bits().to_le_bytes());
                    true
                }
                LaneSource::Lane(id) => {
                    of.get(id).map(|content| hasher.update(b"<").update(content)).is_some()
                }
            });
            for (output, &id) in pass.outputs.iter().enumerate().filter(|_| known) {
                if let Some(id) = id {
                    let content =
                        hasher.clone().update(b">").update(&(output as u64).to_le_bytes()).finalize();
                    of.insert(id, content.into());
                }
            }
        }
    }
    of
}

/// The lanes that are read if those that `has` knows are there, and the steps that are then left.
struct Cut {
    lanes: Vec<LaneId>,
    runs: Vec<bool>,
}

impl Cut {
    /// `None` where it does not pay.
    fn new(lowered: &Lowered, has: impl Fn(LaneId) -> bool) -> Option<Self> {
        let mut asked = vec![false; lowered.lanes];
        for lane in lowered.maps.values().flat_map(|map| &map.lanes).filter_map(LaneSource::lane) {
            asked[lane] = true;
        }
        let mut runs = vec![true; lowered.steps.len()];
        let mut lanes = Vec::new();
        // Readers come after what they read: what a step is asked for is known when it is its turn.
        for (s, step) in lowered.steps.iter().enumerate().rev() {
            let wanted: Vec<LaneId> = lanes_written(step).filter(|&lane| asked[lane]).collect();
            runs[s] = !wanted.iter().all(|&lane| has(lane));
            if runs[s] {
                lanes_read(step).for_each(|lane| asked[lane] = true);
            } else {
                lanes.extend(wanted);
            }
        }
        let saved: f32 =
            lowered.steps.iter().zip(&runs).filter(|(_, runs)| !**runs).map(|(step, _)| step.cost_ns()).sum();
        (!lanes.is_empty() && saved > LANE_NS * lanes.len() as f32).then_some(Self { lanes, runs })
    }
}

/// Take what the set before has kept.
pub(super) fn take(lowered: Lowered, before: &Shelf, of: &BTreeMap<LaneId, Content>) -> Lowered {
    let on_shelf = |lane: LaneId| of.get(&lane).and_then(|content| before.lanes.get(content));
    let Some(cut) = Cut::new(&lowered, |lane| on_shelf(lane).is_some()) else { return lowered };
    let Lowered { steps: all, maps, lanes } = lowered;
    let mut left: Vec<LaneId> = cut.lanes;
    let mut steps = Vec::with_capacity(all.len());
    for (step, _) in all.into_iter().zip(cut.runs).filter(|(_, runs)| *runs) {
        // Just before they are first read, so that they take room no longer than they must.
        let (now, later) = left.into_iter().partition(|lane| lanes_read(&step).any(|read| read == *lane));
        left = later;
        let now: Vec<LaneId> = now;
        steps.extend(now.into_iter().filter_map(|lane| Some(shown(lane, on_shelf(lane)?))));
        steps.push(step);
    }
    steps.extend(left.into_iter().filter_map(|lane| Some(shown(lane, on_shelf(lane)?))));
    drop_unread(steps, maps, lanes)
}

/// Keep what the next set, lowered and not yet cut, can take.
pub(super) fn keep(
    lowered: &mut Lowered,
    of: &BTreeMap<LaneId, Content>,
    next: &Lowered,
    of_next: &BTreeMap<LaneId, Content>,
    before: &Shelf,
    domain: &Domain,
) -> Shelf {
    let written = lowered.steps.iter().flat_map(lanes_written);
    let here: BTreeMap<Content, LaneId> = written.filter_map(|lane| Some((*of.get(&lane)?, lane))).collect();
    let has = |lane: LaneId| of_next.get(&lane).is_some_and(|content| here.contains_key(content));
    let mut shelf = Shelf::default();
    let Some(cut) = Cut::new(next, has) else { return shelf };
    let mut keeps: BTreeMap<LaneId, Arc<Lane>> = BTreeMap::new();
    for content in cut.lanes.iter().filter_map(|lane| of_next.get(lane)) {
        // What was kept already is handed on.
        let lane = before.lanes.get(content).cloned().unwrap_or_else(|| {
            let lane = Lane::new(domain.height);
            keeps.insert(here[content], lane.clone());
            lane
        });
        shelf.lanes.insert(*content, lane);
    }
    let mut steps = Vec::with_capacity(lowered.steps.len() + keeps.len());
    for step in std::mem::take(&mut lowered.steps) {
        let kept: Vec<Step> =
            lanes_written(&step).filter_map(|lane| Some(kept(lane, keeps.get(&lane)?))).collect();
        steps.push(step);
        steps.extend(kept);
    }
    lowered.steps = steps;
    shelf
}

fn kept(lane: LaneId, room: &Arc<Lane>) -> Step {
    let pass = Pass { inputs: vec![LaneSource::Lane(lane)], outputs: Vec::new() };
    step(lane, Shelved::Kept(room.clone()), vec![0, 1], vec![0], pass)
}

fn shown(lane: LaneId, kept: &Arc<Lane>) -> Step {
    let pass = Pass { inputs: Vec::new(), outputs: vec![Some(lane)] };
    step(lane, Shelved::Shown(kept.clone()), vec![0], vec![0, 1], pass)
}

fn step(
    lane: LaneId,
    node: Shelved,
    input_offsets: Vec<usize>,
    output_offsets: Vec<usize>,
    pass: Pass,
) -> Step {
    Step {
        node_index: None,
        name: format!("{} {}", node.spec().name, lane),
        node: Arc::new(node),
        seed: 0,
        reach: Reach::Point,
        input_offsets,
        output_offsets,
        passes: vec![pass],
    }
}

/// What a step does that is no operation of a preset.
#[derive(Debug)]
enum Shelved {
    /// Keeps its input.
    Kept(Arc<Lane>),
    /// Shows what was kept.
    Shown(Arc<Lane>),
}

impl Node for Shelved {
    fn spec(&self) -> &'static Spec {
        const KEPT: Spec = Spec { name: "kept", category: Category::Input, ..Spec::FILTER };
        const SHOWN: Spec = Spec { name: "shown", category: Category::Input, ..Spec::GENERATOR };
        match self {
            Self::Kept(_) => &KEPT,
            Self::Shown(_) => &SHOWN,
        }
    }

    fn check(&self) -> Vec<ParamError> {
        Vec::new()
    }

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Point
    }

    fn cost_ns(&self) -> f32 {
        0.5 * LANE_NS
    }

    fn own_bytes(&self, _: &Domain, _: usize) -> u64 {
        0
    }

    fn forwards(&self) -> Option<usize> {
        None
    }

    fn overwrites(&self) -> Option<usize> {
        None
    }

    fn files(&self) -> Vec<&str> {
        Vec::new()
    }

    fn prepare(&self, _: &Cx<'_>) -> Option<Prepared> {
        None
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            match self {
                // Slabs make some rows twice, with the same values.
                Self::Kept(lane) => drop(lane.rows[y as usize].get_or_init(|| ins.row(0, y).into())),
                Self::Shown(lane) => {
                    let row = lane.rows[y as usize].get().expect("the plan that keeps it has run before");
                    outs.only(y).copy_from_slice(row);
                }
            }
        }
    }

    fn settings(&self) -> toml::Table {
        toml::Table::new()
    }
}
