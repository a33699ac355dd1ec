//! Presets from files and from the binary, with what the command line lays over them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::exit::{Exit, Failure};
use super::render;
use crate::graph::{self, Graph};
use crate::io;
use crate::preset::builtin::{self, Builtins};
use crate::preset::document::MAX_TEXT;
use crate::preset::{Diagnostic, Diagnostics, Document, Loaded, Loader, PresetError, overrides};

/// Reads presets from files, and from the binary where there is no such file.
#[derive(Debug, Default)]
pub(super) struct Files {
    /// The name that each file was first shown by: one file has one name, however it is reached.
    shown: RefCell<BTreeMap<PathBuf, String>>,
}

impl Loader for Files {
    fn load(&self, path: &str, from: &str) -> Result<Loaded, String> {
        if builtin::is_builtin(from) || builtin::is_builtin(path) {
            return Builtins.load(path, from);
        }
        let file = Path::new(from).parent().unwrap_or(Path::new("")).join(path);
        match self.read(&file).map_err(|(_, message)| message) {
            // A file may include a built-in preset by its plain name.
            Err(_) if !file.exists() && !path.contains(['/', '\\']) && Builtins.load(path, from).is_ok() => {
                Builtins.load(path, from)
            }
            read => read,
        }
    }
}

impl Files {
    /// Read a file, or say why not and whether that is the file system's fault or the file's.
    fn read(&self, path: &Path) -> Result<Loaded, (Exit, String)> {
        let shown = path.display();
        let fail = |e: std::io::Error| (Exit::File, format!("{shown} cannot be read: {}", plain(&e)));
        let file = std::fs::File::open(path).map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if metadata.is_dir() {
            return Err((Exit::File, format!("{shown} is a directory, not a preset")));
        }
        if metadata.len() > MAX_TEXT as u64 {
            let length = metadata.len();
            return Err((Exit::Bad, format!("{shown} has {length} bytes; a preset has at most {MAX_TEXT}")));
        }
        // A pipe has no length: never read more than is refused below.
        let mut bytes = Vec::new();
        file.take(MAX_TEXT as u64 + 1).read_to_end(&mut bytes).map_err(fail)?;
        let identity = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let mut names = self.shown.borrow_mut();
        let name = names.entry(identity).or_insert_with(|| shown.to_string()).clone();
        Ok(Loaded { name, bytes })
    }
}

/// An operating system's error without its number.
pub(super) fn plain(error: &std::io::Error) -> String {
    match io::Problem::from(std::io::Error::from(error.kind())) {
        io::Problem::Os(_) => error.to_string(),
        problem => problem.to_string(),
    }
}

/// A preset that is read and layered, not yet a graph.
#[derive(Clone, Debug)]
pub(super) struct Preset {
    /// Its text as tables.
    pub(super) document: Document,
    /// The folder that its image files are relative to.
    pub(super) folder: PathBuf,
}

impl Preset {
    /// Read what `word` means: a file, or a built-in preset by name; then lay the settings over it.
    ///
    /// # Errors
    /// If there is no such preset, or any of its texts or the settings cannot be read.
    pub(super) fn open(word: &str, settings: &[String]) -> Result<Self, Failure> {
        let files = Files::default();
        // A common name may hold a slash: "Urutu / crossed pit viper".
        let is_path = || word.contains(['/', '\\']) && builtin::named(word).is_err();
        let is_file = word.ends_with(".toml") || Path::new(word).is_file() || is_path();
        let loaded = if is_file {
            files.read(Path::new(word)).map_err(|(exit, message)| Failure::Message {
                exit,
                message,
                help: file_help(word),
            })?
        } else {
            let name = builtin::named(word).map_err(|help| {
                Failure::usage(format!("there is no built-in preset `{}`", short(word)), help)
            })?;
            Builtins.load(name, "").map_err(|message| Failure::usage(message, ""))?
        };
        let folder = if builtin::is_builtin(&loaded.name) {
            PathBuf::new()
        } else {
            Path::new(&loaded.name).parent().unwrap_or(Path::new("")).to_owned()
        };
        let mut document = Document::load_text(loaded, &files)?;
        let mut diagnostics = Diagnostics::new();
        for setting in settings {
            overrides::apply(&mut document, setting, &mut diagnostics);
        }
        diagnostics.finish(&document.sources)?;
        Ok(Self { document, folder })
    }

    /// Its graph with its images; warnings are told.
    ///
    /// # Errors
    /// Everything that is wrong with the preset.
    pub(super) fn graph(&self) -> Result<Graph, PresetError> {
        let (mut graph, warnings) = graph::build(&self.document)?;
        render::warnings(&warnings, &self.document.sources);
        self.load_assets(&mut graph)?;
        Ok(graph)
    }

    /// Read the image files of a graph into it; every one that cannot be read is an error at the place that names it.
    pub(super) fn load_assets(&self, graph: &mut Graph) -> Result<(), PresetError> {
        let files: Vec<String> = graph.files().into_iter().map(str::to_owned).collect();
        match io::load_assets(files.iter().map(String::as_str), &self.folder) {
            Ok(assets) => {
                graph.assets = assets;
                Ok(())
            }
            Err(errors) => {
                let diagnostics =
                    errors.into_iter().map(|(file, error)| self.bad_image(&file, &error)).collect();
                Err(PresetError { diagnostics, sources: self.document.sources.clone() })
            }
        }
    }

    /// A file that cannot be read, at the string that names it.
    fn bad_image(&self, file: &str, error: &io::IoError) -> Diagnostic {
        let mut diagnostic = Diagnostic::error("bad-image", error.to_string());
        if let Some(span) = find_text(&self.document.root, file) {
            diagnostic = diagnostic.at(span, "");
        }
        let beside = "image files are looked for beside the preset";
        diagnostic.help(error.help().unwrap_or(beside))
    }
}

/// The place of the first string that is `text`, anywhere in a table.
fn find_text(table: &crate::preset::Table, text: &str) -> Option<crate::preset::Span> {
    use crate::preset::{Item, Value};
    fn inside(value: &Value, text: &str) -> Option<crate::preset::Span> {
        match value.get_ref() {
            Item::String(s) if s == text => Some(value.span()),
            Item::Array(items) => items.iter().find_map(|v| inside(v, text)),
            Item::Table(table) => find_text(table, text),
            _ => None,
        }
    }
    table.values().find_map(|v| inside(v, text))
}

fn file_help(word: &str) -> Option<String> {
    let stem = Path::new(word).file_stem()?.to_str()?;
    match builtin::named(stem) {
        Ok(name) => Some(format!("the built-in preset is named without a path: {name}")),
        Err(help) if help.starts_with("did you mean") => Some(help),
        Err(_) => None,
    }
}

/// A word for a message.
pub(super) fn short(word: &str) -> String {
    word.chars().take(80).collect()
}
