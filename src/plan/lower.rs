//! Live nodes to steps: dead nodes, forwarding nodes, equal sub-graphs and constants disappear here.

use std::collections::{BTreeMap, BTreeSet};

use super::{LaneId, LaneSource, MapPlan, Pass, Step};
use crate::base::{Domain, MapKind};
use crate::graph::{Graph, OutputRef, Source};
use crate::node::{Inputs, Kind, Outputs, PortKind, Reach};

/// Steps and maps, before they are staged.
pub(super) struct Lowered {
    pub(super) steps: Vec<Step>,
    pub(super) maps: BTreeMap<MapKind, MapPlan>,
    pub(super) lanes: usize,
}

/// The value of a node's output once it is planned: its lanes, 1 or 3.
type Value = Vec<LaneSource>;

struct Lowering<'a> {
    graph: &'a Graph,
    domain: &'a Domain,
    /// Live outputs: (node, port).
    live: BTreeSet<(usize, usize)>,
    /// Values of live outputs.
    values: BTreeMap<(usize, usize), Value>,
    /// Values of nodes already planned, by what they compute.
    known: BTreeMap<String, usize>,
    steps: Vec<Step>,
    lanes: usize,
}

pub(super) fn lower(graph: &Graph, wanted: &[MapKind], domain: &Domain) -> Lowered {
    let mut lowering = Lowering {
        graph,
        domain,
        live: BTreeSet::new(),
        values: BTreeMap::new(),
        known: BTreeMap::new(),
        steps: Vec::new(),
        lanes: 0,
    };
    lowering.mark(wanted);
    for node in 0..graph.nodes.len() {
        lowering.plan(node);
    }
    let maps = wanted
        .iter()
        .filter_map(|&kind| {
            let map = graph.maps.get(&kind)?;
            let value = lowering.value(map.source);
            let lanes = (0..kind.channels()).map(|c| channel(&value, c)).collect();
            Some((kind, MapPlan { lanes, range: map.range }))
        })
        .collect();
    drop_unread(lowering.steps, maps, lowering.lanes)
}

fn channel(value: &Value, c: usize) -> LaneSource {
    value[c.min(value.len() - 1)]
}

