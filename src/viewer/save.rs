//! A preset's text with changes written into it: comments and order stay, and nothing else is written.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::setting::{Changes, Setting, written};
use crate::preset::{self, Document};

/// Why a text cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum SaveError {
    /// The text that the changes belong into is no TOML.
    #[error("the preset's own text cannot be read: {0}")]
    Text(String),
    /// A change has no place in it.
    #[error("`{0}` has no place in the preset's text")]
    Place(String),
}

/// The text of a preset that stands on another one: only its changes are in it.
pub(super) fn over(base: &str) -> String {
    format!("include = {}\n", Setting::Text(base.to_owned()).to_toml())
}

/// `text` with the changes written into it. `whole` is what the text means with everything that it includes: of a list
/// that stands in an include and is changed, all is written, since lists are not merged.
///
/// # Errors
/// If the text is no TOML, or a change has no place in it.
pub(super) fn patched(text: &str, whole: &Document, changes: &Changes) -> Result<String, SaveError> {
    let mut document: DocumentMut =
        text.parse().map_err(|e: toml_edit::TomlError| SaveError::Text(one_line(e.message())))?;
    for (path, setting) in changes {
        put(document.as_table_mut(), whole, path, setting).ok_or_else(|| SaveError::Place(path.clone()))?;
    }
    let patched = document.to_string();
    // What is written must mean what was meant.
    let read = Document::parse("", &patched).map_err(|e| SaveError::Text(one_line(&e.to_string())))?;
    for (path, setting) in changes {
        let is = written(&read, path).and_then(Setting::of_item);
        if !is.is_some_and(|is| is.means(setting)) {
            return Err(SaveError::Place(path.clone()));
        }
    }
    Ok(patched)
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Write a setting at a dotted path below the root; `None` if it has no place.
fn put(root: &mut Table, whole: &Document, path: &str, setting: &Setting) -> Option<()> {
    let parts: Vec<&str> = path.split('.').collect();
    // The list that the path leads through, if the text lacks it.
    if let Some(depth) = parts.iter().position(|part| part.parse::<usize>().is_ok()) {
        let list = parts[..depth].join(".");
        if at(root, &parts[..depth]).is_none() {
            let items = written(whole, &list)?.as_array()?;
            let tables: Option<ArrayOfTables> =
                items.iter().map(|item| Some(table(item.get_ref().as_table()?))).collect();
            *make(root, &parts[..depth])? = Item::ArrayOfTables(tables?);
        }
    }
    let place = make(root, &parts)?;
    let mut value: Value = setting.to_toml().parse().ok()?;
    if let Some(old) = place.as_value() {
        *value.decor_mut() = old.decor().clone();
    }
    *place = Item::Value(value);
    Some(())
}

/// What stands at a path.
fn at<'t>(root: &'t Table, parts: &[&str]) -> Option<&'t Item> {
    let (first, rest) = parts.split_first()?;
    rest.iter().try_fold(root.get(first)?, |item, part| match part.parse::<usize>() {
        Ok(index) => item.get(index),
        Err(_) => item.as_table_like()?.get(part),
    })
}

/// The place at a path; tables on the way are made where they lack.
fn make<'t>(root: &'t mut Table, parts: &[&str]) -> Option<&'t mut Item> {
    let (last, way) = parts.split_last()?;
    let mut table: &mut dyn TableLike = root;
    let mut way = way.iter().peekable();
    while let Some(part) = way.next() {
        let item = table.entry(part).or_insert_with(|| Item::Table(section()));
        let item = match way.next_if(|next| next.parse::<usize>().is_ok()) {
            Some(index) => item.get_mut(index.parse::<usize>().ok()?)?,
            None => item,
        };
        // What is added to a table in one line gets the spaces of its neighbours.
        let inline = item.as_inline_table_mut().filter(|_| way.peek().is_none());
        if let Some(inline) = inline.filter(|inline| !inline.contains_key(last)) {
            inline.fmt();
        }
        table = item.as_table_like_mut()?;
    }
    Some(table.entry(last).or_insert(Item::None))
}

/// A new section: a blank line before it.
fn section() -> Table {
    let mut section = Table::new();
    section.decor_mut().set_prefix("\n");
    section
}

/// A table of a list, as its own section.
fn table(table: &preset::Table) -> Table {
    let mut made = section();
    for (key, item) in table {
        made.insert(key.get_ref(), Item::Value(value(item.get_ref())));
    }
    made
}

