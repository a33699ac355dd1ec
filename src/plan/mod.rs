//! WHAT IS NEEDED: live steps in order, fused into stages, with buffers and bytes known before they are spent.
//!
//! From a [`Graph`], the wanted maps and a [`Domain`]:
//! 1. live: walk back from the wanted maps; what is not reached is never planned. Forwarding nodes
//!    (`switch`) vanish, equal sub-graphs are planned once, constant sub-graphs fold to a number.
//! 2. shared: of sets in a row, what the next one computes, too, is kept for it ([`Plan::in_series`]).
//! 3. stages: steps that can share a pass over bands of rows run in one stage; values that live only
//!    inside it stay in scratch that fits the cache and never become planes.

mod lower;
mod share;
mod slab;
mod stage;

pub use share::Shelf;
pub use slab::Slabs;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::base::{Domain, MapKind};
use crate::graph::Graph;
use crate::node::{Assets, Node, Reach};

/// Bytes above which maps are made slab by slab even where they fit whole: a slab's pages are used again and its rows are
/// still in a cache when they are encoded. Measured: 3 to 13 % less CPU time at 2048 x 2048 than whole maps, and the
/// same from 48 to 512 MiB at 4096 x 4096.
const AT_ONCE: u64 = 64 << 20;

/// Index of a lane: one plane's worth of values.
pub type LaneId = usize;

/// What one lane of an input reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LaneSource {
    /// The same value everywhere.
    Const(f32),
    /// A lane of an earlier step.
    Lane(LaneId),
}

impl LaneSource {
    /// The lane, if it is one.
    pub fn lane(&self) -> Option<LaneId> {
        match self {
            Self::Lane(id) => Some(*id),
            Self::Const(_) => None,
        }
    }
}

/// One call of a node: its inputs and outputs, lane by lane.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Input lanes, flattened.
    pub inputs: Vec<LaneSource>,
    /// Output lanes, flattened; `None` where nobody reads it.
    pub outputs: Vec<Option<LaneId>>,
}

/// One live node.
#[derive(Clone, Debug)]
pub struct Step {
    /// Index of the node in the graph; `None` of a step that keeps a lane for the next set, or shows one.
    pub node_index: Option<usize>,
    /// The node's name.
    pub name: String,
    /// Operation and settings.
    pub node: Arc<dyn Node>,
    /// The node's seed.
    pub seed: u32,
    /// How far it reads.
    pub reach: Reach,
    /// Offsets of its inputs in a pass's lanes, one past the last included.
    pub input_offsets: Vec<usize>,
    /// Offsets of its outputs in a pass's lanes, one past the last included.
    pub output_offsets: Vec<usize>,
    /// One call, or one per colour channel.
    pub passes: Vec<Pass>,
}

impl Step {
    /// The lane of a pass that its output may be written over.
    pub(crate) fn overwritten(&self, pass: &Pass) -> Option<LaneId> {
        pass.inputs[self.input_offsets[self.node.overwrites()?]].lane()
    }

    /// Estimated cost of the step on one thread, ns per texel.
    pub fn cost_ns(&self) -> f32 {
        self.node.cost_ns() * self.passes.len() as f32
    }
}

/// Steps that run together.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Whole-plane steps, run one after another.
    pub whole: Vec<usize>,
    /// Row-wise steps, run fused over bands of rows.
    pub rows: Vec<usize>,
    /// Rows in a band.
    pub band_rows: usize,
    /// Scratch slots a band needs.
    pub scratch_slots: usize,
    /// Lanes whose planes are given back after this stage.
    pub frees: Vec<LaneId>,
}

/// Where a lane lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// A plane, because a later stage, a neighbourhood or a map reads it.
    Plane,
    /// A scratch slot of its stage's bands.
    Scratch(usize),
}

/// A wanted map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlan {
    /// Its channels.
    pub lanes: Vec<LaneSource>,
    /// Physical values that integer files map to 0 and 1.
    pub range: [f32; 2],
}

