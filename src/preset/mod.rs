//! TEXT: a preset as tables with spans, before anything in it has a meaning.
//!
//! ```text
//! text ─► Document::load ─► Document ─► overrides::apply ─► section::read ─► typed structs
//!          (includes)     (tables, spans)   (--set)          (serde, ranges)
//! ```
//!
//! Every problem is a [`Diagnostic`]: plain data with spans into a [`SourceMap`], collected so that a preset's
//! problems are told all at once. Nothing here draws, reads files or knows what a node is.

pub mod builtin;
pub mod diagnostic;
pub mod document;
pub mod include;
pub mod overrides;
pub mod section;
pub mod suggest;
pub mod value;

pub use diagnostic::{
    Diagnostic, Diagnostics, Label, Location, PresetError, Severity, Source, SourceMap, Span,
};
pub use document::Document;
pub use include::{Loaded, Loader};
pub use value::{Item, Number, Table, Value};

#[cfg(test)]
mod tests;
