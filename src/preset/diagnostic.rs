//! What is wrong with a preset, as plain data. Drawing it is the command's work.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Bytes of the sources laid end to end: see [`SourceMap`].
pub type Span = Range<usize>;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The preset can be used; something in it is likely not meant.
    Warning,
    /// The preset cannot be used.
    Error,
}

impl Severity {
    /// The word in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A place that a diagnostic points at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is there; may be empty.
    pub text: String,
    /// The place itself; the others explain it.
    pub primary: bool,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// A stable short name in kebab-case, such as `unknown-key`.
    pub code: &'static str,
    /// What is wrong, one line.
    pub message: String,
    /// Where; the first primary one is the place.
    pub labels: Vec<Label>,
    /// What to do.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, code, message: message.into(), labels: Vec::new(), help: None }
    }

    /// A warning without a place yet.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// Its place.
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into(), primary: true });
        self
    }

    /// Another place that explains it.
    pub fn and(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into(), primary: false });
        self
    }

    /// What to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The span of its place.
    pub fn span(&self) -> Option<Span> {
        self.labels.iter().find(|l| l.primary).map(|l| l.span.clone())
    }
}

/// One text that a preset was read from: a file, a built-in preset or an override.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name in messages: the path, or `--set key=value`.
    pub name: String,
    /// The text.
    pub text: Arc<str>,
    /// Position of its first byte among all sources.
    pub base: usize,
}

/// Where a position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Location {
    /// Index of the source.
    pub source: usize,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// The sources of a preset, laid end to end, so that one number names a byte in any of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceMap {
    sources: Vec<Source>,
}

impl SourceMap {
    /// Add a source; returns its base.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> usize {
        // One position lies between two sources, so that the end of a text belongs to it.
        let base = self.sources.last().map_or(0, |s| s.base + s.text.len() + 1);
        self.sources.push(Source { name: name.into(), text: text.into(), base });
        base
    }

    /// The sources, in order of their bases.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Index of the source that holds a position; the nearest one for a position outside of all.
    pub fn source_at(&self, position: usize) -> Option<usize> {
        let after = self.sources.partition_point(|s| s.base <= position);
        if self.sources.is_empty() { None } else { Some(after.saturating_sub(1)) }
    }

    /// Source, line and column of a position; `None` only when there are no sources.
    pub fn locate(&self, position: usize) -> Option<Location> {
        let index = self.source_at(position)?;
        let source = &self.sources[index];
        let mut end = position.saturating_sub(source.base).min(source.text.len());
        while !source.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &source.text[..end];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        Some(Location {
            source: index,
            line: before.matches('\n').count() + 1,
            column: before[start..].chars().count() + 1,
        })
    }
}

/// Collects diagnostics, so that a preset's problems are told all at once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Add one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.list.push(diagnostic);
    }

    /// Add several.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.list.extend(diagnostics);
    }

    /// All of them, in the order found.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// All of them, in the order found.
    pub fn into_list(self) -> Vec<Diagnostic> {
        self.list
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether any is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }

    /// The warnings, or the error with everything in it if any is an error.
    pub fn finish(self, sources: &SourceMap) -> Result<Vec<Diagnostic>, PresetError> {
        if self.has_errors() {
            Err(PresetError { diagnostics: self.list, sources: sources.clone() })
        } else {
            Ok(self.list)
        }
    }
}

/// A preset that cannot be used, and everything that is wrong with it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct PresetError {
    /// What is wrong; at least one error.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that the diagnostics point into.
    pub sources: SourceMap,
}

impl fmt::Display for PresetError {
    /// One line per diagnostic: `file:line:column: error[code]: message (help)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, d) in self.diagnostics.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            if let Some(at) = d.span().and_then(|span| self.sources.locate(span.start)) {
                let name = &self.sources.sources[at.source].name;
                write!(f, "{name}:{}:{}: ", at.line, at.column)?;
            }
            write!(f, "{}[{}]: {}", d.severity.name(), d.code, d.message)?;
            if let Some(help) = &d.help {
                write!(f, " ({help})")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_name_source_line_and_character_column() {
        let mut map = SourceMap::default();
        assert_eq!(map.locate(3), None);
        assert_eq!(map.add("a", "x\né=1\n"), 0);
        assert_eq!(map.add("b", "yz"), 8);
        let at = |p: usize| map.locate(p).map(|l| (l.source, l.line, l.column));
        assert_eq!(at(0), Some((0, 1, 1)));
        assert_eq!(at(2), Some((0, 2, 1)));
        assert_eq!(at(3), Some((0, 2, 1)), "inside the two bytes of é");
        assert_eq!(at(4), Some((0, 2, 2)));
        assert_eq!(at(7), Some((0, 3, 1)), "the end of a text belongs to it");
        assert_eq!(at(9), Some((1, 1, 2)));
        assert_eq!(at(10_000), Some((1, 1, 3)), "beyond all sources: the end of the last");
    }

    #[test]
    fn the_error_prints_a_line_per_diagnostic() {
        let mut map = SourceMap::default();
        map.add("a.toml", "seed = x\n");
        let mut all = Diagnostics::new();
        all.push(Diagnostic::warning("odd", "seed is odd"));
        assert_eq!(all.clone().finish(&map).map(|w| w.len()), Ok(1));
        all.push(Diagnostic::error("bad", "x is no number").and(0..4, "here").at(7..8, "").help("write 1"));
        let error = all.finish(&map).expect_err("it has an error");
        assert_eq!(
            error.to_string(),
            "warning[odd]: seed is odd\na.toml:1:8: error[bad]: x is no number (write 1)"
        );
    }
}
