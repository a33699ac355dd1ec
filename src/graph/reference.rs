//! The reference page of an operation, from its declaration alone. Markdown that reads well as plain text.

use std::fmt::Write;

use serde_json::Value;

use crate::base::{Domain, params::alternatives};
use crate::node::{Fallback, InputSpec, Op, OutputKind, PortKind, REGISTRY, Reach};

/// Every operation by category, a line each.
pub fn index() -> String {
    let mut out = String::new();
    for ops in REGISTRY.iter().filter(|ops| !ops.is_empty()) {
        let _ = writeln!(out, "{}{}", if out.is_empty() { "" } else { "\n" }, ops[0].spec.category.name());
        let width = ops.iter().map(|op| op.spec.name.len()).max().unwrap_or(0);
        for op in *ops {
            let _ = writeln!(out, "  {:width$}  {}", op.spec.name, op.spec.summary);
        }
    }
    out
}

/// The page of one operation.
pub fn page(op: &Op) -> String {
    let spec = op.spec;
    let mut out = format!("# {}\n\n{}\n\nCategory: {}.", spec.name, spec.summary, spec.category.name());
    let node = (op.default)();
    let domain = Domain::square(1024);
    let reads = match node.reach(&domain) {
        Reach::Point => "the texel itself".to_owned(),
        Reach::Around { x, y } => format!("up to {x} texels around and {y} along, at 1024 × 1024"),
        Reach::Anywhere => "any part of its inputs".to_owned(),
        Reach::Whole => "the whole of its inputs at once".to_owned(),
    };
    let _ = writeln!(out, " Reads {reads}. About {} ns per texel.", node.cost_ns());
    if spec.random {
        out.push_str("Changes with the seed and with the node's name.\n");
    }
    if !spec.inputs.is_empty() {
        out.push_str(
            "\n## Inputs\n\nEach takes a number, a colour or `\"node.port\"`, as its kind allows.\n\n",
        );
        let rows = spec.inputs.iter().map(|i| {
            let default = match i.fallback {
                Fallback::Required => "required".to_owned(),
                Fallback::Scalar(v) => v.to_string(),
                Fallback::Color(c) => format!("[{}, {}, {}]", c[0], c[1], c[2]),
            };
            [code(i.name), kind(i.kind).into(), default, input_range(i), i.unit.into(), i.doc.into()]
        });
        table(&mut out, ["input", "kind", "default", "range", "unit", "effect"], rows);
    }
    let settings = settings(op);
    if !settings.is_empty() {
        out.push_str("\n## Settings\n\n");
        let rows = settings.iter().map(|s| {
            [code(&s.name), s.kind.clone(), s.default.clone(), s.range.clone(), s.unit.clone(), s.doc.clone()]
        });
        table(&mut out, ["setting", "kind", "default", "range", "unit", "effect"], rows);
    }
    out.push_str("\n## Outputs\n\n");
    let rows = spec.outputs.iter().map(|o| {
        let kind = match o.kind {
            OutputKind::Scalar => "scalar",
            OutputKind::Color => "color",
            OutputKind::Same => "as the inputs",
        };
        [code(o.name), kind.into(), o.unit.into(), o.doc.into()]
    });
    table(&mut out, ["output", "kind", "unit", "what it holds"], rows);
    let _ = writeln!(out, "\n## Example\n\n```toml\n{}```", example(op));
    out
}

/// A node of this operation as it would stand in a preset: required inputs read a node `image`, the rest is at its
/// default.
pub fn example(op: &Op) -> String {
    let mut out = format!("[nodes.my_{0}]\nop = \"{0}\"\n", op.spec.name);
    for input in op.spec.inputs {
        let value = match (input.fallback, input.kind) {
            (Fallback::Required, PortKind::Color) => "\"#9C3B24\"".to_owned(),
            (Fallback::Required, _) => "\"image\"".to_owned(),
            (Fallback::Scalar(v), _) => format!("{v:?}"),
            (Fallback::Color(c), _) => format!("{c:?}"),
        };
        let _ = writeln!(out, "{} = {value}", input.name);
    }
    for setting in settings(op).iter().filter(|s| !s.default.is_empty()) {
        let _ = writeln!(out, "{} = {}", setting.name, setting.default);
    }
    out
}

/// One setting as its struct declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Key in the preset.
    pub name: String,
    /// What it takes, in words.
    pub kind: String,
    /// Its default as TOML; empty where there is none.
    pub default: String,
    /// Its range, empty where there is none.
    pub range: String,
    /// Its unit, empty for pure numbers.
    pub unit: String,
    /// Its effect; for a choice, the choices too.
    pub doc: String,
}