/// A value in one line.
fn value(item: &preset::Item) -> Value {
    match item {
        preset::Item::Array(items) => items.iter().map(|i| value(i.get_ref())).collect::<Array>().into(),
        preset::Item::Table(table) => {
            let pairs = table.iter().map(|(key, item)| (key.get_ref().as_str(), value(item.get_ref())));
            pairs.collect::<InlineTable>().into()
        }
        preset::Item::Integer(number) | preset::Item::Float(number) => {
            number.as_str().parse().unwrap_or_else(|_| number.as_str().into())
        }
        preset::Item::String(text) => text.as_str().into(),
        preset::Item::Boolean(b) => (*b).into(),
        preset::Item::Datetime(date) => (*date).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Loaded;
    use crate::preset::builtin::{self, Builtins};
    use crate::viewer::setting::changed;

    const OWN: &str = "\
#:schema preset.schema.json
# My snake.
seed = 3  # the good one

[scales]
# Counted on a photograph.
rows = 21        # odd
keel = 0.1

[[pattern.layers]]
name = \"saddles\"   # the large ones
size = 4.0

[color]
base = '#102030'
";

    fn changes(list: &[(&str, Setting)]) -> Changes {
        list.iter().map(|(path, setting)| ((*path).to_owned(), setting.clone())).collect()
    }

    fn patch(text: &str, list: &[(&str, Setting)]) -> Result<String, SaveError> {
        patched(text, &Document::parse("a.toml", text).expect("valid TOML"), &changes(list))
    }

    #[test]
    fn only_what_changed_changes() {
        let list = [
            ("scales.rows", Setting::Whole(31)),
            ("pattern.layers.0.size", Setting::Number(2.5)),
            ("color.base", Setting::Text("#FF0000".into())),
        ];
        let expected = OWN
            .replace("rows = 21", "rows = 31")
            .replace("size = 4.0", "size = 2.5")
            .replace("'#102030'", "\"#FF0000\"");
        assert_eq!(patch(OWN, &list), Ok(expected));
        assert_eq!(patch(OWN, &[]), Ok(OWN.into()));
    }

    #[test]
    fn what_the_text_lacks_is_added_where_it_belongs() {
        let list = [
            ("belly.width", Setting::Number(0.2)),
            ("pattern.layers.0.taper", Setting::Number(0.5)),
            ("pattern.quantise", Setting::Number(1.0)),
            ("scales.dome", Setting::Number(0.4)),
        ];
        let text = patch(OWN, &list).expect("all have a place");
        assert!(text.contains("keel = 0.1\ndome = 0.4\n"), "{text}");
        assert!(text.contains("size = 4.0\ntaper = 0.5\n"), "{text}");
        assert!(text.contains("\n[belly]\nwidth = 0.2\n"), "{text}");
        assert!(OWN.lines().all(|line| text.lines().any(|l| l == line)), "no line is lost:\n{text}");
    }

    #[test]
    fn a_root_key_comes_before_the_sections() {
        let text = patch("[scales]\nrows = 3\n", &[("seed", Setting::Whole(7))]).expect("it has a place");
        assert_eq!(text, "seed = 7\n[scales]\nrows = 3\n");
    }

    #[test]
    fn inline_tables_stay_inline() {
        let text = "scales = { rows = 3 }\npattern.layers = [{ size = 1.0 }]\n";
        let list = [("scales.keel", Setting::Number(0.5)), ("pattern.layers.0.size", Setting::Number(2.0))];
        let expected = "scales = { rows = 3, keel = 0.5 }\npattern.layers = [{ size = 2.0 }]\n";
        assert_eq!(patch(text, &list), Ok(expected.into()));
    }

    #[test]
    fn what_has_no_place_is_refused_not_guessed() {
        for path in ["seed.x", "pattern.layers.9.size", "scales.rows.deep", "color.base.0"] {
            let refused = patch(OWN, &[(path, Setting::Whole(1))]);
            assert_eq!(refused, Err(SaveError::Place(path.into())), "{path}");
        }
        assert!(matches!(
            patched("a =", &builtin::document("python_regius").expect("sound"), &changes(&[])),
            Err(SaveError::Text(_))
        ));
    }

    /// A built-in preset is saved as one that includes it: that text must be the preset with the changes.
    #[test]
    fn a_preset_over_a_built_in_one_means_the_same_as_its_changes() {
        for (name, _) in builtin::BUILTIN {
            let whole = builtin::document(name).expect("sound");
            let mut list =
                changes(&[("scales.rows", Setting::Whole(33)), ("belly.width", Setting::Number(0.25))]);
            if written(&whole, "pattern.layers").is_some() {
                list.insert("pattern.layers.0.softness".into(), Setting::Number(0.5));
            }
            let text = patched(&over(&format!("{name}.toml")), &whole, &list).expect(name);
            let loaded = Loaded { name: "mine.toml".into(), bytes: text.clone().into_bytes() };
            let read = Document::load_text(loaded, &Builtins).expect(name);
            let expected = changed(&whole, &list).expect(name);
            let print = |document: &Document| {
                let mut graph = crate::graph::from_document(document, None).expect(name);
                graph.name = "same".into();
                crate::graph::preset_hash(&graph)
            };
            assert_eq!(print(&read), print(&expected), "{name}\n{text}");
        }
    }
}
