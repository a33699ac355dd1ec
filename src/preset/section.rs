//! From a table with spans to a typed struct, telling everything that is wrong with it.

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{Error, ValueDeserializer};

use super::diagnostic::{Diagnostic, Diagnostics, Span};
use super::suggest;
use super::value::{Item, Table, Value, deserializer};
use crate::base::params::{self, ParamError};

/// Read a section into `T`, pushing every problem; `what` names the section in messages, such as `[scales]`.
///
/// Ranges are held against `T`'s schema.
pub fn read<T: DeserializeOwned + schemars::JsonSchema>(
    value: &Value,
    what: &str,
    diagnostics: &mut Diagnostics,
) -> Option<T> {
    let typed = read_with(value, what, &|d| T::deserialize(d), diagnostics);
    let mut ranges = Diagnostics::new();
    let in_range = check(&schemars::schema_for!(T), value, &mut ranges);
    // A list of the wrong length has been told already.
    let told: Vec<_> = diagnostics.list().iter().filter_map(Diagnostic::span).collect();
    diagnostics
        .extend(ranges.into_list().into_iter().filter(|d| d.span().is_none_or(|s| !told.contains(&s))));
    typed.filter(|_| in_range)
}

/// Read a value by `parse`, pushing every problem. Where `parse` fails, each key alone is tried, so that a table's
/// problems are told together: this needs a type whose every key has a default.
pub fn read_with<R>(
    value: &Value,
    what: &str,
    parse: &dyn Fn(ValueDeserializer<'_>) -> Result<R, Error>,
    diagnostics: &mut Diagnostics,
) -> Option<R> {
    match parse(deserializer(value)) {
        Ok(typed) => Some(typed),
        Err(first) => {
            let mut errors = Vec::new();
            try_parts(value, &|part| parse(deserializer(&part)).err(), &mut errors);
            if errors.is_empty() {
                errors.push(first);
            }
            errors.dedup();
            diagnostics.extend(errors.iter().map(|e| explain(e, value, what)));
            None
        }
    }
}

/// Hold a section against its schema's ranges, pushing every problem with its place; true if there is none.
pub fn check(schema: &schemars::Schema, value: &Value, diagnostics: &mut Diagnostics) -> bool {
    let Ok(settings) = serde::Deserialize::deserialize(deserializer(value)) else { return true };
    let errors = params::check_ranges(schema, &settings);
    let fine = errors.is_empty();
    diagnostics.extend(errors.iter().map(|e| range_error(e, value)));
    fine
}

/// A setting's error at the place of its value in `section`.
pub fn range_error(error: &ParamError, section: &Value) -> Diagnostic {
    Diagnostic::error("out-of-range", &error.message)
        .at(span_of(section, &error.key), "")
        .help(error.help.clone())
}

/// The span of the value at `path` (such as `stops[2].position`) in `section`; of the nearest table around it where
/// the preset does not write that key.
pub fn span_of(section: &Value, path: &str) -> Span {
    let mut at = section;
    for part in path.split('.') {
        let mut names = part.split('[');
        let key = names.next().unwrap_or("");
        match at.get_ref().as_table().and_then(|t| t.get(key)) {
            Some(value) => at = value,
            None => break,
        }
        for index in names {
            let index = index.trim_end_matches(']').parse::<usize>().ok();
            match index.and_then(|i| at.get_ref().as_array()?.get(i)) {
                Some(value) => at = value,
                None => return at.span(),
            }
        }
    }
    at.span()
}

/// Collect the errors of every key of `value` alone, wrapped as it stands; `parse` reads the whole around it.
///
/// Errors that only say that something else is missing are the parts', not the author's.
fn try_parts(value: &Value, parse: &dyn Fn(Value) -> Option<Error>, errors: &mut Vec<Error>) {
    let artefact = |e: &Error| {
        let m = e.message();
        m.starts_with("missing field") || m.starts_with("invalid length") || m.starts_with("wanted exactly")
    };
    let mut try_one = |part: &Value, wrap: &dyn Fn(Value) -> Value| {
        if let Some(error) = parse(wrap(part.clone())) {
            let before = errors.len();
            if matches!(part.get_ref(), Item::Table(_) | Item::Array(_)) {
                try_parts(part, &|inner| parse(wrap(inner)), errors);
            }
            if errors.len() == before && !artefact(&error) {
                errors.push(error);
            }
        }
    };
    match value.get_ref() {
        Item::Table(table) => {
            for (key, part) in table {
                try_one(part, &|inner| {
                    let mut alone = Table::new();
                    alone.insert(key.clone(), inner);
                    Spanned::new(value.span(), Item::Table(alone))
                });
            }
        }
        Item::Array(items) => {
            for part in items {
                try_one(part, &|inner| Spanned::new(value.span(), Item::Array(vec![inner])));
            }
        }
        _ => {}
    }
}

/// A serde error in the words of an author.
pub fn explain(error: &Error, section: &Value, what: &str) -> Diagnostic {
    let message = error.message();
    let span = error.span().unwrap_or(section.span());
    if let Some((word, known)) = unknown(message, "unknown field") {
        let diagnostic =
            Diagnostic::error("unknown-key", format!("unknown key `{word}` in {what}")).at(span, "");
        return with_help(diagnostic, suggest::help(word, &known));
    }
    if let Some((word, known)) = unknown(message, "unknown variant") {
        let diagnostic = Diagnostic::error("unknown-value", format!("unknown value \"{word}\" in {what}"))
            .at(span, one_of(&known));
        return with_help(diagnostic, suggest::help(word, &known));
    }
    if let Some(field) = message.strip_prefix("missing field ") {
        return Diagnostic::error("missing-key", format!("{field} is missing in {what}"))
            .at(span, "")
            .help(format!("add {} = …", field.trim_matches('`')));
    }
    if let Some((found, expected)) = message
        .strip_prefix("invalid type: ")
        .or_else(|| message.strip_prefix("invalid value: "))
        .or_else(|| message.strip_prefix("invalid length "))
        .and_then(|m| m.split_once(", expected "))
    {
        let expected = plain_words(expected);
        return Diagnostic::error("wrong-type", format!("expected {expected}, found {}", found_words(found)))
            .at(span, format!("expected {expected}"));
    }
    Diagnostic::error("bad-value", message.replace('\n', " ")).at(span, "")
}

fn with_help(diagnostic: Diagnostic, help: Option<String>) -> Diagnostic {
    match help {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

fn one_of(known: &[&str]) -> String {
    if known.len() > 12 { String::new() } else { format!("one of {}", known.join(", ")) }
}

/// The word and what was expected, from serde's "unknown field `x`, expected one of `a`, `b`".
fn unknown<'a>(message: &'a str, start: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let rest = message.strip_prefix(start)?.strip_prefix(" `")?;
    // The word may hold anything; what follows it is serde's.
    let end = rest.rfind("`, expected ").or_else(|| rest.rfind("`, there are no "))?;
    // With several candidates the last match lies between them; the word ends at the first that leaves only names.
    let end = rest.find("`, expected ").unwrap_or(end);
    let known = rest[end + 1..].split('`').skip(1).step_by(2).collect();
    Some((&rest[..end], known))
}

/// What serde expected, for people who do not program.
fn plain_words(expected: &str) -> String {
    let words = match expected.trim() {
        "f32" | "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, not negative",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "a boolean" => "true or false",
        "a sequence" => "a list [ … ]",
        "a map" => "a table",
        "a string" | "a borrowed string" => "text in quotes",
        other if other.starts_with("struct ") => "a table",
        other if other.starts_with("string or table") || other.starts_with("enum ") => "a name in quotes",
        other => {
            return match other.strip_prefix("an array of length ") {
                Some(n) => format!("a list of {n}"),
                None => other.to_owned(),
            };
        }
    };
    words.into()
}

/// What serde found, for people who do not program.
fn found_words(found: &str) -> String {
    match found {
        "map" => "a table".into(),
        "sequence" => "a list".into(),
        other => {
            for (serde, ours) in [
                ("string ", ""),
                ("integer ", ""),
                ("floating point ", ""),
                ("boolean ", ""),
                ("newtype struct", "a table"),
            ] {
                if let Some(rest) = other.strip_prefix(serde) {
                    return format!("{ours}{}", rest.trim_matches('`'));
                }
            }
            other.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Document;

    #[derive(Debug, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    struct Scales {
        #[schemars(range(min = 0.0, max = 1.0))]
        overlap: f32,
        rows: u32,
        shape: Shape,
        tip: Tip,
        stops: Vec<Stop>,
        pair: [f32; 2],
    }

    #[derive(Debug, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
    #[serde(rename_all = "snake_case")]
    enum Shape {
        #[default]
        Leaf,
        Rhombus,
    }

    #[derive(Debug, Default, PartialEq, serde::Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    struct Tip {
        #[schemars(range(min = 0.0))]
        amount: f32,
        keel: bool,
    }

    #[derive(Debug, PartialEq, serde::Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    struct Stop {
        #[schemars(range(max = 1.0))]
        position: f32,
        color: String,
    }

    /// `line:column-column code message (help)` of each problem of `[scales]` with this body.
    fn problems(body: &str) -> Vec<String> {
        let doc = Document::parse("t", &format!("[scales]\n{body}")).expect("valid TOML");
        let mut diagnostics = Diagnostics::new();
        let read: Option<Scales> = read(&doc.root["scales"], "[scales]", &mut diagnostics);
        assert_eq!(read.is_none(), diagnostics.has_errors());
        let show = |d: &Diagnostic| {
            let span = d.span().expect("every problem has a place");
            let (a, b) = (doc.sources.locate(span.start), doc.sources.locate(span.end));
            let (a, b) = (a.expect("located"), b.expect("located"));
            let help = d.help.as_ref().map(|h| format!(" ({h})")).unwrap_or_default();
            format!("{}:{}-{} {} {}{help}", a.line, a.column, b.column, d.code, d.message)
        };
        diagnostics.list().iter().map(show).collect()
    }

    #[test]
    fn a_good_section_is_read() {
        let doc = Document::parse("t", "rows = 21\ntip.keel = true\nstops = [{position = 1, color = 'x'}]");
        let doc = doc.expect("valid TOML");
        let value = Spanned::new(0..0, Item::Table(doc.root));
        let mut diagnostics = Diagnostics::new();
        let scales: Option<Scales> = read(&value, "scales", &mut diagnostics);
        let scales = scales.expect("no problem");
        assert!(diagnostics.is_empty() && scales.rows == 21 && scales.tip.keel && scales.stops.len() == 1);
    }

    #[test]
    fn every_problem_of_a_table_is_told_at_its_place() {
        assert_eq!(
            problems(
                "ovrelap = 0.5\nrows = \"many\"\nshape = 'leef'\ntip = { amonut = 1, keel = 3 }\n\
                 stops = [{position = 'x', color = 1}, {positon = 2}]\n"
            ),
            [
                "2:1-8 unknown-key unknown key `ovrelap` in [scales] (did you mean `overlap`?)",
                "3:8-14 wrong-type expected a whole number, not negative, found \"many\"",
                "4:9-15 unknown-value unknown value \"leef\" in [scales] (did you mean `leaf`?)",
                "5:9-15 unknown-key unknown key `amonut` in [scales] (did you mean `amount`?)",
                "5:28-29 wrong-type expected true or false, found 3",
                "6:22-25 wrong-type expected a number, found \"x\"",
                "6:35-36 wrong-type expected text in quotes, found 1",
                "6:40-47 unknown-key unknown key `positon` in [scales] (did you mean `position`?)",
            ]
        );
    }

    #[test]
    fn what_only_the_whole_lacks_is_told_too() {
        assert_eq!(
            problems("stops = [{position = 0.5}]"),
            ["2:10-26 missing-key `color` is missing in [scales] (add color = …)"]
        );
        assert_eq!(problems("pair = [1]"), ["2:8-11 wrong-type expected a list of 2, found 1"]);
        assert_eq!(problems("rows = -1").len(), 1);
        assert_eq!(
            problems("rows = 1.5"),
            ["2:8-11 wrong-type expected a whole number, not negative, found 1.5"]
        );
    }

    #[test]
    fn ranges_are_told_at_the_value() {
        assert_eq!(
            problems(
                "overlap = 1.5\ntip.amount = -1\nstops = [{position = 0, color = ''}, {position = 3, color = ''}]"
            ),
            [
                "2:11-14 out-of-range overlap = 1.5 is out of range (allowed: 0 to 1)",
                "3:14-16 out-of-range tip.amount = -1 is out of range (allowed: at least 0)",
                "4:50-51 out-of-range stops[1].position = 3 is out of range (allowed: at most 1)",
            ]
        );
    }

    #[test]
    fn words_with_backticks_do_not_confuse() {
        assert_eq!(
            problems("'a`b' = 1"),
            [
                "2:1-6 unknown-key unknown key `a`b` in [scales] (known: `overlap`, `rows`, `shape`, `tip`, `stops`, `pair`)"
            ]
        );
    }
}
