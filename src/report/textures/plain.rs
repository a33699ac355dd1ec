//! A plan reckoned plainly in any number, lane by lane: every node that has a formula in [`kernels`] by it, the others
//! by the node itself in f32.

use std::collections::BTreeMap;
use std::time::Instant;

use super::difference::Texels;
use super::kernels::{self, Ins, Kernel, Lane};
use super::number::Number;
use crate::base::{MapKind, Plane};
use crate::eval::{Input, run_node};
use crate::plan::{LaneId, LaneSource, Pass, Plan, Step};

/// Maps, and what the formulas took.
pub(super) struct Reckoned {
    pub(super) maps: BTreeMap<MapKind, Texels>,
    /// Time of the nodes that have a formula.
    pub(super) ms: f64,
}

/// Whether a step has a formula, so that it can be reckoned in any number.
pub(super) fn has_formula(step: &Step) -> bool {
    kernels::of::<f64>(step).is_some()
}

/// Reckon all maps of a plan.
pub(super) fn reckon<N: Number>(plan: &Plan) -> Reckoned {
    let mut lanes: BTreeMap<LaneId, Lane<N>> = BTreeMap::new();
    let mut readers: BTreeMap<LaneId, usize> = BTreeMap::new();
    let shown = plan.maps.values().flat_map(|map| &map.lanes);
    let read = plan.steps.iter().flat_map(|s| &s.passes).flat_map(|p| &p.inputs);
    for lane in shown.chain(read).filter_map(LaneSource::lane) {
        *readers.entry(lane).or_default() += 1;
    }
    let mut seconds = 0.0;
    for step in &plan.steps {
        let kernel = kernels::of::<N>(step);
        for pass in &step.passes {
            let (made, took) = call(plan, step, pass, kernel.as_ref(), &lanes);
            seconds += took;
            for (id, lane) in pass.outputs.iter().zip(made) {
                if let Some(id) = id {
                    lanes.insert(*id, lane);
                }
            }
            // What nobody reads any more is given back: a plan of sixty nodes would not fit otherwise.
            for lane in pass.inputs.iter().filter_map(LaneSource::lane) {
                let left = readers.entry(lane).or_default();
                *left = left.saturating_sub(1);
                if *left == 0 {
                    lanes.remove(&lane);
                }
            }
        }
    }
    let texels = plan.domain.texels();
    let values = |source: &LaneSource| match source {
        LaneSource::Const(v) => vec![f64::from(*v); texels],
        LaneSource::Lane(id) => match &lanes[id] {
            Lane::Same(v) => vec![v.get(); texels],
            Lane::Each(all) => all.iter().map(|v| v.get()).collect(),
        },
    };
    let maps = plan.maps.iter().map(|(&kind, map)| {
        let channels = map.lanes.iter().map(values).collect();
        (kind, Texels { kind, width: plan.domain.width, channels })
    });
    Reckoned { maps: maps.collect(), ms: seconds * 1e3 }
}

/// One call of a step: its output lanes, and the seconds that its formula took.
fn call<N: Number>(
    plan: &Plan,
    step: &Step,
    pass: &Pass,
    kernel: Option<&Kernel<N>>,
    lanes: &BTreeMap<LaneId, Lane<N>>,
) -> (Vec<Lane<N>>, f64) {
    let Some(kernel) = kernel else { return (by_the_node(plan, step, pass, lanes), 0.0) };
    let constants: Vec<Lane<N>> = (pass.inputs.iter())
        .map(|source| match source {
            LaneSource::Const(v) => Lane::Same(N::new(f64::from(*v))),
            LaneSource::Lane(_) => Lane::Same(N::new(0.0)),
        })
        .collect();
    let inputs = pass.inputs.iter().zip(&constants).map(|(source, constant)| match source {
        LaneSource::Const(_) => constant,
        LaneSource::Lane(id) => &lanes[id],
    });
    let ins = Ins { domain: &plan.domain, offsets: &step.input_offsets, lanes: inputs.collect() };
    let start = Instant::now();
    let made = kernel(&ins);
    (made, start.elapsed().as_secs_f64())
}

/// One call of a step by its node.
fn by_the_node<N: Number>(
    plan: &Plan,
    step: &Step,
    pass: &Pass,
    lanes: &BTreeMap<LaneId, Lane<N>>,
) -> Vec<Lane<N>> {
    let (w, h) = (plan.domain.width, plan.domain.height);
    let planes: Vec<Plane> = (pass.inputs.iter())
        .map(|source| match source {
            LaneSource::Const(v) => Plane::filled(w, h, *v),
            LaneSource::Lane(id) => match &lanes[id] {
                Lane::Same(v) => Plane::filled(w, h, v.get() as f32),
                Lane::Each(all) => Plane::from_vec(w, h, all.iter().map(|v| v.get() as f32).collect()),
            },
        })
        .collect();
    let inputs: Vec<Input<'_>> = (step.input_offsets.windows(2))
        .map(|ends| match (&planes[ends[0]..ends[1]], pass.inputs[ends[0]]) {
            ([_], LaneSource::Const(v)) => Input::Value(v),
            ([r, g, b], _) => Input::Color([r, g, b]),
            (lanes, _) => Input::Plane(&lanes[0]),
        })
        .collect();
    let made = run_node(step.node.as_ref(), &plan.domain, step.seed, &inputs, &plan.assets, 0);
    made.into_iter()
        .map(|plane| Lane::Each(plane.data().iter().map(|v| N::new(f64::from(*v))).collect()))
        .collect()
}
