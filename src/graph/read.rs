//! From a document to a graph: the keys that are no anatomy, and what both levels make together.
//!
//! | Key | Meaning |
//! | --- | --- |
//! | `name`, `common_name`, `description` | what it is called; nothing that it makes depends on them |
//! | `seed` | the individual, a whole number |
//! | `[tile]` | `girth_mm`, `length_mm`: the tile's physical size, where the anatomy does not give it |
//! | `[nodes.NAME]` | a node: `op`, its inputs and its settings; replaces the anatomy's node of that name. Without `op` it changes only the keys it names |
//! | `[maps]` | `KIND = input`, or `KIND = { from = input, range = [low, high] }` |
//! | `[material]` | the skin's [`SkinOptics`], for whoever renders it; no map depends on it |
//!
//! An *input* is a number, a colour `"#rrggbb"`, a linear colour `[r, g, b]`, or an output: `"node"` or `"node.port"`.

use std::collections::BTreeMap;

use super::Graph;
use super::build::{BuildError, MapDraft, Sketch, resolve};
use super::from_document::{self, ABOUT};
use crate::base::{LinearRgb, MapKind, Srgb8};
use crate::node::draft::{Draft, InputDraft, NodeDraft, Wire};
use crate::node::{self, Op};
use crate::optics::SkinOptics;
use crate::preset::{
    Diagnostic, Diagnostics, Document, Item, PresetError, SourceMap, Span, Table, Value, section, suggest,
};
use crate::skin::{self, Skin};

/// Keys of a preset's root that this room reads.
pub const KEYS: [&str; 5] = ["seed", "tile", "nodes", "maps", "material"];

/// Most nodes of a graph.
pub const MAX_NODES: usize = 10_000;

/// The tile's physical size.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tile {
    /// Width of the tile: the whole girth of the body.
    #[schemars(range(min = 0.1, max = 10_000.0), extend("x-unit" = "mm"))]
    pub girth_mm: f32,
    /// Height of the tile: the length of body that it covers.
    #[schemars(range(min = 0.1, max = 10_000.0), extend("x-unit" = "mm"))]
    pub length_mm: f32,
}

impl Default for Tile {
    fn default() -> Self {
        Self { girth_mm: 100.0, length_mm: 100.0 }
    }
}

/// Build the graph of a document: the anatomy lowered, if it has any, and its own nodes over it. Warnings come along.
///
/// # Errors
/// Every problem of the document at once.
pub fn build(document: &Document) -> Result<(Graph, Vec<Diagnostic>), PresetError> {
    let mut diagnostics = Diagnostics::new();
    let mut sketch = Sketch {
        name: from_document::name(document, &mut diagnostics),
        seed: 0,
        size_mm: [Tile::default().girth_mm, Tile::default().length_mm],
        draft: Draft::default(),
        maps: BTreeMap::new(),
    };
    let known: Vec<&str> = skin::SECTIONS.iter().chain(&KEYS).chain(&ABOUT).copied().collect();
    for (key, _) in document.root.iter().filter(|(key, _)| !known.contains(&key.get_ref().as_str())) {
        let diagnostic = Diagnostic::error("unknown-key", format!("unknown key `{}`", key.get_ref()));
        diagnostics.push(hint(diagnostic.at(key.span(), ""), key.get_ref(), &known));
    }
    if let Some(seed) = document.root.get("seed") {
        let read =
            section::read_with(seed, "the preset", &|d| serde::Deserialize::deserialize(d), &mut diagnostics);
        sketch.seed = read.unwrap_or(0);
    }
    let anatomy = read_anatomy(document, &mut sketch, &mut diagnostics);
    if let Some(tile) = document.root.get("tile") {
        let read: Option<Tile> = section::read(tile, "[tile]", &mut diagnostics);
        if let Some(tile) = read {
            sketch.size_mm = [tile.girth_mm, tile.length_mm];
        }
    }
    let material = document.root.get("material");
    let optics = material.and_then(|m| section::read::<SkinOptics>(m, "[material]", &mut diagnostics));
    read_nodes(document, &mut sketch.draft, &mut diagnostics);
    read_maps(document, &mut sketch.maps, &mut diagnostics);
    let failed = |diagnostics: Diagnostics| {
        Err(PresetError { diagnostics: diagnostics.into_list(), sources: document.sources.clone() })
    };
    // Without the anatomy's nodes, every reader of them would be told.
    if !anatomy {
        return failed(diagnostics);
    }
    match resolve(&sketch) {
        Ok(graph) if !diagnostics.has_errors() => {
            let optics = optics.unwrap_or_default();
            Ok((Graph { optics, ..graph }, diagnostics.into_list()))
        }
        Ok(_) => failed(diagnostics),
        Err(mut errors) => {
            // What is wrong with a node has been told; that its readers miss it has not to be.
            let written = document.root.get("nodes").and_then(|nodes| nodes.get_ref().as_table());
            errors.retain(|e| {
                let missed = e.candidates.as_ref().filter(|_| e.code == "unknown-node").map(|(word, _)| word);
                missed.is_none_or(|word| written.is_none_or(|nodes| !nodes.contains_key(word.as_str())))
            });
            diagnostics.extend(errors.iter().map(|e| e.to_diagnostic(&document.sources)));
            failed(diagnostics)
        }
    }
}

