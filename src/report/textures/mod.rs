//! The report on a preset's textures: what every approximation in its graph costs on the final maps.
//!
//! | Group | Reference |
//! | --- | --- |
//! | nodes | the graph with nodes that do more: more directions, a longer blur, smaller steps |
//! | arithmetic | the plan reckoned plainly in f64 with `libm` |
//! | size | the map at full size, and the mean of finer texels |
//! | encoding | the map before it becomes integers |
//!
//! Every number is measured when the report is made.

mod difference;
mod encoding;
mod finer;
mod kernels;
mod number;
mod page;
mod plain;
mod resample;
mod timed;

use std::collections::BTreeMap;
use std::sync::Arc;

use self::difference::{Difference, Texels};
use self::number::Ours;
use self::timed::{Timed, timed};
use super::{Report, Watch};
use crate::base::{Domain, MapKind};
use crate::graph::Graph;
use crate::io::IoError;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The graph cannot be planned at this size.
    #[error(transparent)]
    Plan(#[from] crate::plan::PlanError),
    /// Nobody asked for that.
    #[error(transparent)]
    Cancelled(#[from] crate::eval::Cancelled),
    /// A map cannot be a PNG file.
    #[error(transparent)]
    Encode(#[from] IoError),
}

/// An approximation on one map.
#[derive(Clone, Debug)]
struct Row {
    group: &'static str,
    shortcut: String,
    /// What it stands for.
    truth: String,
    /// The map and its range; `None` where no map differs.
    map: Option<(MapKind, [f32; 2])>,
    difference: Difference,
    ms: Option<f64>,
    exact_ms: Option<f64>,
}

impl Row {
    /// Milliseconds that the shortcut saves.
    fn saved(&self) -> Option<f64> {
        Some(self.exact_ms? - self.ms?)
    }
}

/// What the parts of the report share.
struct Subject<'a> {
    graph: &'a Graph,
    wanted: Vec<MapKind>,
    domain: Domain,
    rounds: usize,
}

/// Measure every approximation of a graph at a size; call it on a pool of one thread, so that times add up.
///
/// # Errors
/// [`Problem`]: the graph cannot be planned at this size, or twice it.
pub fn report(graph: &Graph, domain: Domain, rounds: usize, watch: Watch<'_>) -> Result<Report, Problem> {
    let wanted = graph.maps.keys().copied().collect();
    let subject = Subject { graph, wanted, domain, rounds };
    watch(0.0, "the maps");
    let ours = subject.made(graph, domain, rounds)?;
    let maps = ours.maps();
    let mut rows = Vec::new();
    watch(0.1, "finer nodes");
    rows.extend(subject.nodes(&ours, &maps)?);
    watch(0.3, "arithmetic");
    let (arithmetic, failures) = subject.arithmetic(&ours, &maps);
    rows.extend(arithmetic);
    watch(0.7, "other sizes");
    rows.extend(subject.sizes(&ours, &maps)?);
    watch(0.9, "encoding");
    for (&kind, planes) in &ours.made.maps {
        rows.extend(encoding::rows(kind, planes, rounds)?);
    }
    watch(1.0, "");
    Ok(page::page(&subject, &ours, &rows, failures))
}

impl Subject<'_> {
    fn made(&self, graph: &Graph, domain: Domain, rounds: usize) -> Result<Timed, Problem> {
        timed(graph, &self.wanted, domain, rounds)
    }

    /// A row for each map that differs, or one that says that none does.
    fn rows(
        &self,
        like: &Row,
        ours: &BTreeMap<MapKind, Texels>,
        truth: &BTreeMap<MapKind, Texels>,
    ) -> Vec<Row> {
        let row = |(kind, ours): (&MapKind, &Texels)| {
            let difference = Difference::between(ours, truth.get(kind)?);
            let map = Some((*kind, self.graph.maps.get(kind)?.range));
            (!difference.is_none()).then(|| Row { map, difference, ..like.clone() })
        };
        let rows: Vec<Row> = ours.iter().filter_map(row).collect();
        if rows.is_empty() { vec![like.clone()] } else { rows }
    }

    /// Nodes that could do more.
    fn nodes(&self, ours: &Timed, maps: &BTreeMap<MapKind, Texels>) -> Result<Vec<Row>, Problem> {
        // Nodes of one kind and the same settings are one approximation.
        let mut kinds: BTreeMap<(&str, String), Vec<usize>> = BTreeMap::new();
        for step in &ours.plan.steps {
            if let (Some(finer), Some(index)) = (finer::of(&step.node), step.node_index) {
                kinds.entry((step.node.spec().name, finer.shortcut)).or_default().push(index);
            }
        }
        let mut rows = Vec::new();
        for indices in kinds.values() {
            let mut graph = self.graph.clone();
            let mut like = row("nodes", "", "");
            for &i in indices {
                if let Some(finer) = finer::of(&graph.nodes[i].node) {
                    graph.nodes[i].node = Arc::clone(&finer.node);
                    (like.shortcut, like.truth) = (finer.shortcut, finer.truth);
                }
            }
            let truth = self.made(&graph, self.domain, self.rounds)?;
            let names = indices.iter().map(|&i| self.graph.nodes[i].name.as_str());
            (like.ms, like.exact_ms) = (Some(ours.ms_of(names.clone())), Some(truth.ms_of(names)));
            rows.extend(self.rows(&like, maps, &truth.maps()));
        }
        Ok(rows)
    }

    /// f32 for f64, polynomials for `libm`, and both with all else that our kernels do; what makes the reference
    /// doubtful comes with it.
    fn arithmetic(&self, ours: &Timed, maps: &BTreeMap<MapKind, Texels>) -> (Vec<Row>, Vec<String>) {
        let with_formula = ours.plan.steps.iter().filter(|step| plain::has_formula(step));
        let our_ms = ours.ms_of(with_formula.map(|step| step.name.as_str()));
        let double = plain::reckon::<f64>(&ours.plan);
        let single = plain::reckon::<f32>(&ours.plan);
        let polynomial = plain::reckon::<Ours>(&ours.plan);
        let timed = |like: Row, ms, exact_ms| Row { ms: Some(ms), exact_ms: Some(exact_ms), ..like };
        let like = row("arithmetic", "our kernels, all in all", "plain code in f64 with libm");
        let mut rows = self.rows(&timed(like, our_ms, double.ms), maps, &double.maps);
        let failures = doubts(&rows);
        let like = row("arithmetic", "f32, the same plain code", "f64");
        rows.extend(self.rows(&timed(like, single.ms, double.ms), &single.maps, &double.maps));
        let like = row("arithmetic", "polynomials, the same plain code", "libm in f32");
        rows.extend(self.rows(&timed(like, polynomial.ms, single.ms), &polynomial.maps, &single.maps));
        (rows, failures)
    }

    /// Drafts drawn larger, and one sample a texel for four.
    fn sizes(&self, ours: &Timed, maps: &BTreeMap<MapKind, Texels>) -> Result<Vec<Row>, Problem> {
        let Domain { width, height, .. } = self.domain;
        let mut rows = Vec::new();
        for part in [2, 4, 8] {
            let side = |n: usize| n.div_ceil(part);
            let draft = Domain { width: side(width), height: side(height), ..self.domain };
            let draft = self.made(self.graph, draft, self.rounds)?;
            let mut like =
                row("size", format!("1/{part} of the size, drawn larger"), format!("{width} x {height}"));
            (like.ms, like.exact_ms) = (Some(draft.ms), Some(ours.ms));
            let large = |(kind, map): (MapKind, Texels)| (kind, resample::enlarged(&map, width, height));
            rows.extend(self.rows(&like, &draft.maps().into_iter().map(large).collect(), maps));
        }
        let fine = Domain { width: 2 * width, height: 2 * height, ..self.domain };
        let fine = self.made(self.graph, fine, self.rounds.min(2))?;
        let mut like = row("size", "one sample a texel", "mean of four");
        (like.ms, like.exact_ms) = (Some(ours.ms), Some(fine.ms));
        let mean = |(kind, map): (MapKind, Texels)| (kind, resample::averaged(&map, 2));
        rows.extend(self.rows(&like, maps, &fine.maps().into_iter().map(mean).collect()));
        Ok(rows)
    }
}

/// A row without numbers.
fn row(group: &'static str, shortcut: impl ToString, truth: impl ToString) -> Row {
    let (shortcut, truth) = (shortcut.to_string(), truth.to_string());
    let difference = Difference { max: 0.0, rms: 0.0, seen: None };
    Row { group, shortcut, truth, map: None, difference, ms: None, exact_ms: None }
}

/// RMS difference between our kernels and the formulas in f64 that rounding cannot explain, as a share of a map's
/// range.
const DOUBT: f64 = 1e-3;

/// What says that formulas and kernels compute different things.
fn doubts(rows: &[Row]) -> Vec<String> {
    let doubt = |row: &Row| {
        let share = page::share(row)?;
        (share.is_nan() || share > DOUBT).then(|| {
            let map = row.map.map_or("", |(kind, _)| kind.name());
            format!("{map}: the nodes and their formulas in f64 differ by {share:.1e} of the range")
        })
    };
    rows.iter().filter_map(doubt).collect()
}

#[cfg(test)]
mod tests;
