//! Diagnostics and messages as text for people: the only place that draws them.

use std::io::Write as _;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet, renderer::DecorStyle};

use super::exit::Failure;
use crate::preset::{Diagnostic, Label, PresetError, Severity, SourceMap};

/// Diagnostics that are shown; the rest is counted.
const SHOWN: usize = 30;

/// Bytes of a source that are shown around a place.
const AROUND: usize = 400;

/// Tell a failure on standard error, in colour where that is wanted.
pub(super) fn failure(failure: &Failure) {
    match failure {
        Failure::Preset(error) => preset_error(error),
        Failure::Message { message, help, .. } => {
            let mut group = Group::with_title(Level::ERROR.primary_title(message));
            if let Some(help) = help {
                group = group.element(Level::HELP.message(help));
            }
            tell(&renderer().render(&[group]));
        }
        Failure::Told(_) => {}
    }
}

/// Tell a preset's diagnostics on standard error.
pub(super) fn preset_error(error: &PresetError) {
    tell(&diagnostics(&error.diagnostics, &error.sources, &renderer()));
}

/// Tell warnings on standard error.
pub(super) fn warnings(warnings: &[Diagnostic], sources: &SourceMap) {
    if !warnings.is_empty() {
        tell(&diagnostics(warnings, sources, &renderer()));
    }
}

/// Tell a warning that has no place in a preset.
pub(super) fn warning(message: &str, help: &str) {
    let group = Group::with_title(Level::WARNING.primary_title(message)).element(Level::HELP.message(help));
    tell(&renderer().render(&[group]));
}

fn tell(text: &str) {
    // Nowhere is left to tell that standard error is closed.
    let _ = writeln!(anstream::stderr(), "{text}");
}

fn renderer() -> Renderer {
    // anstream takes the colours out where they are not wanted: no terminal, NO_COLOR, a dumb one.
    Renderer::styled().decor_style(DecorStyle::Ascii).term_width(110)
}

/// Diagnostics as text, a blank line between two, plain or coloured as `renderer` says.
pub(super) fn diagnostics(list: &[Diagnostic], sources: &SourceMap, renderer: &Renderer) -> String {
    // As they stand in the texts; what stands nowhere comes last.
    let mut list: Vec<&Diagnostic> = list.iter().collect();
    list.sort_by_key(|d| d.span().map_or(usize::MAX, |span| span.start));
    let shown: Vec<String> = list.iter().take(SHOWN).map(|d| one(d, sources, renderer)).collect();
    let mut text = shown.join("\n\n");
    if list.len() > SHOWN {
        text.push_str(&format!("\n\nand {} more problems", list.len() - SHOWN));
    }
    text
}

/// One diagnostic as text.
pub(super) fn one(diagnostic: &Diagnostic, sources: &SourceMap, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = Group::with_title(level.primary_title(&diagnostic.message).id(diagnostic.code));
    // A snippet per source, the one of the place first.
    let mut order: Vec<usize> = Vec::new();
    let primary_first = diagnostic.labels.iter().filter(|l| l.primary);
    for label in primary_first.chain(diagnostic.labels.iter().filter(|l| !l.primary)) {
        if let Some(source) = sources.source_at(label.span.start)
            && !order.contains(&source)
        {
            order.push(source);
        }
    }
    for source in order {
        let labels: Vec<&Label> =
            diagnostic.labels.iter().filter(|l| sources.source_at(l.span.start) == Some(source)).collect();
        group = group.element(snippet(&sources.sources()[source], &labels));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(help));
    }
    renderer.render(&[group])
}

fn snippet<'a>(
    source: &'a crate::preset::Source,
    labels: &[&'a Label],
) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
    let text: &str = &source.text;
    let boundary = |mut at: usize, step: isize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at = at.saturating_add_signed(step);
        }
        at
    };
    let spans: Vec<_> = labels
        .iter()
        .map(|l| {
            let start = boundary(l.span.start.saturating_sub(source.base), -1);
            // A span may be a whole table: its first line is the place.
            let line = text[start..].find('\n').map_or(text.len(), |n| start + n);
            let end = boundary(l.span.end.saturating_sub(source.base), 1).clamp(start, line);
            start..end
        })
        .collect();
    // Only the surroundings are handed on: a source may be a megabyte on one line.
    let first = spans.iter().map(|s| s.start).min().unwrap_or(0);
    let last = spans.iter().map(|s| s.end).max().unwrap_or(0);
    let near = boundary(first.saturating_sub(AROUND), -1);
    // Whole lines before the place, for its column.
    let from = text[..near].rfind('\n').map_or(0, |n| n + 1);
    let to = boundary(last.saturating_add(AROUND), 1);
    let to = text[last..to].find('\n').map_or(to, |n| last + n);
    let mut snippet = Snippet::source(&text[from..to])
        .line_start(text[..from].matches('\n').count() + 1)
        .path(source.name.as_str());
    for (label, span) in labels.iter().zip(spans) {
        let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
        let shown = (span.start - from)..(span.end - from).min(span.start - from + AROUND);
        let end = boundary(from + shown.end, -1) - from;
        let annotation = kind.span(shown.start..end);
        snippet = snippet.annotation(if label.text.is_empty() {
            annotation
        } else {
            annotation.label(label.text.as_str())
        });
    }
    snippet
}
