//! One JSON Schema (draft 2020-12) for the whole preset language, for editors that complete and check TOML.

use serde_json::{Map, Value, json};

use super::read::Tile;
use super::reference::input_range;
use crate::base::MapKind;
use crate::node::{self, Fallback, InputSpec, Op, PortKind};
use crate::optics::SkinOptics;
use crate::skin::Skin;

/// The schema of a preset.
pub fn schema() -> Value {
    let mut defs = Map::new();
    let mut properties = Map::new();
    properties.insert(
        "include".into(),
        json!({
            "description": "Presets that this one is laid over; of several the later wins.",
            "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }],
        }),
    );
    for (key, description) in [
        ("name", "Name in file names; the file's own name unless set. Letters, digits, `_` and `-`."),
        ("common_name", "What the animal is called."),
        ("description", "What it looks like, in a sentence."),
    ] {
        properties.insert(key.into(), json!({ "description": description, "type": "string" }));
    }
    properties.insert(
        "seed".into(),
        json!({
            "description": "The individual: another seed is another animal of the same species.",
            "type": "integer",
            "minimum": 0,
            "default": 0,
        }),
    );
    section(schemars::schema_for!(Skin).to_value(), "skin", None, &mut properties, &mut defs);
    section(schemars::schema_for!(Tile).to_value(), "tile", Some("tile"), &mut properties, &mut defs);
    let material = schemars::schema_for!(SkinOptics).to_value();
    section(material, "material", Some("material"), &mut properties, &mut defs);

    inputs(&mut defs);
    let mut ops = vec![json!({
        "description": "Changes keys of a node that the anatomy made.",
        "not": { "required": ["op"] },
    })];
    for op in node::ops() {
        let name = format!("node.{}", op.spec.name);
        let schema = node_schema(op, &name, &mut defs);
        defs.insert(name.clone(), schema);
        ops.push(json!({ "$ref": format!("#/$defs/{name}") }));
    }
    defs.insert("node".into(), json!({ "type": "object", "oneOf": ops }));
    properties.insert(
        "nodes".into(),
        json!({
            "description": "Nodes by name, added to the anatomy's or in place of them.",
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z0-9_-]{1,100}$" },
            "additionalProperties": { "$ref": "#/$defs/node" },
        }),
    );
    properties.insert("maps".into(), maps());
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Ophidian preset",
        "description": "A snake's skin: its anatomy, its nodes, or both.",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
        "$defs": defs,
    })
}

/// Add a generated schema: as the property `key`, or (without one) each of its properties at the root. Its
/// definitions get `prefix`, so that two structs of one name in different rooms stay apart.
fn section(
    mut schema: Value,
    prefix: &str,
    key: Option<&str>,
    properties: &mut Map<String, Value>,
    defs: &mut Map<String, Value>,
) {
    take_defs(&mut schema, prefix, defs);
    match (key, schema.as_object_mut()) {
        (Some(key), Some(object)) => {
            object.remove("$schema");
            properties.insert(key.into(), schema);
        }
        (None, Some(object)) => {
            if let Some(Value::Object(own)) = object.remove("properties") {
                properties.extend(own);
            }
        }
        _ => {}
    }
}

/// Move `$defs` of `schema` to `defs` under `prefix`, and its references along.
fn take_defs(schema: &mut Value, prefix: &str, defs: &mut Map<String, Value>) {
    let own = schema.as_object_mut().and_then(|o| o.remove("$defs"));
    rename_refs(schema, prefix);
    if let Some(Value::Object(own)) = own {
        for (name, mut def) in own {
            rename_refs(&mut def, prefix);
            defs.insert(format!("{prefix}.{name}"), def);
        }
    }
}