/// Read the anatomy's sections and lower them; a preset without any is nodes only. True if nothing is wrong with it.
fn read_anatomy(document: &Document, sketch: &mut Sketch, diagnostics: &mut Diagnostics) -> bool {
    let is_section = |key: &str| skin::SECTIONS.contains(&key);
    let sections: Table = document
        .root
        .iter()
        .filter(|(key, _)| is_section(key.get_ref()))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    if sections.is_empty() {
        return true;
    }
    // One section at a time, so that messages name it.
    let before = diagnostics.len();
    for (key, value) in &sections {
        let alone: Table = [(key.clone(), value.clone())].into_iter().collect();
        let alone = toml::Spanned::new(value.span(), Item::Table(alone));
        let _: Option<Skin> = section::read(&alone, &format!("[{}]", key.get_ref()), diagnostics);
    }
    if diagnostics.len() > before {
        return false;
    }
    let start = document.sources.sources().first().map_or(0, |s| s.base);
    let anatomy = toml::Spanned::new(start..start, Item::Table(sections));
    let Some(skin) = section::read::<Skin>(&anatomy, "the preset", diagnostics) else { return false };
    match skin::lower(&skin) {
        Ok(lowered) => {
            let map = |(wire, range)| MapDraft { wire, range, span: None };
            sketch.draft = lowered.draft;
            sketch.maps = lowered.maps.into_iter().map(|(kind, m)| (kind, map(m))).collect();
            sketch.size_mm = lowered.size_mm;
            true
        }
        Err(errors) => {
            diagnostics.extend(errors.iter().map(|e| section::range_error(e, &anatomy)));
            false
        }
    }
}

impl BuildError {
    /// The problem as a diagnostic; where it stands nowhere, it is put at the start of the preset.
    pub fn to_diagnostic(&self, sources: &SourceMap) -> Diagnostic {
        let start = sources.sources().first().map_or(0, |s| s.base);
        let span = self.span.clone().unwrap_or(start..start);
        let diagnostic = Diagnostic::error(self.code, &self.message).at(span, "");
        let near = self
            .candidates
            .as_ref()
            .and_then(|(word, candidates)| suggest::nearest(word, candidates.iter().map(String::as_str)));
        match near {
            Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
            None if self.help.is_empty() => diagnostic,
            None => diagnostic.help(&self.help),
        }
    }
}

