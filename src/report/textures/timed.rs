//! A graph evaluated with a clock.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::Problem;
use super::difference::Texels;
use crate::base::watch::{Watch, Work};
use crate::base::{Domain, MapKind};
use crate::eval::{Control, Evaluation, run};
use crate::graph::Graph;
use crate::plan::Plan;

/// Adds up the time of each node.
#[derive(Debug)]
struct Clock {
    start: Instant,
    nanos: Mutex<BTreeMap<String, u64>>,
}

impl Watch for Clock {
    fn begin(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn end(&self, begin: u64, work: Work, name: &str) {
        let took = self.begin().saturating_sub(begin);
        let mut nanos = self.nanos.lock().unwrap_or_else(PoisonError::into_inner);
        if work == Work::Node {
            *nanos.entry(name.to_owned()).or_default() += took;
        }
    }
}

/// What an evaluation made and took.
pub(super) struct Timed {
    pub(super) plan: Plan,
    pub(super) made: Evaluation,
    /// The fastest of all rounds, ms.
    pub(super) ms: f64,
    /// Each node's time, in each round, ms.
    nodes: Vec<BTreeMap<String, f64>>,
}

impl Timed {
    /// Time of some nodes together in the fastest round, ms.
    pub(super) fn ms_of<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> f64 {
        let round = |nodes: &BTreeMap<String, f64>| names.clone().filter_map(|n| nodes.get(n)).sum::<f64>();
        self.nodes.iter().map(round).fold(f64::INFINITY, f64::min)
    }

    /// Its maps.
    pub(super) fn maps(&self) -> BTreeMap<MapKind, Texels> {
        self.made.maps.iter().map(|(&kind, map)| (kind, Texels::of(kind, map))).collect()
    }
}

/// Evaluate so many times, at least once, on the current pool. Times of nodes that work on several threads at once add up
/// on a pool of one thread only.
pub(super) fn timed(
    graph: &Graph,
    wanted: &[MapKind],
    domain: Domain,
    rounds: usize,
) -> Result<Timed, Problem> {
    let plan = Plan::new(graph, wanted, domain, None)?;
    let (mut ms, mut nodes, mut last) = (f64::INFINITY, Vec::new(), None);
    for _ in 0..rounds.max(1) {
        let clock = Clock { start: Instant::now(), nanos: Mutex::default() };
        let made = run(&plan, Control { watch: Some(&clock), ..Control::default() })?;
        ms = ms.min(clock.begin() as f64 * 1e-6);
        let nanos = clock.nanos.into_inner().unwrap_or_else(PoisonError::into_inner);
        nodes.push(nanos.into_iter().map(|(name, n)| (name, n as f64 * 1e-6)).collect());
        last = Some(made);
    }
    let made = last.ok_or(Problem::Cancelled(crate::eval::Cancelled))?;
    Ok(Timed { plan, made, ms, nodes })
}
