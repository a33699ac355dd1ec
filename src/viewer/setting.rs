//! One value of a preset as the window holds it, and the changes that are laid over a preset.

use std::collections::BTreeMap;

use crate::base::Srgb8;
use crate::preset::{Diagnostics, Document, Item, PresetError, Table, overrides};

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A number.
    Number(f32),
    /// A whole number.
    Whole(i64),
    /// Text: a name, a word of a choice, or a colour `#rrggbb`.
    Text(String),
    /// A switch.
    Flag(bool),
}

impl Setting {
    /// As TOML writes it.
    pub(super) fn to_toml(&self) -> String {
        match self {
            // The shortest that reads back as the same f32; `{:?}` has a point or an exponent.
            Self::Number(x) => format!("{x:?}"),
            Self::Whole(i) => i.to_string(),
            // JSON's escapes are among TOML's.
            Self::Text(text) => serde_json::Value::from(text.as_str()).to_string(),
            Self::Flag(b) => b.to_string(),
        }
    }

    /// What a preset says, if a slider, a choice, a colour or a switch can show it.
    pub(super) fn of_item(item: &Item) -> Option<Self> {
        match item {
            Item::Integer(_) => item.as_f64().map(|x| Self::Whole(x as i64)),
            Item::Float(_) => item.as_f64().map(|x| Self::Number(x as f32)),
            Item::String(text) => Some(Self::Text(text.clone())),
            Item::Boolean(b) => Some(Self::Flag(*b)),
            _ => None,
        }
    }

    /// What a schema gives as the default.
    pub(super) fn of_json(value: &serde_json::Value) -> Option<Self> {
        match value {
            serde_json::Value::Number(n) if n.is_f64() => n.as_f64().map(|x| Self::Number(x as f32)),
            serde_json::Value::Number(n) => n.as_i64().map(Self::Whole),
            serde_json::Value::String(text) => Some(Self::Text(text.clone())),
            serde_json::Value::Bool(b) => Some(Self::Flag(*b)),
            _ => None,
        }
    }

    /// As a number; a whole number is one, too.
    pub(super) fn number(&self) -> Option<f32> {
        match self {
            Self::Number(x) => Some(*x),
            Self::Whole(i) => Some(*i as f32),
            _ => None,
        }
    }

    /// As text.
    pub(super) fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// As a colour.
    pub(super) fn color(&self) -> Option<Srgb8> {
        self.text()?.parse().ok()
    }

    /// Whether both mean the same: 1 is 1.0.
    pub(super) fn means(&self, other: &Self) -> bool {
        match (self.number(), other.number()) {
            (Some(a), Some(b)) => a == b,
            (None, None) => match (self.color(), other.color()) {
                (Some(a), Some(b)) => a == b,
                _ => self == other,
            },
            _ => false,
        }
    }
}

/// What is laid over a preset: values by dotted path, such as `scales.keel` or `pattern.layers.0.size`.
pub type Changes = BTreeMap<String, Setting>;

/// The value that a document writes at a dotted path; numbers pick from lists.
pub(super) fn written<'d>(document: &'d Document, path: &str) -> Option<&'d Item> {
    let mut parts = path.split('.');
    let mut at = document.root.get(parts.next()?)?.get_ref();
    for part in parts {
        at = match at {
            Item::Table(table) => table.get(part)?.get_ref(),
            Item::Array(items) => items.get(part.parse::<usize>().ok()?)?.get_ref(),
            _ => return None,
        };
    }
    Some(at)
}

/// How many tables the list of tables at a dotted path has.
pub(super) fn tables<'d>(document: &'d Document, path: &str) -> Vec<&'d Table> {
    let items = written(document, path).and_then(Item::as_array).unwrap_or_default();
    items.iter().filter_map(|item| item.get_ref().as_table()).collect()
}

/// The document with the changes over it.
///
/// # Errors
/// What is wrong with a change: the place that it changes is not there any more.
pub(super) fn changed(document: &Document, changes: &Changes) -> Result<Document, PresetError> {
    let mut changed = document.clone();
    let mut diagnostics = Diagnostics::new();
    for (path, setting) in changes {
        overrides::apply(&mut changed, &format!("{path}={}", setting.to_toml()), &mut diagnostics);
    }
    diagnostics.finish(&changed.sources)?;
    Ok(changed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(text: &str) -> Document {
        Document::parse("a.toml", text).expect("valid TOML")
    }

    #[test]
    fn what_is_set_reads_back_as_it_was() {
        let settings = [
            Setting::Number(0.1),
            Setting::Number(1.0),
            Setting::Number(3.4e-9),
            Setting::Number(-2.5e20),
            Setting::Whole(57),
            Setting::Text("#A8793F".into()),
            Setting::Text("a \"b\" \\ \n\u{7} é".into()),
            Setting::Flag(true),
        ];
        for setting in settings {
            let document = document(&format!("x = {}", setting.to_toml()));
            assert_eq!(written(&document, "x").and_then(Setting::of_item), Some(setting));
        }
    }

    #[test]
    fn values_are_found_in_tables_and_lists() {
        let document = document("seed = 3\n[pattern]\n[[pattern.layers]]\n[[pattern.layers]]\nsize = 2.5");
        let at = |path: &str| written(&document, path).and_then(Setting::of_item);
        assert_eq!(at("seed"), Some(Setting::Whole(3)));
        assert_eq!(at("pattern.layers.1.size"), Some(Setting::Number(2.5)));
        for nowhere in ["", "sed", "seed.x", "pattern.layers.7.size", "pattern.layers.x", "pattern.layers"] {
            assert_eq!(at(nowhere), None, "{nowhere}");
        }
        assert_eq!(tables(&document, "pattern.layers").len(), 2);
        assert!(tables(&document, "seed").is_empty());
    }

    #[test]
    fn changes_are_laid_over_and_what_has_no_place_is_told() {
        let base = document("[[pattern.layers]]\nsize = 2.5");
        let mut changes = Changes::new();
        changes.insert("pattern.layers.0.size".into(), Setting::Number(4.0));
        changes.insert("scales.rows".into(), Setting::Whole(31));
        let over = changed(&base, &changes).expect("both have a place");
        let at = |path: &str| written(&over, path).and_then(Setting::of_item);
        assert_eq!(at("pattern.layers.0.size"), Some(Setting::Number(4.0)));
        assert_eq!(at("scales.rows"), Some(Setting::Whole(31)));
        changes.insert("pattern.layers.5.size".into(), Setting::Number(4.0));
        let error = changed(&base, &changes).expect_err("there is no sixth layer");
        assert!(error.to_string().contains("list of 1"), "{error}");
    }

    #[test]
    fn whole_numbers_and_colours_mean_the_same_in_any_writing() {
        assert!(Setting::Whole(1).means(&Setting::Number(1.0)));
        assert!(!Setting::Whole(1).means(&Setting::Number(1.5)));
        assert!(Setting::Text("#a8793f".into()).means(&Setting::Text("#A8793F".into())));
        assert!(!Setting::Text("1".into()).means(&Setting::Whole(1)));
    }
}