fn hint(diagnostic: Diagnostic, word: &str, known: &[&str]) -> Diagnostic {
    match suggest::help(word, known) {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

fn table<'a>(document: &'a Document, key: &str, diagnostics: &mut Diagnostics) -> Option<&'a Table> {
    let value = document.root.get(key)?;
    let table = value.get_ref().as_table();
    if table.is_none() {
        let message = format!("`{key}` is {}, not a table", value.get_ref().kind());
        diagnostics.push(Diagnostic::error("wrong-type", message).at(value.span(), "expected a table"));
    }
    table
}

/// Read `[nodes.*]` over the nodes that are in `draft`.
pub fn read_nodes(document: &Document, draft: &mut Draft, diagnostics: &mut Diagnostics) {
    let Some(nodes) = table(document, "nodes", diagnostics) else { return };
    if nodes.len() > MAX_NODES {
        let message = format!("the preset has {} nodes; at most {MAX_NODES} are taken", nodes.len());
        diagnostics.push(Diagnostic::error("too-many", message).at(document.root["nodes"].span(), ""));
        return;
    }
    // Order by name first, so that replacing is a look-up.
    let mut places: BTreeMap<String, usize> =
        draft.nodes.iter().enumerate().map(|(i, n)| (n.name.clone(), i)).collect();
    for (name, value) in nodes {
        let place = places.get(name.get_ref()).copied();
        let Some(node) = read_node(name, value, place.map(|i| &draft.nodes[i]), diagnostics) else {
            continue;
        };
        match place {
            Some(i) => draft.nodes[i] = node,
            None => {
                places.insert(node.name.clone(), draft.nodes.len());
                draft.nodes.push(node);
            }
        }
    }
}

fn read_node(
    name: &toml::Spanned<String>,
    value: &Value,
    old: Option<&NodeDraft>,
    diagnostics: &mut Diagnostics,
) -> Option<NodeDraft> {
    let word = name.get_ref();
    let simple = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if word.is_empty() || word.len() > 100 || !word.chars().all(simple) {
        let message = format!("`{}` cannot name a node", word.chars().take(100).collect::<String>());
        let help = "use letters, digits, `_` and `-`";
        diagnostics.push(Diagnostic::error("bad-name", message).at(name.span(), "").help(help));
        return None;
    }
    let Some(keys) = value.get_ref().as_table() else {
        let message = format!("node {word} is {}, not a table", value.get_ref().kind());
        let help = format!("write [nodes.{word}] and below it op = \"…\"");
        diagnostics.push(Diagnostic::error("wrong-type", message).at(value.span(), "").help(help));
        return None;
    };
    let op = find_op(name, value, keys, old, diagnostics)?;
    // A table without `op` changes the node that is there.
    let old = old.filter(|_| !keys.contains_key("op"));
    let before = diagnostics.len();
    let mut inputs: Vec<InputDraft> = old.map(|n| n.inputs.clone()).unwrap_or_default();
    let mut settings = Table::new();
    for (key, value) in keys.iter().filter(|(key, _)| key.get_ref() != "op") {
        if op.spec.input(key.get_ref()).is_none() {
            settings.insert(key.clone(), value.clone());
        } else if let Some(wire) = read_wire(value, &format!("{word}.{}", key.get_ref()), diagnostics) {
            inputs.retain(|i| i.name != *key.get_ref());
            inputs.push(InputDraft { name: key.get_ref().clone(), wire, span: Some(value.span()) });
        }
    }
    let what = format!("node {word} ({})", op.spec.name);
    let node = read_settings(op, &what, value, settings, old, diagnostics)?;
    (diagnostics.len() == before).then(|| NodeDraft {
        name: word.clone(),
        node,
        inputs,
        span: Some(value.span()),
    })
}

