//! From named drafts to a graph: names, kinds, ranges and cycles, every problem at once.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{Graph, GraphNode, MapSource, OutputRef, Source};
use crate::base::{MapKind, hash};
use crate::node::draft::{Draft, InputDraft, NodeDraft, Wire};
use crate::node::{Assets, Fallback, InputSpec, Kind, PortKind};
use crate::optics::SkinOptics;

/// One problem of a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// Stable code, such as `unknown-node`.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
    /// Where it stands in the preset, if it does.
    pub span: Option<Range<usize>>,
    /// The unknown name and what it could have been, for a did-you-mean.
    pub candidates: Option<(String, Vec<String>)>,
}

impl BuildError {
    /// A problem at `span`.
    pub fn new(
        code: &'static str,
        message: String,
        help: impl Into<String>,
        span: Option<Range<usize>>,
    ) -> Self {
        Self { code, message, help: help.into(), span, candidates: None }
    }
}

/// A map as it was written: what it shows, its range, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct MapDraft {
    /// What it shows.
    pub wire: Wire,
    /// Physical values that integer files map to 0 and 1.
    pub range: [f32; 2],
    /// Where it stands in the preset, if it does.
    pub span: Option<Range<usize>>,
}

/// What a graph is resolved from.
#[derive(Clone, Debug)]
pub struct Sketch {
    /// Name of the preset.
    pub name: String,
    /// The set's seed.
    pub seed: u64,
    /// Physical size of the tile, mm: girth, length.
    pub size_mm: [f32; 2],
    /// Nodes by name.
    pub draft: Draft,
    /// Maps by kind.
    pub maps: BTreeMap<MapKind, MapDraft>,
}

