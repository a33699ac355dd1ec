//! What a preset is called and what it tells of itself; and the individual of it.

use super::{Graph, read};
use crate::base::hash;
use crate::preset::{Diagnostic, Diagnostics, Document, PresetError, Value};

/// Keys of a preset's root that describe it and change nothing that it makes.
pub const ABOUT: [&str; 3] = ["name", "common_name", "description"];

/// Longest name of a preset, characters; file names are made of it.
const MAX_NAME: usize = 64;

/// Build the graph of a preset; `seed` is another individual than the preset's own. Warnings are dropped:
/// [`super::build`] hands them out.
///
/// # Errors
/// Everything that is wrong with the preset, with its places.
pub fn from_document(document: &Document, seed: Option<u64>) -> Result<Graph, PresetError> {
    let (graph, _) = read::build(document)?;
    Ok(match seed {
        Some(seed) => graph.with_seed(seed),
        None => graph,
    })
}

impl Graph {
    /// The same graph for another individual.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        for node in &mut self.nodes {
            node.seed = hash::node_seed(seed, &node.name);
        }
        self
    }
}

/// A text that describes the preset: the value of `name`, `common_name` or `description`.
pub fn about<'a>(document: &'a Document, key: &str) -> Option<&'a str> {
    document.root.get(key)?.get_ref().as_str()
}

/// The preset's name: its own `name` (not one that it includes), else its file's stem.
pub(super) fn name(document: &Document, diagnostics: &mut Diagnostics) -> String {
    for key in ABOUT {
        if let Some(value) = document.root.get(key).filter(|v| v.get_ref().as_str().is_none()) {
            let message = format!("`{key}` is {}, not text", value.get_ref().kind());
            let label = "expected text in quotes";
            diagnostics.push(Diagnostic::error("wrong-type", message).at(value.span(), label));
        }
    }
    let own = document.root.get("name").filter(|value| is_own(document, value));
    if let Some((value, name)) = own.and_then(|value| Some((value, value.get_ref().as_str()?))) {
        if is_name(name) {
            return name.to_owned();
        }
        let message = "the preset's name becomes part of file names and cannot be this";
        let help =
            format!("use at most {MAX_NAME} letters, digits, `_` and `-`; `common_name` takes any text");
        diagnostics.push(Diagnostic::error("bad-name", message).at(value.span(), "").help(help));
    }
    stem(&document.name)
}

/// Whether a text can name a preset.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty() && name.len() <= MAX_NAME && name.chars().all(is_legal)
}

fn is_legal(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}

/// Whether a value stands in the outermost text or in an override, not in what the preset includes.
fn is_own(document: &Document, value: &Value) -> bool {
    let source = document.sources.source_at(value.span().start);
    let name = source.and_then(|i| document.sources.sources().get(i)).map(|s| s.name.as_str());
    source == Some(0) || name.is_some_and(|n| n.starts_with("--set "))
}

/// The file's name without folder and ending, made fit for file names.
fn stem(path: &str) -> String {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let stem: String = stem.chars().take(MAX_NAME).map(|c| if is_legal(c) { c } else { '_' }).collect();
    if stem.is_empty() { "preset".into() } else { stem }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::{Loaded, Loader, overrides};

    struct Base;

    impl Loader for Base {
        fn load(&self, path: &str, _: &str) -> Result<Loaded, String> {
            Ok(Loaded { name: path.into(), bytes: b"name = 'base'\ncommon_name = 'Base'\nseed = 3".into() })
        }
    }

    fn load(file: &str, text: &str, set: &[&str]) -> Document {
        let text = Loaded { name: file.into(), bytes: text.into() };
        let mut document = Document::load_text(text, &Base).expect("valid TOML");
        let mut diagnostics = Diagnostics::new();
        for setting in set {
            assert!(overrides::apply(&mut document, setting, &mut diagnostics));
        }
        document
    }

    #[test]
    fn a_preset_is_named_by_itself_then_by_its_file_never_by_what_it_includes() {
        let name = |file, text, set: &[&str]| from_document(&load(file, text, set), None).map(|g| g.name);
        assert_eq!(name("a/my snake.v2.toml", "", &[]), Ok("my_snake_v2".into()));
        assert_eq!(name("a.toml", "name = 'b-2'", &[]), Ok("b-2".into()));
        assert_eq!(name("a.toml", "include = 'base.toml'", &[]), Ok("a".into()));
        assert_eq!(name("a.toml", "include = 'base.toml'", &["name=c"]), Ok("c".into()));
        for bad in ["name = '../x'", "name = ''", "name = 3", "description = []"] {
            assert!(name("a.toml", bad, &[]).is_err(), "{bad}");
        }
    }

    #[test]
    fn another_seed_is_what_the_preset_with_that_seed_would_be() {
        let text = "[nodes.n]\nop = 'perlin_noise'\n[maps]\nheight = { from = 'n', range = [0, 1] }";
        let own = from_document(&load("a.toml", &format!("seed = 7\n{text}"), &[]), None).expect("sound");
        let other = from_document(&load("a.toml", text, &[]), Some(7)).expect("sound");
        let seeds = |g: &Graph| (g.seed, g.nodes.iter().map(|n| n.seed).collect::<Vec<_>>());
        assert_eq!(seeds(&own), seeds(&other));
        assert_ne!(seeds(&own), seeds(&own.clone().with_seed(8)));
    }
}
