//! Checks of a node's settings against what its struct declares.

use schemars::Schema;
use serde_json::Value;

/// One setting that cannot stand.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ParamError {
    /// The setting's key.
    pub key: String,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl ParamError {
    /// An error of the setting `key`.
    pub fn new(key: &str, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: help.into() }
    }
}

/// Hold every number of `settings` (and of its arrays) against `minimum` and `maximum` in `schema`; also refuse
/// numbers that are not finite.
pub fn check_ranges(schema: &Schema, settings: &toml::Table) -> Vec<ParamError> {
    let properties = schema.get("properties").and_then(Value::as_object);
    let mut errors = Vec::new();
    for (key, value) in settings {
        let property = properties.and_then(|p| p.get(key));
        check_value(key, property, value, &mut errors);
    }
    errors
}

fn check_value(key: &str, schema: Option<&Value>, value: &toml::Value, errors: &mut Vec<ParamError>) {
    let number = match value {
        toml::Value::Float(x) => *x,
        toml::Value::Integer(x) => *x as f64,
        toml::Value::Array(items) => {
            let schema = schema.and_then(|s| s.get("items"));
            for item in items {
                check_value(key, schema, item, errors);
            }
            return;
        }
        _ => return,
    };
    let bound = |name: &str| schema.and_then(|s| s.get(name)).and_then(Value::as_f64);
    let (min, max) = (bound("minimum"), bound("maximum"));
    let unit = schema.and_then(|s| s.get("x-unit")).and_then(Value::as_str).unwrap_or("");
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    // f32 settings print as f64 with noise digits; the f32 form is what the author typed.
    let shown = number as f32;
    if !number.is_finite() {
        errors.push(ParamError::new(
            key,
            format!("{key} = {number} is not a number"),
            "write a finite number",
        ));
    } else if min.is_some_and(|min| shown < min as f32) || max.is_some_and(|max| shown > max as f32) {
        let range = match (min, max) {
            (Some(min), Some(max)) => format!("{min} to {max}{unit}"),
            (Some(min), None) => format!("at least {min}{unit}"),
            (None, Some(max)) => format!("at most {max}{unit}"),
            (None, None) => unreachable!("one bound failed"),
        };
        errors.push(ParamError::new(
            key,
            format!("{key} = {shown} is out of range"),
            format!("allowed: {range}"),
        ));
    }
}