/// Resolve every name, fill every default, check every kind and range, and order the nodes.
///
/// # Errors
/// Every problem found, in the order of the nodes.
pub fn resolve(sketch: &Sketch) -> Result<Graph, Vec<BuildError>> {
    let drafts = &sketch.draft.nodes;
    let index: BTreeMap<&str, usize> = drafts.iter().enumerate().map(|(i, n)| (n.name.as_str(), i)).collect();
    let mut errors = Vec::new();

    // A failed wire reads the fallback, so that later checks go on.
    let mut wired: Vec<Vec<Source>> = Vec::with_capacity(drafts.len());
    for draft in drafts {
        wired.push(wire_inputs(draft, drafts, &index, &mut errors));
    }
    let order = match order(drafts, &wired) {
        Ok(order) => order,
        Err(error) => {
            errors.push(error);
            return Err(errors);
        }
    };
    let mut rank = vec![0; drafts.len()];
    for (new, &old) in order.iter().enumerate() {
        rank[old] = new;
    }

    // A node's kind depends on its sources', so kinds follow the order.
    let mut nodes: Vec<GraphNode> = Vec::with_capacity(drafts.len());
    for &old in &order {
        let draft = &drafts[old];
        let inputs: Vec<Source> = wired[old].iter().map(|&s| renumber(s, &rank)).collect();
        let kind = kind_of(draft, &inputs, &nodes, &mut errors);
        nodes.push(GraphNode {
            name: draft.name.clone(),
            node: draft.node.clone(),
            kind,
            inputs,
            seed: hash::node_seed(sketch.seed, &draft.name),
        });
    }

    let mut maps = BTreeMap::new();
    for (&kind, map) in &sketch.maps {
        match find_source(&map.wire, drafts, &index) {
            Ok(source) => {
                let source = renumber(source, &rank);
                if source_kind(source, &nodes) == Kind::Color && kind.channels() == 1 {
                    errors.push(BuildError::new(
                        "type-mismatch",
                        format!("map {kind} is a single plane, but its source is a color"),
                        "take one channel with `split` or the brightness with `grayscale`",
                        map.span.clone(),
                    ));
                }
                maps.insert(kind, MapSource { source, range: map.range });
            }
            Err(mut error) => {
                error.message = format!("map {kind}: {}", error.message);
                error.span.clone_from(&map.span);
                errors.push(error);
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let [girth_mm, length_mm] = sketch.size_mm;
    Ok(Graph {
        name: sketch.name.clone(),
        seed: sketch.seed,
        girth_mm,
        length_mm,
        nodes,
        maps,
        optics: SkinOptics::default(),
        assets: Assets::new(),
    })
}

fn renumber(source: Source, rank: &[usize]) -> Source {
    match source {
        Source::Output(o) => Source::Output(OutputRef { node: rank[o.node], ..o }),
        constant => constant,
    }
}

fn source_kind(source: Source, nodes: &[GraphNode]) -> Kind {
    match source {
        Source::Scalar(_) => Kind::Scalar,
        Source::Color(_) => Kind::Color,
        Source::Output(o) => nodes[o.node].output_kind(o.port),
    }
}

fn wire_inputs(
    draft: &NodeDraft,
    drafts: &[NodeDraft],
    index: &BTreeMap<&str, usize>,
    errors: &mut Vec<BuildError>,
) -> Vec<Source> {
    let spec = draft.node.spec();
    let mut sources = Vec::with_capacity(spec.inputs.len());
    for input in spec.inputs {
        let fallback = match input.fallback {
            Fallback::Scalar(v) => Source::Scalar(v),
            Fallback::Color(c) => Source::Color(c),
            Fallback::Required => Source::Scalar(0.0),
        };
        let Some(set) = draft.inputs.iter().find(|i| i.name == input.name) else {
            if input.fallback == Fallback::Required {
                errors.push(BuildError::new(
                    "missing-input",
                    format!("node {} ({}) needs `{}`", draft.name, spec.name, input.name),
                    format!("set `{} = \"some_node\"`: {}", input.name, input.doc),
                    draft.span.clone(),
                ));
            }
            sources.push(fallback);
            continue;
        };
        match find_source(&set.wire, drafts, index) {
            Ok(source) => {
                check_constant(draft, input, set, source, errors);
                sources.push(source);
            }
            Err(mut error) => {
                error.message = format!("node {}, input {}: {}", draft.name, input.name, error.message);
                error.span = set.span.clone().or_else(|| draft.span.clone());
                errors.push(error);
                sources.push(fallback);
            }
        }
    }
    for set in draft.inputs.iter().filter(|set| spec.input(&set.name).is_none()) {
        let mut error = BuildError::new(
            "unknown-key",
            format!("node {}: {} has no input `{}`", draft.name, spec.name, set.name),
            format!("`ophidian nodes {}` lists its inputs and settings", spec.name),
            set.span.clone(),
        );
        error.candidates = Some((set.name.clone(), spec.inputs.iter().map(|i| i.name.to_owned()).collect()));
        errors.push(error);
    }
    sources
}

fn check_constant(
    draft: &NodeDraft,
    input: &InputSpec,
    set: &InputDraft,
    source: Source,
    errors: &mut Vec<BuildError>,
) {
    match source {
        Source::Scalar(v) if !v.is_finite() || v < input.min || v > input.max => {
            let unit = if input.unit.is_empty() { String::new() } else { format!(" {}", input.unit) };
            errors.push(BuildError::new(
                "out-of-range",
                format!("node {}: {} = {v} is out of range", draft.name, input.name),
                format!("allowed: {} to {}{unit}", input.min, input.max),
                set.span.clone(),
            ));
        }
        Source::Color(_) if input.kind == PortKind::Scalar => {
            errors.push(BuildError::new(
                "type-mismatch",
                format!("node {}: {} takes a number or a scalar output, not a color", draft.name, input.name),
                "write a number",
                set.span.clone(),
            ));
        }
        _ => {}
    }
}

#[expect(clippy::result_large_err, reason = "made once per mistake of an author")]
fn find_source(
    wire: &Wire,
    drafts: &[NodeDraft],
    index: &BTreeMap<&str, usize>,
) -> Result<Source, BuildError> {
    let name = match wire {
        Wire::Scalar(v) => return Ok(Source::Scalar(*v)),
        Wire::Color(c) => return Ok(Source::Color(c.0)),
        Wire::Output(name) => name,
    };
    let (node, port) = match name.split_once('.') {
        Some((node, port)) => (node, Some(port)),
        None => (name.as_str(), None),
    };
    let Some(&i) = index.get(node) else {
        let mut error = BuildError::new(
            "unknown-node",
            format!("there is no node `{node}`"),
            "name a node of this preset, `node` or `node.port`",
            None,
        );
        error.candidates = Some((node.to_owned(), index.keys().map(|&k| k.to_owned()).collect()));
        return Err(error);
    };
    let spec = drafts[i].node.spec();
    let Some(port) = port else { return Ok(Source::Output(OutputRef { node: i, port: 0 })) };
    match spec.output(port) {
        Some(port) => Ok(Source::Output(OutputRef { node: i, port })),
        None => {
            let names: Vec<String> = spec.outputs.iter().map(|o| o.name.to_owned()).collect();
            let mut error = BuildError::new(
                "unknown-port",
                format!("node `{node}` ({}) has no output `{port}`", spec.name),
                format!("its outputs: {}", names.join(", ")),
                None,
            );
            error.candidates = Some((port.to_owned(), names));
            Err(error)
        }
    }
}

/// Topological order, stable in the order of the drafts.
#[expect(clippy::result_large_err, reason = "made once per mistake of an author")]
fn order(drafts: &[NodeDraft], wired: &[Vec<Source>]) -> Result<Vec<usize>, BuildError> {
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Open,
        Done,
    }
    let mut marks = vec![Mark::New; drafts.len()];
    let mut order = Vec::with_capacity(drafts.len());
    // An explicit stack: a preset may hold a chain of any length.
    let mut stack: Vec<(usize, usize)> = Vec::new();
    for root in 0..drafts.len() {
        if marks[root] != Mark::New {
            continue;
        }
        marks[root] = Mark::Open;
        stack.push((root, 0));
        while let Some((node, next)) = stack.last_mut() {
            let node = *node;
            let Some(&source) = wired[node].get(*next) else {
                marks[node] = Mark::Done;
                order.push(node);
                stack.pop();
                continue;
            };
            *next += 1;
            let Source::Output(o) = source else { continue };
            match marks[o.node] {
                Mark::Done => {}
                Mark::New => {
                    marks[o.node] = Mark::Open;
                    stack.push((o.node, 0));
                }
                Mark::Open => {
                    let start = stack.iter().position(|(n, _)| *n == o.node).unwrap_or(0);
                    let mut names: Vec<&str> =
                        stack[start..].iter().map(|(n, _)| drafts[*n].name.as_str()).collect();
                    names.push(&drafts[o.node].name);
                    return Err(BuildError::new(
                        "cycle",
                        format!("nodes read each other in a circle: {}", names.join(" reads ")),
                        "break the circle: a node may only read nodes that do not depend on it",
                        drafts[o.node].span.clone(),
                    ));
                }
            }
        }
    }
    Ok(order)
}

fn kind_of(draft: &NodeDraft, inputs: &[Source], nodes: &[GraphNode], errors: &mut Vec<BuildError>) -> Kind {
    let mut kind = Kind::Scalar;
    for (input, &source) in draft.node.spec().inputs.iter().zip(inputs) {
        if source_kind(source, nodes) != Kind::Color {
            continue;
        }
        match input.kind {
            PortKind::Any => kind = Kind::Color,
            PortKind::Scalar if matches!(source, Source::Output(_)) => {
                let set = draft.inputs.iter().find(|i| i.name == input.name);
                errors.push(BuildError::new(
                    "type-mismatch",
                    format!("node {}: {} takes a scalar, but its source is a color", draft.name, input.name),
                    "take one channel with `split` or the brightness with `grayscale`",
                    set.and_then(|s| s.span.clone()),
                ));
            }
            _ => {}
        }
    }
    kind
}
