//! What can be changed: sections and their fields, read from the schema of presets.

use serde_json::Value;

use super::setting::Setting;
use crate::base::params::alternatives;
use crate::graph;

/// Sections in the order of the window.
const SECTIONS: [&str; 8] =
    ["body", "scales", "pattern", "color", "belly", "surface", "iridescence", "material"];

/// A section of presets.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Section {
    /// Its key in presets.
    pub(super) key: &'static str,
    /// What it is about.
    pub(super) doc: String,
    /// What it holds.
    pub(super) fields: Vec<Field>,
}

/// One key of a section.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    /// The key.
    pub(super) key: String,
    /// Its name in the window.
    pub(super) label: String,
    /// What it does.
    pub(super) doc: String,
    /// Of its numbers; may be empty.
    pub(super) unit: String,
    /// What it takes.
    pub(super) kind: Kind,
    /// Where a preset does not write it; `None` where it is left out then.
    pub(super) default: Option<Setting>,
    /// Kinds of layers that read it; all of them if empty.
    pub(super) only: Vec<String>,
}

/// What a key takes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// A number in a range.
    Number {
        /// The least.
        min: f32,
        /// The greatest.
        max: f32,
        /// Only whole numbers.
        whole: bool,
    },
    /// A colour.
    Color,
    /// One of some words, each with what it means.
    Choice(Vec<(String, String)>),
    /// A switch.
    Flag,
}

/// Everything that can be changed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fields {
    /// Sections of the anatomy, and the material.
    pub(super) sections: Vec<Section>,
    /// Fields of a layer of the pattern.
    pub(super) layer: Vec<Field>,
}

impl Fields {
    /// From the schema.
    pub(super) fn new() -> Self {
        let root = graph::schema();
        let section = |key| {
            let schema = &root["properties"][key];
            Section { key, doc: doc(schema), fields: fields(&root, schema) }
        };
        let layers = resolved(&root, &root["properties"]["pattern"])
            .into_iter()
            .find_map(|s| s.pointer("/properties/layers/items"));
        let mut layer = layers.map(|items| fields(&root, items)).unwrap_or_default();
        mark_kinds(&mut layer);
        Self { sections: SECTIONS.map(section).into(), layer }
    }
}

/// A schema with what it refers to.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> Vec<&'a Value> {
    alternatives(root, schema)
}