fn find_op(
    name: &toml::Spanned<String>,
    value: &Value,
    keys: &Table,
    old: Option<&NodeDraft>,
    diagnostics: &mut Diagnostics,
) -> Option<&'static Op> {
    let word = name.get_ref();
    let Some(op) = keys.get("op") else {
        let old = old.and_then(|n| node::find(n.node.spec().name));
        if old.is_none() {
            let message = format!("node {word} has no `op`");
            let help = "add op = \"…\"; `ophidian nodes` lists the operations";
            diagnostics.push(Diagnostic::error("missing-key", message).at(value.span(), "").help(help));
        }
        return old;
    };
    let Some(text) = op.get_ref().as_str() else {
        let message = format!("node {word}: op is {}, not a name", op.get_ref().kind());
        diagnostics.push(Diagnostic::error("wrong-type", message).at(op.span(), "expected text in quotes"));
        return None;
    };
    let found = node::find(text);
    if found.is_none() {
        let names: Vec<&str> = node::ops().map(|op| op.spec.name).collect();
        let diagnostic = Diagnostic::error("unknown-op", format!("there is no operation `{text}`"));
        let help = match suggest::nearest(text, names) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`ophidian nodes` lists the operations".into(),
        };
        diagnostics.push(diagnostic.at(op.span(), "").help(help));
    }
    found
}

fn read_settings(
    op: &'static Op,
    what: &str,
    node: &Value,
    mut settings: Table,
    old: Option<&NodeDraft>,
    diagnostics: &mut Diagnostics,
) -> Option<std::sync::Arc<dyn crate::node::Node>> {
    let schema = (op.schema)();
    let properties = schema.get("properties").and_then(|p| p.as_object());
    let own: Vec<&str> = properties.into_iter().flat_map(|p| p.keys().map(String::as_str)).collect();
    let unknown: Vec<_> = settings.keys().filter(|k| !own.contains(&k.get_ref().as_str())).cloned().collect();
    if !unknown.is_empty() {
        let inputs = op.spec.inputs.iter().map(|i| i.name);
        let known: Vec<&str> = inputs.chain(own.iter().copied()).collect();
        for key in &unknown {
            let message = format!("unknown key `{}` in {what}", key.get_ref());
            let diagnostic = Diagnostic::error("unknown-key", message).at(key.span(), "");
            diagnostics.push(hint(diagnostic, key.get_ref(), &known));
            settings.remove(key.get_ref().as_str());
        }
    }
    if let Some(old) = old {
        for (key, value) in old.node.settings() {
            if !settings.contains_key(key.as_str()) {
                settings.insert(toml::Spanned::new(node.span(), key), unspanned(&value, node.span())?);
            }
        }
    }
    let settings = toml::Spanned::new(node.span(), Item::Table(settings));
    let typed = section::read_with(&settings, what, &|d| (op.parse)(d), diagnostics);
    let in_range = section::check(&schema, &settings, diagnostics);
    let typed = typed.filter(|_| in_range && unknown.is_empty())?;
    let errors = typed.check();
    diagnostics.extend(errors.iter().map(|e| section::range_error(e, &settings)));
    errors.is_empty().then_some(typed)
}

/// A value that the anatomy made, placed where it is changed.
fn unspanned(value: &toml::Value, span: Span) -> Option<Value> {
    let text = format!("x = {value}");
    let parsed = Document::parse("", &text).ok()?;
    let mut value = parsed.root.get("x")?.clone();
    place(&mut value, &span);
    Some(value)
}

fn place(value: &mut Value, span: &Span) {
    match value.get_mut() {
        Item::Array(items) => items.iter_mut().for_each(|v| place(v, span)),
        Item::Table(table) => table.iter_mut().for_each(|(_, v)| place(v, span)),
        _ => {}
    }
    let item = std::mem::replace(value.get_mut(), Item::Boolean(false));
    *value = toml::Spanned::new(span.clone(), item);
}

