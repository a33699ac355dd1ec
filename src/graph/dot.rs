//! A graph as a picture's source (Graphviz, Mermaid) and as JSON, with what each map needs.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::{Graph, Source};
use crate::base::MapKind;

/// Per node, the wanted maps that need it; none for a dead node. A node that forwards one input (such as a
/// `switch`) needs only that one.
pub fn needed_by(graph: &Graph, wanted: &[MapKind]) -> Vec<BTreeSet<MapKind>> {
    let mut needed = vec![BTreeSet::new(); graph.nodes.len()];
    for kind in wanted {
        if let Some(Source::Output(o)) = graph.maps.get(kind).map(|m| m.source) {
            needed[o.node].insert(*kind);
        }
    }
    // Nodes read only earlier ones, so one walk from the last is enough.
    for i in (0..graph.nodes.len()).rev() {
        let node = &graph.nodes[i];
        let maps = needed[i].clone();
        let only = node.node.forwards();
        for (k, source) in node.inputs.iter().enumerate() {
            if let Source::Output(o) = source
                && only.is_none_or(|only| only == k)
            {
                needed[o.node].extend(maps.iter().copied());
            }
        }
    }
    needed
}

/// An edge: from an output, to an input's name.
fn edges(graph: &Graph, node: usize) -> impl Iterator<Item = (usize, &'static str, &'static str)> + '_ {
    let n = &graph.nodes[node];
    n.node.spec().inputs.iter().zip(&n.inputs).filter_map(|(spec, source)| match source {
        Source::Output(o) => {
            let outputs = graph.nodes[o.node].node.spec().outputs;
            // The first output goes without its name, as in a preset.
            Some((o.node, if o.port == 0 { "" } else { outputs[o.port].name }, spec.name))
        }
        _ => None,
    })
}

fn words(maps: &BTreeSet<MapKind>) -> String {
    maps.iter().map(|m| m.name()).collect::<Vec<_>>().join(" ")
}

/// The graph for Graphviz: `dot -Tsvg`. Dead nodes are dashed; a node tells the maps that need it.
pub fn to_dot(graph: &Graph, wanted: &[MapKind]) -> String {
    let quote = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
    let needed = needed_by(graph, wanted);
    let mut out = format!("digraph {} {{\n  rankdir=LR;\n  node [shape=box];\n", quote(&graph.name));
    for (i, node) in graph.nodes.iter().enumerate() {
        let label = format!("{}\n{}", node.name, node.node.spec().name);
        let style = if needed[i].is_empty() { ", style=dashed, color=gray, fontcolor=gray" } else { "" };
        let label = quote(&label).replace('\n', "\\n");
        let _ = writeln!(out, "  n{i} [label={label}, tooltip={}{style}];", quote(&words(&needed[i])));
        for (from, port, input) in edges(graph, i) {
            let _ =
                writeln!(out, "  n{from} -> n{i} [taillabel={}, headlabel={}];", quote(port), quote(input));
        }
    }
    for kind in wanted {
        let _ = writeln!(out, "  map_{kind} [label={}, shape=ellipse];", quote(kind.name()));
        if let Some(Source::Output(o)) = graph.maps.get(kind).map(|m| m.source) {
            let _ = writeln!(out, "  n{} -> map_{kind};", o.node);
        }
    }
    out.push_str("}\n");
    out
}

/// The graph for Mermaid, which many documentation sites draw. Dead nodes are dashed.
pub fn to_mermaid(graph: &Graph, wanted: &[MapKind]) -> String {
    let quote = |text: &str| format!("\"{}\"", text.replace('&', "#amp;").replace('"', "#quot;"));
    let needed = needed_by(graph, wanted);
    let mut out = String::from("flowchart LR\n  classDef dead stroke-dasharray: 4, color: #888\n");
    for (i, node) in graph.nodes.iter().enumerate() {
        let class = if needed[i].is_empty() { ":::dead" } else { "" };
        let label = quote(&format!("{} · {}", node.name, node.node.spec().name));
        let _ = writeln!(out, "  n{i}[{label}]{class}");
        for (from, port, input) in edges(graph, i) {
            let dot = if port.is_empty() { "" } else { "." };
            let _ = writeln!(out, "  n{from} -->|{}| n{i}", quote(&format!("{dot}{port} {input}")));
        }
    }
    for kind in wanted {
        if let Some(Source::Output(o)) = graph.maps.get(kind).map(|m| m.source) {
            let _ = writeln!(out, "  n{} --> map_{kind}([{}])", o.node, quote(kind.name()));
        }
    }
    out
}

/// The graph as JSON: nodes in order with inputs, settings and the wanted maps that need them.
pub fn to_json(graph: &Graph, wanted: &[MapKind]) -> Value {
    let source = |s: Source| match s {
        Source::Scalar(v) => json!(v),
        Source::Color(c) => json!(c),
        Source::Output(o) => json!(graph.output_name(o)),
    };
    let needed = needed_by(graph, wanted);
    let node = |(i, n): (usize, &super::GraphNode)| {
        let spec = n.node.spec();
        let inputs: Map<String, Value> =
            spec.inputs.iter().zip(&n.inputs).map(|(i, &s)| (i.name.to_owned(), source(s))).collect();
        json!({
            "name": n.name,
            "op": spec.name,
            "kind": n.kind.name(),
            "inputs": inputs,
            "settings": n.node.settings(),
            "cost_ns_per_texel": n.node.cost_ns(),
            "needed_by": needed[i].iter().map(|m| m.name()).collect::<Vec<_>>(),
        })
    };
    let maps: Map<String, Value> = graph
        .maps
        .iter()
        .map(|(kind, m)| (kind.name().to_owned(), json!({ "from": source(m.source), "range": m.range })))
        .collect();
    json!({
        "name": graph.name,
        "seed": graph.seed,
        "girth_mm": graph.girth_mm,
        "length_mm": graph.length_mm,
        "maps": maps,
        "nodes": graph.nodes.iter().enumerate().map(node).collect::<Vec<_>>(),
    })
}
