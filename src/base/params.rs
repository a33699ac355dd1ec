//! Checks of settings against what their struct declares through its JSON Schema.

use schemars::Schema;
use serde_json::Value;

/// One setting that cannot stand.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ParamError {
    /// The setting's key; a path such as `stops[2].position` for a nested one.
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

/// Hold every number of `settings` (also in nested tables and arrays) against `minimum` and `maximum` in `schema`,
/// and the length of every array against `minItems` and `maxItems`; also refuse numbers that are not finite.
pub fn check_ranges(schema: &Schema, settings: &toml::Table) -> Vec<ParamError> {
    let mut check = Check { root: schema.as_value(), errors: Vec::new() };
    let schemas = alternatives(check.root, schema.as_value());
    for (key, value) in settings {
        check.value(key, &check.property(&schemas, key), value, "");
    }
    check.errors
}

/// The plain schemas that `schema`, a part of `root`, may stand for: references followed, alternatives side by side.
pub fn alternatives<'a>(root: &'a Value, schema: &'a Value) -> Vec<&'a Value> {
    let mut found = Vec::new();
    let mut open = vec![schema];
    // A schema may refer to itself; no honest one refers so often.
    for _ in 0..256 {
        let Some(next) = open.pop() else { break };
        found.push(next);
        if let Some(target) = next.get("$ref").and_then(Value::as_str) {
            open.extend(target.strip_prefix('#').and_then(|p| root.pointer(p)));
        }
        for word in ["anyOf", "oneOf", "allOf"] {
            open.extend(next.get(word).and_then(Value::as_array).into_iter().flatten().rev());
        }
    }
    found
}

struct Check<'a> {
    root: &'a Value,
    errors: Vec<ParamError>,
}

