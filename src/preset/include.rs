//! `include = "base.toml"`: presets in layers.
//!
//! What a preset says wins over what it includes; of several includes the later wins. Tables are merged key by key,
//! everything else (arrays too) is replaced; so is a node (or any table) whose `op` changes, since its settings
//! belong to the other operation.

use super::diagnostic::{Diagnostic, Diagnostics, PresetError, SourceMap, Span};
use super::document::{Document, parse_source};
use super::value::{Item, Table, Value};

/// Most includes inside one another.
pub const MAX_INCLUDES: usize = 16;

/// Most texts that one preset may be read from.
pub const MAX_SOURCES: usize = 64;

/// A text and the name that it is known by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded {
    /// The same for every way to name the same text; shown in messages.
    pub name: String,
    /// The text, not yet known to be UTF-8.
    pub bytes: Vec<u8>,
}

/// Where included presets come from: files (in the command), the built-in presets, a test's map.
pub trait Loader {
    /// Read what `path` names in the text of name `from` (empty for the outermost one).
    ///
    /// # Errors
    /// A sentence for the author: no such file, not allowed to read it, …
    fn load(&self, path: &str, from: &str) -> Result<Loaded, String>;
}

impl Document {
    /// Read the preset that `path` names and all that it includes.
    ///
    /// # Errors
    /// Everything that is wrong with any of the texts.
    pub fn load(path: &str, loader: &dyn Loader) -> Result<Self, PresetError> {
        match loader.load(path, "") {
            Ok(loaded) => Self::load_text(loaded, loader),
            Err(message) => {
                let mut sources = SourceMap::default();
                sources.add(path, "");
                let diagnostic = Diagnostic::error("no-file", message);
                Err(PresetError { diagnostics: vec![diagnostic], sources })
            }
        }
    }

    /// Read this text and all that it includes.
    ///
    /// # Errors
    /// Everything that is wrong with any of the texts.
    pub fn load_text(text: Loaded, loader: &dyn Loader) -> Result<Self, PresetError> {
        let mut layers = Layers {
            loader,
            sources: SourceMap::default(),
            diagnostics: Diagnostics::new(),
            open: Vec::new(),
        };
        let name = text.name.clone();
        let root = layers.read(text);
        layers.diagnostics.finish(&layers.sources)?;
        Ok(Self { name, root, sources: layers.sources })
    }
}

struct Layers<'a> {
    loader: &'a dyn Loader,
    sources: SourceMap,
    diagnostics: Diagnostics,
    /// The texts being read, outermost first, each with the span of the include that led further.
    open: Vec<(String, Span)>,
}

impl Layers<'_> {
    fn read(&mut self, text: Loaded) -> Table {
        let mut own = parse_source(&text.name, &text.bytes, &mut self.sources, &mut self.diagnostics);
        let Some(include) = own.remove("include") else { return own };
        let mut merged = Table::new();
        self.open.push((text.name, 0..0));
        for path in self.paths(&include) {
            merge(&mut merged, self.include(&path));
        }
        self.open.pop();
        merge(&mut merged, own);
        merged
    }

    /// The paths of `include`: a string or a list of strings.
    fn paths(&mut self, include: &Value) -> Vec<Value> {
        let items = match include.get_ref() {
            Item::Array(items) => items.clone(),
            _ => vec![include.clone()],
        };
        let (good, bad): (Vec<_>, Vec<_>) = items.into_iter().partition(|v| v.get_ref().as_str().is_some());
        for item in bad {
            let message = format!("include is {}, not the name of a preset", item.get_ref().kind());
            self.diagnostics.push(
                Diagnostic::error("wrong-type", message)
                    .at(item.span(), "expected text in quotes")
                    .help("write include = \"base.toml\" or a list of names"),
            );
        }
        good
    }

    fn include(&mut self, path: &Value) -> Table {
        let span = path.span();
        let Some(text) = path.get_ref().as_str() else { return Table::new() };
        let depth = self.open.len();
        let Some((from, at)) = self.open.last_mut() else { return Table::new() };
        *at = span.clone();
        let from = from.clone();
        if depth >= MAX_INCLUDES || self.sources.sources().len() >= MAX_SOURCES {
            let message = if depth >= MAX_INCLUDES {
                format!("presets include one another more than {MAX_INCLUDES} deep")
            } else {
                format!("the preset is made of more than {MAX_SOURCES} texts")
            };
            let diagnostic = self.chain(Diagnostic::error("include-depth", message).at(span, ""));
            // Once is enough: a fan of includes would tell it thousands of times.
            if !self.diagnostics.list().iter().any(|d| d.code == "include-depth") {
                self.diagnostics.push(diagnostic);
            }
            return Table::new();
        }
        match self.loader.load(text, &from) {
            Err(message) => {
                let diagnostic = self.chain(Diagnostic::error("no-file", message).at(span, ""));
                self.diagnostics.push(diagnostic);
                Table::new()
            }
            Ok(loaded) if self.open.iter().any(|(name, _)| *name == loaded.name) => {
                let mut names: Vec<&str> = self.open.iter().map(|(name, _)| name.as_str()).collect();
                names.push(&loaded.name);
                let message = format!("presets include one another in a circle: {}", names.join(" → "));
                let diagnostic = self.chain(Diagnostic::error("include-cycle", message).at(span, ""));
                self.diagnostics.push(diagnostic.help("remove one of the includes"));
                Table::new()
            }
            Ok(loaded) => self.read(loaded),
        }
    }

    /// Show how the text with the error came to be read.
    fn chain(&self, mut diagnostic: Diagnostic) -> Diagnostic {
        let outer = self.open.len().saturating_sub(1);
        for (_, span) in self.open[..outer].iter().rev() {
            diagnostic = diagnostic.and(span.clone(), "included from here");
        }
        diagnostic
    }
}

/// Lay `over` over `under`.
pub fn merge(under: &mut Table, over: Table) {
    for (key, value) in over {
        let both_tables = value.get_ref().as_table().is_some_and(|new| {
            let old = under.get(key.get_ref().as_str()).and_then(|old| old.get_ref().as_table());
            old.is_some_and(|old| !changes_op(old, new))
        });
        if !both_tables {
            // The key's place is the later one, too.
            under.remove(key.get_ref().as_str());
            under.insert(key, value);
            continue;
        }
        let old = under.get_mut(key.get_ref().as_str()).and_then(|old| old.get_mut().as_table_mut());
        if let (Some(old), Item::Table(new)) = (old, value.into_inner()) {
            merge(old, new);
        }
    }
}

fn changes_op(old: &Table, new: &Table) -> bool {
    let op = |t: &Table| t.get("op").and_then(|v| v.get_ref().as_str().map(str::to_owned));
    op(new).is_some_and(|new| op(old).is_some_and(|old| old != new))
}