/// The first paragraph, on one line.
fn doc(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or("");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The fields of a table that the window can show.
fn fields(root: &Value, schema: &Value) -> Vec<Field> {
    let properties = resolved(root, schema).into_iter().find_map(|s| s.get("properties")?.as_object());
    properties.into_iter().flatten().filter_map(|(key, schema)| field(root, key, schema)).collect()
}

fn field(root: &Value, key: &str, schema: &Value) -> Option<Field> {
    let all = resolved(root, schema);
    let unit = all.iter().find_map(|s| s.get("x-unit")?.as_str()).unwrap_or("").to_owned();
    Some(Field {
        key: key.to_owned(),
        label: label(key, &unit),
        doc: doc(schema),
        kind: kind(&all)?,
        default: schema.get("default").and_then(Setting::of_json),
        unit,
        only: Vec::new(),
    })
}

fn kind(all: &[&Value]) -> Option<Kind> {
    let is = |schema: &Value, word: &str| match schema.get("type") {
        Some(Value::String(t)) => t == word,
        Some(Value::Array(types)) => types.iter().any(|t| t == word),
        _ => false,
    };
    if all.iter().any(|s| s.get("format").is_some_and(|f| f == "color")) {
        return Some(Kind::Color);
    }
    let words: Vec<(String, String)> =
        all.iter().filter_map(|s| Some((s.get("const")?.as_str()?.to_owned(), doc(s)))).collect();
    if !words.is_empty() {
        return Some(Kind::Choice(words));
    }
    for schema in all {
        if is(schema, "boolean") {
            return Some(Kind::Flag);
        }
        let whole = is(schema, "integer");
        if whole || is(schema, "number") {
            let bound = |name: &str| schema.get(name).and_then(Value::as_f64).map(|x| x as f32);
            return Some(Kind::Number { min: bound("minimum")?, max: bound("maximum")?, whole });
        }
        let listed = schema.get("enum").and_then(Value::as_array).into_iter().flatten();
        let listed: Vec<_> = listed.filter_map(|w| Some((w.as_str()?.to_owned(), String::new()))).collect();
        if !listed.is_empty() {
            return Some(Kind::Choice(listed));
        }
    }
    None
}

/// A key in words; a unit that stands beside the value is not said twice.
fn label(key: &str, unit: &str) -> String {
    let suffix = match unit {
        "degrees" => "_deg",
        "mm" => "_mm",
        "nm" => "_nm",
        _ => "",
    };
    let words = key.strip_suffix(suffix).unwrap_or(key).replace('_', " ");
    let mut letters = words.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// Which kinds of layers read a field stands in the kinds' own descriptions, in backticks.
fn mark_kinds(layer: &mut [Field]) {
    let Some(Kind::Choice(kinds)) = layer.iter().find(|f| f.key == "kind").map(|f| f.kind.clone()) else {
        return;
    };
    for field in layer {
        let named = format!("`{}`", field.key);
        let readers = kinds.iter().filter(|(_, doc)| doc.contains(&named));
        field.only = readers.map(|(word, _)| word.clone()).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::builtin;
    use crate::viewer::setting::written;

    fn field(section: &str, key: &str) -> Field {
        let fields = Fields::new();
        let found = fields.sections.iter().find(|s| s.key == section).expect("a section");
        found.fields.iter().find(|f| f.key == key).cloned().expect("a field")
    }

    #[test]
    fn a_field_has_its_range_unit_default_and_doc() {
        let keel = field("scales", "keel");
        assert_eq!(keel.kind, Kind::Number { min: 0.0, max: 1.0, whole: false });
        assert_eq!((keel.unit.as_str(), keel.default), ("pitch", Some(Setting::Number(0.0))));
        assert!(keel.doc.starts_with("Height of the keel"), "{}", keel.doc);
        let rows = field("scales", "rows");
        assert_eq!(rows.kind, Kind::Number { min: 1.0, max: 1000.0, whole: true });
        assert_eq!(field("body", "diameter_mm").label, "Diameter");
        assert_eq!(field("scales", "oblique_deg").label, "Oblique");
        assert_eq!(field("scales", "lowest_rows").label, "Lowest rows");
        assert_eq!(field("color", "base").kind, Kind::Color);
        assert_eq!(field("color", "rim").default, None, "left out unless set");
        let Kind::Choice(shapes) = field("scales", "shape").kind else { panic!("a choice") };
        assert_eq!(shapes.iter().map(|s| s.0.as_str()).collect::<Vec<_>>().len(), 4);
    }

    /// Every number, colour, choice and switch of the anatomy is shown: what is not is named here.
    #[test]
    fn nothing_of_the_anatomy_is_missing() {
        let root = graph::schema();
        let fields = Fields::new();
        let mut missing = Vec::new();
        for section in &fields.sections {
            let all = resolved(&root, &root["properties"][section.key]);
            let properties = all.iter().find_map(|s| s.get("properties")?.as_object()).expect("keys");
            let shown = |key: &str| section.fields.iter().any(|f| f.key == key);
            missing.extend(properties.keys().filter(|k| !shown(k)).map(|k| format!("{}.{k}", section.key)));
        }
        assert_eq!(missing, ["pattern.layers", "material.absorption"]);
        assert!(fields.sections.iter().flat_map(|s| &s.fields).all(|f| !f.doc.is_empty()));
    }

    #[test]
    fn a_layer_shows_what_its_kind_reads() {
        let fields = Fields::new();
        let only = |key: &str| {
            let field = fields.layer.iter().find(|f| f.key == key).expect("a field");
            field.only.iter().map(String::as_str).collect::<Vec<_>>()
        };
        assert_eq!(only("taper"), ["marks"]);
        assert_eq!(only("row"), ["stripe"]);
        assert!(only("coverage").contains(&"spots") && !only("coverage").contains(&"marks"));
        assert!(only("color").is_empty(), "every kind has a colour");
    }

    /// Sliders would cut what lies outside their range.
    #[test]
    fn every_value_of_the_built_in_presets_has_a_field_that_holds_it() {
        let fields = Fields::new();
        let mut seen = 0;
        for (name, _) in builtin::BUILTIN {
            let document = builtin::document(name).expect("a built-in preset");
            for section in &fields.sections {
                for field in &section.fields {
                    let path = format!("{}.{}", section.key, field.key);
                    let Some(item) = written(&document, &path) else { continue };
                    let setting = Setting::of_item(item).expect("a value");
                    seen += 1;
                    match &field.kind {
                        Kind::Number { min, max, .. } => {
                            let x = setting.number().expect("a number");
                            assert!((*min..=*max).contains(&x), "{name} {path} {x}");
                        }
                        Kind::Color => assert!(setting.color().is_some(), "{name} {path}"),
                        Kind::Choice(words) => {
                            let word = setting.text().expect("a word");
                            assert!(words.iter().any(|w| w.0 == word), "{name} {path} {word}");
                        }
                        Kind::Flag => assert!(matches!(setting, Setting::Flag(_)), "{name} {path}"),
                    }
                }
            }
        }
        assert!(seen > 500, "{seen}");
    }
}