impl<'a> Check<'a> {
    /// What `schemas` say of the key of a table.
    fn property(&self, schemas: &[&'a Value], key: &str) -> Vec<&'a Value> {
        let named = schemas.iter().filter_map(|s| s.get("properties")?.get(key));
        let mut found: Vec<&Value> = named.flat_map(|s| alternatives(self.root, s)).collect();
        if found.is_empty() {
            let other = schemas.iter().filter_map(|s| s.get("additionalProperties"));
            found = other.flat_map(|s| alternatives(self.root, s)).collect();
        }
        found
    }

    /// What `schemas` say of the item of an array.
    fn item(&self, schemas: &[&'a Value], index: usize) -> Vec<&'a Value> {
        let of = |s: &&'a Value| s.get("prefixItems").and_then(|p| p.get(index)).or_else(|| s.get("items"));
        schemas.iter().filter_map(of).flat_map(|s| alternatives(self.root, s)).collect()
    }

    fn value(&mut self, path: &str, schemas: &[&'a Value], value: &toml::Value, unit: &'a str) {
        let own = schemas.iter().find_map(|s| s.get("x-unit").and_then(Value::as_str));
        let unit = own.unwrap_or(unit);
        match value {
            toml::Value::Float(x) => self.number(path, schemas, *x, unit),
            toml::Value::Integer(x) => self.number(path, schemas, *x as f64, unit),
            toml::Value::Array(items) => {
                self.length(path, schemas, items.len());
                for (i, item) in items.iter().enumerate() {
                    self.value(&format!("{path}[{i}]"), &self.item(schemas, i), item, unit);
                }
            }
            toml::Value::Table(table) => {
                for (key, item) in table {
                    self.value(&format!("{path}.{key}"), &self.property(schemas, key), item, "");
                }
            }
            _ => {}
        }
    }

    fn number(&mut self, path: &str, schemas: &[&Value], number: f64, unit: &str) {
        // f32 settings print as f64 with noise digits; the f32 form is what the author typed.
        let shown = number as f32;
        if !number.is_finite() || (!shown.is_finite() && number.abs() < f64::MAX) {
            let message = format!("{path} = {number} is not a finite number");
            self.errors.push(ParamError::new(path, message, "write a finite number"));
            return;
        }
        let range = |schema: &Value| {
            let bound = |name: &str| schema.get(name).and_then(Value::as_f64).map(|x| x as f32);
            (bound("minimum"), bound("maximum"))
        };
        let inside = |(min, max): (Option<f32>, Option<f32>)| {
            min.is_none_or(|m| shown >= m) && max.is_none_or(|m| shown <= m)
        };
        let ranges: Vec<_> = schemas.iter().map(|s| range(s)).filter(|r| *r != (None, None)).collect();
        if ranges.is_empty() || ranges.iter().any(|r| inside(*r)) {
            return;
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let allowed = match ranges[0] {
            (Some(min), Some(max)) => format!("{min} to {max}{unit}"),
            (Some(min), None) => format!("at least {min}{unit}"),
            (_, Some(max)) => format!("at most {max}{unit}"),
            (None, None) => return,
        };
        self.errors.push(ParamError::new(
            path,
            format!("{path} = {shown} is out of range"),
            format!("allowed: {allowed}"),
        ));
    }

    fn length(&mut self, path: &str, schemas: &[&Value], length: usize) {
        let bound = |name: &str| schemas.iter().find_map(|s| s.get(name).and_then(Value::as_u64));
        let (min, max) = (bound("minItems").unwrap_or(0), bound("maxItems").unwrap_or(u64::MAX));
        if (min..=max).contains(&(length as u64)) {
            return;
        }
        let entries = |n: u64| if n == 1 { "1 entry".into() } else { format!("{n} entries") };
        let allowed = match (min, max) {
            (min, max) if min == max => entries(min),
            (min, u64::MAX) => format!("at least {}", entries(min)),
            (0, max) => format!("at most {}", entries(max)),
            (min, max) => format!("{min} to {}", entries(max)),
        };
        self.errors.push(ParamError::new(
            path,
            format!("{path} has {}", entries(length as u64)),
            format!("allowed: {allowed}"),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use schemars::JsonSchema;

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    struct Settings {
        #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
        size: f32,
        #[schemars(range(min = 1))]
        count: Option<u32>,
        #[schemars(length(min = 2, max = 3))]
        stops: Vec<Stop>,
        inner: Option<Inner>,
        pair: [f32; 2],
        #[schemars(inner(range(max = 5.0)), extend("x-unit" = "mm"))]
        lengths: Vec<f32>,
        kind: Kind,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    struct Stop {
        #[schemars(range(min = 0.0, max = 1.0))]
        position: f32,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    struct Inner {
        #[schemars(range(max = -1.0))]
        depth: f32,
    }

    #[derive(JsonSchema)]
    #[allow(dead_code, reason = "only its schema is used")]
    #[schemars(rename_all = "snake_case")]
    enum Kind {
        Plain,
        Spots {
            #[schemars(range(min = 2.0))]
            radius: f32,
        },
    }

    fn check(text: &str) -> Vec<String> {
        let settings = text.parse().expect("the test's TOML");
        check_ranges(&schemars::schema_for!(Settings), &settings)
            .into_iter()
            .map(|e| format!("{}; {}", e.message, e.help))
            .collect()
    }

    #[test]
    fn values_inside_pass() {
        assert_eq!(
            check(
                "size = 1\ncount = 1\nstops = [{position = 0}, {position = 1}]\ninner = {depth = -1.0}\n\
                 pair = [-9, 9]\nlengths = [5]\nkind = {spots = {radius = 2}}"
            ),
            [""; 0]
        );
        assert_eq!(check("kind = 'plain'\nunknown = 3"), [""; 0]);
    }

    #[test]
    fn numbers_outside_are_told_with_path_range_and_unit() {
        assert_eq!(check("size = 1.01"), ["size = 1.01 is out of range; allowed: 0 to 1 tile"]);
        assert_eq!(check("count = 0"), ["count = 0 is out of range; allowed: at least 1"]);
        assert_eq!(
            check("stops = [{position = 0}, {position = 2}]"),
            ["stops[1].position = 2 is out of range; allowed: 0 to 1"]
        );
        assert_eq!(
            check("inner = {depth = 0.5}"),
            ["inner.depth = 0.5 is out of range; allowed: at most -1"]
        );
        assert_eq!(check("lengths = [1, 6]"), ["lengths[1] = 6 is out of range; allowed: at most 5 mm"]);
        assert_eq!(
            check("kind = {spots = {radius = 1}}"),
            ["kind.spots.radius = 1 is out of range; allowed: at least 2"]
        );
    }

    #[test]
    fn lengths_and_infinities_are_refused() {
        assert_eq!(check("stops = []"), ["stops has 0 entries; allowed: 2 to 3 entries"]);
        assert_eq!(check("pair = [1]"), ["pair has 1 entry; allowed: 2 entries"]);
        assert_eq!(check("size = nan"), ["size = NaN is not a finite number; write a finite number"]);
        assert_eq!(
            check("unknown = [inf]"),
            ["unknown[0] = inf is not a finite number; write a finite number"]
        );
        assert_eq!(check("size = 1e300").len(), 1);
    }
}