/// The settings of an operation, in the order that its struct declares them.
pub fn settings(op: &Op) -> Vec<Setting> {
    let schema = (op.schema)();
    let root = schema.as_value();
    let defaults = (op.default)().settings();
    let properties = root.get("properties").and_then(Value::as_object);
    let read = |(name, property): (&String, &Value)| {
        let schemas = alternatives(root, property);
        let find = |key: &str| schemas.iter().find_map(|s| s.get(key));
        let number = |key: &str| find(key).and_then(Value::as_f64).map(|x| x as f32);
        let range = match (number("minimum"), number("maximum")) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            (Some(min), None) => format!("at least {min}"),
            (None, Some(max)) => format!("at most {max}"),
            (None, None) => String::new(),
        };
        let choices: Vec<(String, &str)> = choices(&schemas);
        let text = |v: Option<&Value>| v.and_then(Value::as_str).unwrap_or("").replace('\n', " ");
        let mut doc = text(property.get("description"));
        if !choices.is_empty() {
            let list: Vec<String> =
                choices.iter().map(|(name, doc)| format!("`{name}`: {}", doc.replace('\n', " "))).collect();
            doc = format!("{doc} {}", list.join(" ")).trim().to_owned();
        }
        Setting {
            name: name.clone(),
            kind: if choices.is_empty() { kind_of(find("type")) } else { "choice".into() },
            default: defaults.get(name).map(short).unwrap_or_default(),
            range,
            unit: text(find("x-unit")),
            doc,
        }
    };
    properties.into_iter().flatten().map(read).collect()
}

/// The names that a choice takes, each with its doc.
fn choices<'a>(schemas: &[&'a Value]) -> Vec<(String, &'a str)> {
    let doc = |s: &&'a Value| s.get("description").and_then(Value::as_str).unwrap_or("");
    let mut found = Vec::new();
    for schema in schemas {
        if let Some(name) = schema.get("const").and_then(Value::as_str) {
            found.push((name.to_owned(), doc(schema)));
        }
        let names = schema.get("enum").and_then(Value::as_array).into_iter().flatten();
        found.extend(names.filter_map(Value::as_str).map(|name| (name.to_owned(), "")));
    }
    found
}

fn kind_of(kind: Option<&Value>) -> String {
    let name = match kind {
        Some(Value::Array(kinds)) => kinds.first().and_then(Value::as_str),
        other => other.and_then(Value::as_str),
    };
    match name {
        Some("number") => "number",
        Some("integer") => "whole number",
        Some("boolean") => "true or false",
        Some("string") => "text",
        Some("array") => "list",
        _ => "table",
    }
    .into()
}

/// A value as TOML, f32 noise removed.
fn short(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(x) if f64::from(*x as f32) == *x => format!("{:?}", *x as f32),
        toml::Value::Array(items) => format!("[{}]", items.iter().map(short).collect::<Vec<_>>().join(", ")),
        toml::Value::Table(items) => {
            let items: Vec<String> = items.iter().map(|(k, v)| format!("{k} = {}", short(v))).collect();
            format!("{{ {} }}", items.join(", "))
        }
        other => other.to_string(),
    }
}

fn kind(kind: PortKind) -> &'static str {
    match kind {
        PortKind::Scalar => "scalar",
        PortKind::Color => "color",
        PortKind::Any => "scalar or color",
    }
}

/// The range of an input's constants, in words; empty where anything goes.
pub fn input_range(input: &InputSpec) -> String {
    match (input.min > f32::MIN, input.max < f32::MAX) {
        (true, true) => format!("{} to {}", input.min, input.max),
        (true, false) => format!("at least {}", input.min),
        (false, true) => format!("at most {}", input.max),
        (false, false) => String::new(),
    }
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

/// A Markdown table with its columns aligned, but for the last.
fn table<const N: usize>(out: &mut String, head: [&str; N], rows: impl Iterator<Item = [String; N]>) {
    let rows: Vec<[String; N]> = std::iter::once(head.map(str::to_owned))
        .chain(rows.map(|row| row.map(|cell| cell.replace('|', "\\|"))))
        .collect();
    let width =
        |k: usize| if k + 1 == N { 0 } else { rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0) };
    let widths: Vec<usize> = (0..N).map(width).collect();
    for (i, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, w)| format!("{cell:w$}")).collect();
        let _ = writeln!(out, "| {} |", cells.join(" | "));
        if i == 0 {
            let rule: Vec<String> = widths.iter().map(|w| "-".repeat((*w).max(3))).collect();
            let _ = writeln!(out, "| {} |", rule.join(" | "));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::build;
    use crate::node;
    use crate::preset::Document;

    #[test]
    fn every_page_tells_every_input_setting_and_output() {
        for op in node::ops() {
            let page = page(op);
            let names = op.spec.inputs.iter().map(|i| i.name).chain(op.spec.outputs.iter().map(|o| o.name));
            for name in names {
                assert!(page.contains(&format!("| `{name}`")), "{page}");
            }
            for key in (op.default)().settings().keys() {
                assert!(page.contains(&format!("| `{key}`")), "{key}:\n{page}");
            }
            assert!(index().contains(&format!("  {} ", op.spec.name)), "{}", op.spec.name);
        }
    }

    #[test]
    fn every_example_is_a_sound_preset() {
        for op in node::ops() {
            let text = format!("[nodes.image]\nop = \"disc\"\n{}", example(op));
            let document = Document::parse(op.spec.name, &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let (graph, _) = build(&document).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let node = &graph.nodes[graph.find(&format!("my_{}", op.spec.name)).expect("it is there")];
            assert_eq!(node.node.settings(), (op.default)().settings(), "{text}");
        }
    }

    #[test]
    fn a_page_reads_as_this() {
        let page = page(node::find("mix").expect("mix"));
        assert!(page.starts_with(
            "# mix\n\nMixes two images by a mask.\n\nCategory: combine. Reads the texel itself."
        ));
        let row = "| `mask` | scalar          | 0.5      | 0 to 1 |      | How much of `b`: 0 none, 1 all;";
        assert!(page.contains(row), "{page}");
    }
}