/// Read an input's value; `what` names it in messages.
pub fn read_wire(value: &Value, what: &str, diagnostics: &mut Diagnostics) -> Option<Wire> {
    let item = value.get_ref();
    let number = |item: &Item| item.as_f64().map(|x| x as f32);
    match item {
        Item::Integer(_) | Item::Float(_) => {
            let x = number(item).filter(|x| x.is_finite());
            if x.is_none() {
                let message = format!("{what} is not a finite number");
                let diagnostic = Diagnostic::error("out-of-range", message).at(value.span(), "");
                diagnostics.push(diagnostic.help("write a finite number"));
            }
            return x.map(Wire::Scalar);
        }
        Item::String(text) if text.starts_with('#') => match text.parse::<Srgb8>() {
            Ok(color) => return Some(color.into()),
            Err(error) => {
                diagnostics.push(Diagnostic::error("bad-color", error.to_string()).at(value.span(), ""));
                return None;
            }
        },
        Item::String(text) => return Some(Wire::Output(text.clone())),
        Item::Array(items) if items.len() == 3 => {
            let channels: Vec<f32> =
                items.iter().filter_map(|v| number(v.get_ref())).filter(|x| x.is_finite()).collect();
            if let Ok(channels) = <[f32; 3]>::try_from(channels) {
                return Some(LinearRgb(channels).into());
            }
        }
        _ => {}
    }
    let message = format!("{what} is {}", item.kind());
    let help = "write a number, a colour \"#rrggbb\" or [r, g, b], or a node's name";
    diagnostics.push(Diagnostic::error("wrong-type", message).at(value.span(), "").help(help));
    None
}

/// Read `[maps]` over the maps that are in `maps`.
pub fn read_maps(document: &Document, maps: &mut BTreeMap<MapKind, MapDraft>, diagnostics: &mut Diagnostics) {
    let Some(table) = table(document, "maps", diagnostics) else { return };
    for (key, value) in table {
        let word = key.get_ref();
        let Some(kind) = MapKind::ALL.into_iter().find(|k| k.name() == word) else {
            let diagnostic = Diagnostic::error("unknown-key", format!("there is no map `{word}`"));
            let known = MapKind::ALL.map(MapKind::name);
            diagnostics.push(hint(diagnostic.at(key.span(), ""), word, &known));
            continue;
        };
        let before = diagnostics.len();
        let mut range = maps.get(&kind).map_or(kind.default_range(), |m| m.range);
        let mut wire = maps.get(&kind).map(|m| m.wire.clone());
        match value.get_ref() {
            Item::Table(keys) => {
                for (key, inner) in keys {
                    match key.get_ref().as_str() {
                        "from" => wire = read_wire(inner, &format!("maps.{word}.from"), diagnostics),
                        "range" => {
                            let read = section::read_with(
                                inner,
                                "[maps]",
                                &|d| serde::Deserialize::deserialize(d),
                                diagnostics,
                            );
                            range = read.unwrap_or(range);
                        }
                        other => {
                            let message = format!("unknown key `{other}` in maps.{word}");
                            let diagnostic = Diagnostic::error("unknown-key", message).at(key.span(), "");
                            diagnostics.push(hint(diagnostic, other, &["from", "range"]));
                        }
                    }
                }
            }
            _ => wire = read_wire(value, &format!("maps.{word}"), diagnostics),
        }
        if diagnostics.len() > before {
            continue;
        }
        let [low, high] = range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            let message = format!("maps.{word}: the range {low} to {high} is empty");
            let span = section::span_of(value, "range");
            diagnostics.push(
                Diagnostic::error("out-of-range", message)
                    .at(span, "")
                    .help("write range = [low, high] with low < high"),
            );
            continue;
        }
        match wire {
            Some(wire) => {
                maps.insert(kind, MapDraft { wire, range, span: Some(value.span()) });
            }
            None => {
                let message = format!("maps.{word} has no `from`");
                let help = "add from = \"node\"";
                diagnostics.push(Diagnostic::error("missing-key", message).at(value.span(), "").help(help));
            }
        }
    }
}
