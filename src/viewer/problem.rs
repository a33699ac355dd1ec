//! What is wrong, with the line of text that it is about.

use crate::preset::{Diagnostic, PresetError, Severity, SourceMap};

/// One problem as the window shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Whether the skin cannot be made because of it.
    pub error: bool,
    /// What is wrong.
    pub message: String,
    /// What to do; may be empty.
    pub help: String,
    /// Where, if it has a place.
    pub place: Option<Place>,
}

/// A place in a text.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The file's name; empty for a change made in the window.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The line before it in three parts: before the place, the place, after it.
    pub text: [String; 3],
}

/// Most characters of a line to each side of a place.
const AROUND: usize = 60;

impl Problem {
    /// A problem without a place.
    pub fn plain(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { error: true, message: message.into(), help: help.into(), place: None }
    }

    /// What a preset's error tells, in the order of the text.
    pub fn of_error(error: &PresetError) -> Vec<Self> {
        Self::all(&error.diagnostics, &error.sources)
    }

    /// What diagnostics tell, in the order of the text.
    pub(super) fn all(list: &[Diagnostic], sources: &SourceMap) -> Vec<Self> {
        let mut list: Vec<&Diagnostic> = list.iter().collect();
        list.sort_by_key(|d| d.span().map_or(usize::MAX, |span| span.start));
        list.into_iter().map(|d| Self::of(d, sources)).collect()
    }

    fn of(diagnostic: &Diagnostic, sources: &SourceMap) -> Self {
        Self {
            error: diagnostic.severity == Severity::Error,
            message: diagnostic.message.clone(),
            help: diagnostic.help.clone().unwrap_or_default(),
            place: diagnostic.span().and_then(|span| place(span, sources)),
        }
    }
}

fn place(span: std::ops::Range<usize>, sources: &SourceMap) -> Option<Place> {
    let at = sources.locate(span.start)?;
    let source = &sources.sources()[at.source];
    let line = source.text.lines().nth(at.line - 1).unwrap_or("");
    let letters: Vec<char> = line.chars().collect();
    let start = (at.column - 1).min(letters.len());
    // A span may be a whole table, and a column counts characters.
    let bytes = span.end.saturating_sub(span.start);
    let mut end = start;
    let mut covered = 0;
    while end < letters.len() && covered < bytes {
        covered += letters[end].len_utf8();
        end += 1;
    }
    let text = |range: &[char]| range.iter().collect::<String>();
    let (first, last) = (start.saturating_sub(AROUND), (end + AROUND).min(letters.len()));
    let shown = end.min(start + AROUND);
    let file = if source.name.starts_with("--set ") { String::new() } else { source.name.clone() };
    Some(Place {
        file,
        line: at.line,
        column: at.column,
        text: [text(&letters[first..start]), text(&letters[start..shown]), text(&letters[end..last])],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Document;

    #[test]
    fn a_problem_shows_its_line_with_the_place() {
        let error =
            Document::parse("a.toml", "seed = 1\n\n[scales]\nrows = many  # é").expect_err("no number");
        let problems = Problem::of_error(&error);
        let place = problems[0].place.as_ref().expect("it has a place");
        assert_eq!((place.file.as_str(), place.line, place.column), ("a.toml", 4, 8));
        assert_eq!(place.text, ["rows = ", "many", "  # é"].map(str::to_owned));
        assert!(problems[0].help.contains("\"many\""), "{}", problems[0].help);
    }

    #[test]
    fn long_lines_and_whole_tables_stay_short() {
        let mut sources = SourceMap::default();
        sources.add("b", format!("{}é{}\nnext = 1", "x".repeat(500), "y".repeat(500)));
        let at = |span| place(span, &sources).expect("a source");
        assert_eq!(at(500..502).text, ["x".repeat(60), "é".into(), "y".repeat(60)]);
        let table = at(100..1010);
        assert_eq!(table.text[1].chars().count(), 60);
        assert_eq!(table.text[2], "");
        assert_eq!((at(1006..1007).line, at(99_999..100_000).line), (2, 2), "beyond the end is the end");
    }

    #[test]
    fn a_change_made_in_the_window_has_no_file() {
        let mut sources = SourceMap::default();
        sources.add("--set scales.rows=0", "scales.rows=0");
        let problem = Problem::of(&Diagnostic::error("x", "out of range").at(12..13, ""), &sources);
        assert_eq!(problem.place.expect("a place").file, "");
    }
}
