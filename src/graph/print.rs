//! A graph as a preset of nodes only, which evaluates to the same bytes.

use std::fmt::Write;

use super::{Graph, GraphNode, Source};
use crate::base::{LinearRgb, Srgb8};
use crate::node::{self, Fallback};

/// Print a graph as a preset: every node with the inputs and settings that are not at their defaults.
pub fn to_toml(graph: &Graph) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "# The graph of {}, nodes only.", comment(&graph.name));
    if super::from_document::is_name(&graph.name) {
        let _ = writeln!(out, "name = \"{}\"", graph.name);
    }
    let _ = writeln!(out, "seed = {}\n\n[tile]", graph.seed);
    let _ = writeln!(out, "girth_mm = {}", number(graph.girth_mm));
    let _ = writeln!(out, "length_mm = {}\n\n[maps]", number(graph.length_mm));
    for (kind, map) in &graph.maps {
        let [low, high] = map.range.map(number);
        let from = source(graph, map.source);
        let _ = writeln!(out, "{kind} = {{ from = {from}, range = [{low}, {high}] }}");
    }
    out.push_str(&material(graph));
    for node in &graph.nodes {
        let _ = writeln!(out, "\n[nodes.{}]\nop = \"{}\"", node.name, node.node.spec().name);
        for (spec, &input) in node.node.spec().inputs.iter().zip(&node.inputs) {
            let unset = match (spec.fallback, input) {
                (Fallback::Scalar(a), Source::Scalar(b)) => a.to_bits() == b.to_bits(),
                (Fallback::Color(a), Source::Color(b)) => a.map(f32::to_bits) == b.map(f32::to_bits),
                _ => false,
            };
            if !unset {
                let _ = writeln!(out, "{} = {}", spec.name, source(graph, input));
            }
        }
        out.push_str(&settings(node));
    }
    out
}

/// The optics that are set; nothing where none are, so that such presets keep their hash.
fn material(graph: &Graph) -> String {
    let optics = toml::Value::try_from(graph.optics).ok();
    let table = optics.as_ref().and_then(toml::Value::as_table).filter(|table| !table.is_empty());
    table.map_or_else(String::new, |table| {
        let lines: String = table.iter().map(|(k, v)| format!("{k} = {}\n", value(v, true))).collect();
        format!("\n[material]\n{lines}")
    })
}

/// A name on one line of a comment.
fn comment(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn source(graph: &Graph, source: Source) -> String {
    match source {
        Source::Scalar(v) => number(v),
        Source::Color(c) => {
            // Hexadecimal where nothing is lost by it.
            let hex = Srgb8::from(LinearRgb(c));
            if LinearRgb::from(hex).0.map(f32::to_bits) == c.map(f32::to_bits) {
                format!("\"{hex}\"")
            } else {
                format!("[{}]", c.map(number).join(", "))
            }
        }
        Source::Output(output) => format!("\"{}\"", graph.output_name(output)),
    }
}

/// The shortest number that reads back as the same f32.
fn number(v: f32) -> String {
    let short = format!("{v:?}");
    let back = short.parse::<f64>().map(|x| x as f32);
    if back.is_ok_and(|b| b.to_bits() == v.to_bits()) { short } else { format!("{:?}", f64::from(v)) }
}

/// The settings that are not at their defaults, a line each: short if they read back as the same node, else exact.
fn settings(node: &GraphNode) -> String {
    let settings = node.node.settings();
    let default = node::find(node.node.spec().name).map(|op| (op.default)().settings()).unwrap_or_default();
    let changed: toml::Table = settings
        .iter()
        .filter(|(k, v)| default.get(*k) != Some(*v))
        .map(|(k, v)| (k.clone(), v.clone()))
        .collect();
    let lines = |short: bool| -> String {
        changed.iter().map(|(k, v)| format!("{k} = {}\n", value(v, short))).collect()
    };
    let short = lines(true);
    let same = node::find(node.node.spec().name).is_some_and(|op| {
        let inline = format!("{{ {} }}", short.trim_end().replace('\n', ", "));
        let parsed = toml::de::ValueDeserializer::parse(&inline).ok().and_then(|d| (op.parse)(d).ok());
        parsed.is_some_and(|n| n.settings() == settings)
    });
    if same { short } else { lines(false) }
}

/// A value on one line, whatever it holds.
fn value(value: &toml::Value, short: bool) -> String {
    match value {
        toml::Value::Float(x) if short && f64::from(*x as f32) == *x => number(*x as f32),
        toml::Value::Float(x) => format!("{x:?}"),
        toml::Value::Array(items) => {
            let items: Vec<String> = items.iter().map(|v| self::value(v, short)).collect();
            format!("[{}]", items.join(", "))
        }
        toml::Value::Table(table) => {
            let items: Vec<String> =
                table.iter().map(|(k, v)| format!("{k} = {}", self::value(v, short))).collect();
            format!("{{ {} }}", items.join(", "))
        }
        other => other.to_string(),
    }
}