/// What will be done, and what it will take.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The grid.
    pub domain: Domain,
    /// Live steps, in order.
    pub steps: Vec<Step>,
    /// The order they run in.
    pub stages: Vec<Stage>,
    /// Home of every lane.
    pub homes: Vec<Home>,
    /// Wanted maps.
    pub maps: BTreeMap<MapKind, MapPlan>,
    /// Greatest number of bytes that an evaluation on the current rayon pool holds: planes, and what its threads work in.
    pub peak_bytes: u64,
    /// Image files.
    pub assets: Assets,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The preset does not define a wanted map.
    #[error("preset {preset} has no map `{map}`; it has: {has}")]
    NoSuchMap {
        /// Name of the preset.
        preset: String,
        /// The map.
        map: MapKind,
        /// The maps that there are, comma-separated.
        has: String,
    },
    /// The domain has no texels or too many.
    #[error("a map of {width} x {height} texels cannot be made: each side must be 1 to {max}")]
    Size {
        /// Texels around.
        width: usize,
        /// Texels along.
        height: usize,
        /// Greatest side.
        max: usize,
    },
    /// The plan needs more memory than it may use.
    #[error("the plan needs {} and may use {}", mib(*need), mib(*budget))]
    Memory {
        /// Bytes needed.
        need: u64,
        /// Bytes allowed.
        budget: u64,
    },
}

fn mib(bytes: u64) -> String {
    format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20))
}

/// What is to be planned.
#[derive(Clone, Copy, Debug)]
pub struct Order<'a> {
    /// What defines the maps.
    pub graph: &'a Graph,
    /// The maps.
    pub wanted: &'a [MapKind],
    /// Their grid.
    pub domain: Domain,
}

impl Order<'_> {
    /// Its live steps, if it can be made.
    fn lowered(&self) -> Result<lower::Lowered, PlanError> {
        let Domain { width, height, .. } = self.domain;
        let max = crate::base::domain::MAX_SIDE;
        if width == 0 || height == 0 || width > max || height > max {
            return Err(PlanError::Size { width, height, max });
        }
        let Graph { name, maps, .. } = self.graph;
        if let Some(&map) = self.wanted.iter().find(|map| !maps.contains_key(map)) {
            let has: Vec<&str> = maps.keys().map(|m| m.name()).collect();
            return Err(PlanError::NoSuchMap { preset: name.clone(), map, has: has.join(", ") });
        }
        Ok(lower::lower(self.graph, self.wanted, &self.domain))
    }

    fn staged(&self, lowered: lower::Lowered) -> Plan {
        stage::stage(lowered, self.domain, self.graph.assets.clone())
    }
}

impl Plan {
    /// Plan the wanted maps; `budget` is in bytes.
    ///
    /// # Errors
    /// [`PlanError`]: a map that the preset lacks, an impossible size, or more memory than `budget`.
    pub fn new(
        graph: &Graph,
        wanted: &[MapKind],
        domain: Domain,
        budget: Option<u64>,
    ) -> Result<Self, PlanError> {
        let order = Order { graph, wanted, domain };
        let (plan, _) = order.staged(order.lowered()?).fit(budget, None)?;
        Ok(plan)
    }

    /// Plan the wanted maps, all at once if that takes little, else slab by slab, for a caller who can take rows as they come
    /// and wants at most so many of them `again` with the next slab; `budget` is in bytes.
    ///
    /// # Errors
    /// As [`Plan::new`]; the memory that is needed is then that of the thinnest slabs.
    pub fn in_slabs(
        graph: &Graph,
        wanted: &[MapKind],
        domain: Domain,
        budget: Option<u64>,
        again: usize,
    ) -> Result<(Self, Option<Slabs>), PlanError> {
        let order = Order { graph, wanted, domain };
        order.staged(order.lowered()?).fit(budget, Some(again))
    }