fn rename_refs(schema: &mut Value, prefix: &str) {
    match schema {
        Value::Object(object) => {
            for (key, value) in object {
                match value {
                    Value::String(target) if key == "$ref" => {
                        *target = target.replacen("#/$defs/", &format!("#/$defs/{prefix}."), 1);
                    }
                    _ => rename_refs(value, prefix),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| rename_refs(item, prefix)),
        _ => {}
    }
}

/// What an input's key takes beside a number.
fn inputs(defs: &mut Map<String, Value>) {
    defs.insert(
        "output".into(),
        json!({
            "type": "string",
            "pattern": "^[A-Za-z0-9_-]+(\\.[A-Za-z0-9_]+)?$",
            "description": "A node's output: \"node\" (its first) or \"node.port\".",
        }),
    );
    defs.insert(
        "color".into(),
        json!({
            "type": "string",
            "format": "color",
            "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$",
            "description": "An sRGB colour, \"#rrggbb\".",
        }),
    );
    defs.insert(
        "linear".into(),
        json!({
            "type": "array",
            "items": { "type": "number" },
            "minItems": 3,
            "maxItems": 3,
            "description": "A linear colour [r, g, b].",
        }),
    );
}

fn input(spec: &InputSpec) -> Value {
    let mut number = json!({ "type": "number" });
    if spec.min > f32::MIN {
        number["minimum"] = json!(round(spec.min));
    }
    if spec.max < f32::MAX {
        number["maximum"] = json!(round(spec.max));
    }
    let mut kinds = vec![number, json!({ "$ref": "#/$defs/output" })];
    if spec.kind != PortKind::Scalar {
        kinds.push(json!({ "$ref": "#/$defs/color" }));
        kinds.push(json!({ "$ref": "#/$defs/linear" }));
    }
    let mut description = spec.doc.to_owned();
    if !spec.unit.is_empty() {
        description += &format!(" Unit: {}.", spec.unit);
    }
    let range = input_range(spec);
    if !range.is_empty() {
        description += &format!(" Range: {range}.");
    }
    let mut schema = json!({ "description": description, "anyOf": kinds });
    match spec.fallback {
        Fallback::Required => {}
        Fallback::Scalar(v) => schema["default"] = json!(round(v)),
        Fallback::Color(c) => schema["default"] = json!(c.map(round)),
    }
    if !spec.unit.is_empty() {
        schema["x-unit"] = json!(spec.unit);
    }
    schema
}

/// The f64 that prints as the f32 does.
fn round(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

fn node_schema(op: &Op, name: &str, defs: &mut Map<String, Value>) -> Value {
    let mut settings = (op.schema)().to_value();
    take_defs(&mut settings, name, defs);
    let mut properties = Map::new();
    properties.insert("op".into(), json!({ "const": op.spec.name, "description": op.spec.summary }));
    for spec in op.spec.inputs {
        properties.insert(spec.name.into(), input(spec));
    }
    if let Some(own) = settings.get_mut("properties").and_then(Value::as_object_mut) {
        properties.append(own);
    }
    let required = op.spec.inputs.iter().filter(|i| i.fallback == Fallback::Required).map(|i| i.name);
    let required: Vec<&str> = std::iter::once("op").chain(required).collect();
    json!({
        "type": "object",
        "title": op.spec.name,
        "description": op.spec.summary,
        "additionalProperties": false,
        "required": required,
        "properties": properties,
    })
}

fn maps() -> Value {
    let from = json!({
        "description": "What the map shows.",
        "anyOf": [
            { "type": "number" },
            { "$ref": "#/$defs/output" },
            { "$ref": "#/$defs/color" },
            { "$ref": "#/$defs/linear" },
        ],
    });
    let range = json!({
        "description": "The values, in the map's unit, that files of whole numbers store as 0 and 1; 0 to 1 for most maps unless set, -1 to 1 for normal and curvature, 0 to 1000 for iridescence.",
        "type": "array",
        "items": { "type": "number" },
        "minItems": 2,
        "maxItems": 2,
    });
    let map = json!({
        "anyOf": [
            from,
            {
                "type": "object",
                "additionalProperties": false,
                "properties": { "from": from, "range": range },
            },
        ],
    });
    let properties: Map<String, Value> =
        MapKind::ALL.iter().map(|k| (k.name().to_owned(), map.clone())).collect();
    json!({
        "description": "The maps of the texture set, each from a node.",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(object) => {
                found.extend(object.get("$ref").and_then(Value::as_str));
                object.values().for_each(|v| references(v, found));
            }
            Value::Array(items) => items.iter().for_each(|v| references(v, found)),
            _ => {}
        }
    }

    #[test]
    fn every_reference_of_the_schema_resolves() {
        let schema = schema();
        let mut found = Vec::new();
        references(&schema, &mut found);
        assert!(found.len() > crate::node::ops().count());
        for target in found {
            let pointer = target.strip_prefix('#').expect("a local reference");
            assert!(schema.pointer(pointer).is_some(), "{target}");
        }
    }

    #[test]
    fn every_operation_and_section_is_in_the_schema_with_docs() {
        let schema = schema();
        for key in crate::graph::read::KEYS {
            assert!(schema["properties"].get(key).is_some(), "{key}");
        }
        for op in crate::node::ops() {
            let node = &schema["$defs"][format!("node.{}", op.spec.name)];
            let properties = node["properties"].as_object().expect("properties");
            let count = 1 + op.spec.inputs.len() + (op.default)().settings().len();
            assert!(properties.len() >= count, "{}: {properties:?}", op.spec.name);
            for (key, property) in properties {
                assert!(property.get("description").is_some(), "{}.{key} has no description", op.spec.name);
            }
        }
    }
}
