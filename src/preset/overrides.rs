//! `--set pattern.size=0.3`: single values over a preset's.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::diagnostic::{Diagnostic, Diagnostics};
use super::document::{Document, syntax_error};
use super::include::merge;
use super::value::{Item, Table, Value, own};

/// Lay `setting`, such as `pattern.size=0.3`, over the document, pushing what is wrong with it; true if nothing is.
///
/// The key is a TOML key with dots (and numbers that pick from lists); the value is a TOML value, or else text as it
/// stands (`pattern.type=spots`, `color.ground=#9C3B24`). A table is merged into the preset's. The setting is a
/// source of its own, so that later messages point into it.
pub fn apply(document: &mut Document, setting: &str, diagnostics: &mut Diagnostics) -> bool {
    let base = document.sources.add(format!("--set {setting}"), setting);
    let all = base..base + setting.len();
    let fail = |code, message: String| Diagnostic::error(code, message).help("write --set key.path=value");
    let Some(equals) = equals(setting) else {
        diagnostics.push(fail("bad-override", "the override has no `=`".into()).at(all, ""));
        return false;
    };
    let key_span = base..base + equals;
    let Some(path) = path(&setting[..equals], base) else {
        diagnostics.push(fail("bad-override", "the override's key is no TOML key".into()).at(key_span, ""));
        return false;
    };
    let text = &setting[equals + 1..];
    let value_base = base + equals + 1 + (text.len() - text.trim_start().len());
    let text = text.trim();
    let value = match DeValue::parse(text) {
        Ok(value) => own(value, value_base),
        Err(error) if text.is_empty() || text.starts_with(['"', '\'', '[', '{']) => {
            diagnostics.push(syntax_error(&error, text, value_base));
            return false;
        }
        Err(_) => Spanned::new(value_base..value_base + text.len(), Item::String(text.into())),
    };
    match set(&mut document.root, &path, value) {
        Ok(()) => true,
        Err(diagnostic) => {
            diagnostics.push(*diagnostic);
            false
        }
    }
}

/// Where the key ends: the first `=` outside quotes.
fn equals(setting: &str) -> Option<usize> {
    let mut quote = None;
    setting.char_indices().find_map(|(i, c)| {
        match (quote, c) {
            (None, '=') => return Some(i),
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
        None
    })
}

/// The parts of a dotted key.
fn path(key: &str, base: usize) -> Option<Vec<Spanned<String>>> {
    if key.contains('\n') {
        return None;
    }
    let text = format!("{key}=0");
    let parsed = DeTable::parse(&text).ok()?;
    let mut parts = Vec::new();
    let mut table = parsed.get_ref();
    loop {
        let (key, value) = table.iter().next()?;
        let span = key.span();
        parts.push(Spanned::new(base + span.start..base + span.end, key.get_ref().clone().into_owned()));
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            _ => return Some(parts),
        }
    }
}

fn set(table: &mut Table, path: &[Spanned<String>], value: Value) -> Result<(), Box<Diagnostic>> {
    let Some((key, rest)) = path.split_first() else { return Ok(()) };
    if rest.is_empty() {
        let mut layer = Table::new();
        layer.insert(key.clone(), value);
        merge(table, layer);
        return Ok(());
    }
    let entry = table.entry(key.clone());
    let inner = entry.or_insert_with(|| Spanned::new(key.span(), Item::Table(Table::new())));
    descend(inner, key, rest, value)
}

/// Set `value` at `rest` in `inner`, which stands at `key`.
fn descend(
    inner: &mut Value,
    key: &Spanned<String>,
    rest: &[Spanned<String>],
    value: Value,
) -> Result<(), Box<Diagnostic>> {
    let (span, kind) = (inner.span(), inner.get_ref().kind());
    match inner.get_mut() {
        Item::Table(table) => set(table, rest, value),
        Item::Array(items) => {
            let (index, deeper) = rest.split_first().map_or((key, rest), |(i, d)| (i, d));
            let count = items.len();
            let item = index.get_ref().parse::<usize>().ok().and_then(|i| items.get_mut(i));
            match item {
                Some(item) if deeper.is_empty() => {
                    *item = value;
                    Ok(())
                }
                Some(item) => descend(item, index, deeper, value),
                None => {
                    let message = format!("`{}` is a list of {count}", key.get_ref());
                    let help = "pick an entry by its number, from 0, or set the whole list";
                    Err(Box::new(
                        Diagnostic::error("bad-override", message)
                            .at(index.span(), "no such entry")
                            .and(span, "the list")
                            .help(help),
                    ))
                }
            }
        }
        _ => {
            let message = format!("`{}` is {kind}, not a table", key.get_ref());
            Err(Box::new(Diagnostic::error("bad-override", message).at(key.span(), "").and(span, "set here")))
        }
    }
}