impl Lowering<'_> {
    /// What `source` reads once forwarding nodes are seen through.
    fn see_through(&self, mut source: Source) -> Source {
        while let Source::Output(o) = source {
            match self.graph.nodes[o.node].node.forwards() {
                Some(input) => source = self.graph.nodes[o.node].inputs[input],
                None => break,
            }
        }
        source
    }

    /// Mark what the wanted maps reach. Nodes are in order, so one walk backwards is enough.
    fn mark(&mut self, wanted: &[MapKind]) {
        for kind in wanted {
            if let Some(map) = self.graph.maps.get(kind)
                && let Source::Output(o) = self.see_through(map.source)
            {
                self.live.insert((o.node, o.port));
            }
        }
        for node in (0..self.graph.nodes.len()).rev() {
            if self.live.range((node, 0)..(node + 1, 0)).next().is_none() {
                continue;
            }
            for &source in &self.graph.nodes[node].inputs {
                if let Source::Output(o) = self.see_through(source) {
                    self.live.insert((o.node, o.port));
                }
            }
        }
    }

    fn value(&self, source: Source) -> Value {
        match self.see_through(source) {
            Source::Scalar(v) => vec![LaneSource::Const(v)],
            Source::Color(c) => c.map(LaneSource::Const).to_vec(),
            Source::Output(OutputRef { node, port }) => self.values[&(node, port)].clone(),
        }
    }

    fn plan(&mut self, index: usize) {
        let ports: Vec<usize> = self.live.range((index, 0)..(index + 1, 0)).map(|&(_, port)| port).collect();
        if ports.is_empty() {
            return;
        }
        let graph_node = &self.graph.nodes[index];
        let spec = graph_node.node.spec();
        let inputs: Vec<Value> = graph_node.inputs.iter().map(|&s| self.value(s)).collect();

        // A forwarding node is reached only through its own name: see_through leaves none.
        let key = self.key(index, &inputs);
        if let Some(&twin) = self.known.get(&key) {
            let all: Vec<((usize, usize), Value)> = ports
                .iter()
                .filter_map(|&port| Some(((index, port), self.values.get(&(twin, port))?.clone())))
                .collect();
            if all.len() == ports.len() {
                self.values.extend(all);
                return;
            }
        }

        let channels = if graph_node.kind == Kind::Color { 3 } else { 1 };
        let mut input_offsets = vec![0];
        for input in spec.inputs {
            let lanes = if input.kind == PortKind::Color { 3 } else { 1 };
            input_offsets.push(input_offsets.last().copied().unwrap_or(0) + lanes);
        }
        let mut output_offsets = vec![0];
        for port in 0..spec.outputs.len() {
            let lanes = match spec.outputs[port].kind {
                crate::node::OutputKind::Color => 3,
                _ => 1,
            };
            output_offsets.push(output_offsets.last().copied().unwrap_or(0) + lanes);
        }
        let lane_inputs = |c: usize| -> Vec<LaneSource> {
            let mut lanes = Vec::new();
            for (input, value) in spec.inputs.iter().zip(&inputs) {
                match input.kind {
                    PortKind::Scalar => lanes.push(channel(value, 0)),
                    PortKind::Any => lanes.push(channel(value, c)),
                    PortKind::Color => lanes.extend((0..3).map(|c| channel(value, c))),
                }
            }
            lanes
        };

        let reach = graph_node.node.reach(self.domain);
        let all_const = inputs.iter().flatten().all(|l| matches!(l, LaneSource::Const(_)));
        if all_const && !spec.positional && !spec.random && reach == Reach::Point {
            let mut folded: BTreeMap<usize, Value> = BTreeMap::new();
            for c in 0..channels {
                let outputs = self.fold(index, &lane_inputs(c), &input_offsets, &output_offsets);
                for &port in &ports {
                    let lanes = &outputs[output_offsets[port]..output_offsets[port + 1]];
                    folded.entry(port).or_default().extend(lanes.iter().map(|&v| LaneSource::Const(v)));
                }
            }
            self.values.extend(folded.into_iter().map(|(port, value)| ((index, port), value)));
            return;
        }

        let mut passes = Vec::new();
        for c in 0..channels {
            let mut outputs = vec![None; output_offsets[spec.outputs.len()]];
            for &port in &ports {
                for slot in &mut outputs[output_offsets[port]..output_offsets[port + 1]] {
                    *slot = Some(self.lanes);
                    self.values.entry((index, port)).or_default().push(LaneSource::Lane(self.lanes));
                    self.lanes += 1;
                }
            }
            passes.push(Pass { inputs: lane_inputs(c), outputs });
        }
        self.known.insert(key, index);
        self.steps.push(Step {
            node_index: Some(index),
            name: graph_node.name.clone(),
            node: graph_node.node.clone(),
            seed: graph_node.seed,
            reach,
            input_offsets,
            output_offsets,
            passes,
        });
    }

    /// What a node computes, as text: equal keys give equal planes.
    fn key(&self, index: usize, inputs: &[Value]) -> String {
        let node = &self.graph.nodes[index];
        let spec = node.node.spec();
        let seed = if spec.random { node.seed } else { 0 };
        format!("{} {seed} {:?} {} {inputs:?}", spec.name, node.kind, node.node.settings())
    }

    /// A point node of constants, on one texel.
    fn fold(
        &self,
        index: usize,
        lanes: &[LaneSource],
        input_offsets: &[usize],
        output_offsets: &[usize],
    ) -> Vec<f32> {
        let node = &self.graph.nodes[index];
        let cells: Vec<[f32; 1]> = lanes
            .iter()
            .map(|l| match l {
                LaneSource::Const(v) => [*v],
                LaneSource::Lane(_) => [0.0],
            })
            .collect();
        let rows: Vec<crate::base::Rows<'_>> =
            cells.iter().map(|c| crate::base::Rows::broadcast(c)).collect();
        let mut out = vec![[0.0f32; 1]; output_offsets[output_offsets.len() - 1]];
        let domain = Domain { width: 1, height: 1, ..*self.domain };
        let cx = crate::node::Cx { domain, seed: node.seed, assets: &self.graph.assets, prepared: None };
        let prepared = node.node.prepare(&cx);
        let cx = crate::node::Cx { prepared: prepared.as_ref(), ..cx };
        let lanes_out = out.iter_mut().map(|c| Some(&mut c[..])).collect();
        node.node.eval(
            &cx,
            0..1,
            &Inputs::new(input_offsets, &rows),
            &mut Outputs::new(output_offsets, lanes_out, 1, 0),
        );
        out.iter().map(|c| c[0]).collect()
    }
}

/// Folding and merging can leave steps that nobody reads any more: walk back once and drop them.
pub(super) fn drop_unread(steps: Vec<Step>, maps: BTreeMap<MapKind, MapPlan>, lanes: usize) -> Lowered {
    let mut read = vec![false; lanes];
    let mark = |read: &mut Vec<bool>, sources: &[LaneSource]| {
        for source in sources {
            if let LaneSource::Lane(id) = source {
                read[*id] = true;
            }
        }
    };
    for map in maps.values() {
        mark(&mut read, &map.lanes);
    }
    let mut kept = Vec::with_capacity(steps.len());
    for mut step in steps.into_iter().rev() {
        let mut alive = false;
        for pass in &mut step.passes {
            for output in &mut pass.outputs {
                *output = output.filter(|&id: &LaneId| read[id]);
            }
            if pass.outputs.iter().any(Option::is_some) {
                alive = true;
                let inputs = pass.inputs.clone();
                mark(&mut read, &inputs);
            }
        }
        step.passes.retain(|pass| pass.outputs.iter().any(Option::is_some));
        if alive {
            kept.push(step);
        }
    }
    kept.reverse();
    Lowered { steps: kept, maps, lanes }
}