    /// Plan a set of a series: what `before` has kept of the set before is not evaluated again, and what the `next` one
    /// evaluates, too, is kept for it, where that pays and fits. Plans must run in the order that they are made in.
    ///
    /// `again` as in [`Plan::in_slabs`], `None` for a caller who wants whole maps. The peak counts what is kept.
    ///
    /// # Errors
    /// As [`Plan::in_slabs`], for `order` alone: sharing is left out before a plan is refused.
    pub fn in_series(
        order: Order<'_>,
        next: Option<Order<'_>>,
        before: &Shelf,
        budget: Option<u64>,
        again: Option<usize>,
    ) -> Result<(Self, Option<Slabs>, Shelf), PlanError> {
        let domain = &order.domain;
        let next = next.filter(|next| next.domain == *domain);
        for (takes, keeps) in [(true, true), (true, false)] {
            let taken = if takes && !before.is_empty() { before.clone() } else { Shelf::default() };
            let mut lowered = order.lowered()?;
            let mut shelf = Shelf::default();
            if !taken.is_empty() || next.is_some() {
                let of = share::contents(&lowered, domain);
                lowered = share::take(lowered, &taken, &of);
                if let (true, Some(Ok(next))) = (keeps, next.map(|next| next.lowered())) {
                    let of_next = share::contents(&next, domain);
                    shelf = share::keep(&mut lowered, &of, &next, &of_next, &taken, domain);
                }
            }
            let beside = taken.bytes_with(&shelf, domain);
            let left = budget.map(|budget| budget.saturating_sub(beside));
            if let Ok((mut plan, slabs)) = order.staged(lowered).fit(left, again) {
                plan.peak_bytes += beside;
                return Ok((plan, slabs, shelf));
            }
        }
        let (plan, slabs) = order.staged(order.lowered()?).fit(budget, again)?;
        Ok((plan, slabs, Shelf::default()))
    }

    /// How it runs within a budget, slab by slab for a caller who can take rows as they come.
    fn fit(mut self, budget: Option<u64>, again: Option<usize>) -> Result<(Self, Option<Slabs>), PlanError> {
        let budget = budget.unwrap_or(u64::MAX);
        let little = AT_ONCE.min(budget);
        let Some(again) = again.filter(|_| self.peak_bytes > little) else {
            return match self.peak_bytes {
                need if need > budget => Err(PlanError::Memory { need, budget }),
                _ => Ok((self, None)),
            };
        };
        match slab::slabs(&self, little, again).or_else(|_| slab::slabs(&self, budget, again)) {
            Ok((slabs, bytes)) => {
                self.peak_bytes = bytes;
                Ok((self, Some(slabs)))
            }
            Err(_) if self.peak_bytes <= budget => Ok((self, None)),
            Err(need) => Err(PlanError::Memory { need, budget }),
        }
    }

    /// Estimated time on one thread, ms.
    pub fn cost_ms(&self) -> f64 {
        let ns: f64 = self.steps.iter().map(|s| f64::from(s.cost_ns())).sum();
        ns * self.domain.texels() as f64 * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{MapDraft, Sketch, resolve};
    use crate::node::combine::Mix;
    use crate::node::draft::{Draft, Wire};
    use crate::node::generate::Constant;

    fn sketch(build: impl FnOnce(&mut Draft) -> Vec<(MapKind, Wire)>) -> Graph {
        let mut draft = Draft::default();
        let maps = build(&mut draft)
            .into_iter()
            .map(|(kind, wire)| (kind, MapDraft { wire, range: [0.0, 1.0], span: None }))
            .collect();
        let sketch = Sketch { name: "test".into(), seed: 1, size_mm: [10.0, 10.0], draft, maps };
        resolve(&sketch).expect("a sound graph")
    }

    #[test]
    fn constants_fold_to_no_steps_and_keep_their_value() {
        let graph = sketch(|d| {
            let a = d.add("a", Constant {}, &[("value", 0.25.into())]);
            let m = d.add("m", Mix {}, &[("a", a), ("b", 0.75.into()), ("mask", 0.5.into())]);
            vec![(MapKind::Height, m)]
        });
        let plan = Plan::new(&graph, &[MapKind::Height], Domain::square(8), None).expect("a plan");
        assert!(plan.steps.is_empty());
        assert_eq!(plan.maps[&MapKind::Height].lanes, [LaneSource::Const(0.5)]);
    }

    #[test]
    fn sizes_and_budgets_are_refused_with_their_numbers() {
        let graph = sketch(|d| vec![(MapKind::Height, d.add("a", Constant {}, &[]))]);
        let domain = Domain { width: 0, ..Domain::square(8) };
        assert!(matches!(Plan::new(&graph, &[], domain, None), Err(PlanError::Size { width: 0, .. })));
        let missing = Plan::new(&graph, &[MapKind::Color], Domain::square(8), None);
        assert!(matches!(missing, Err(PlanError::NoSuchMap { map: MapKind::Color, .. })));
    }
}
