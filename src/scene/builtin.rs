//! The scenes that come with the library, in its binary.

use super::spec::{self, SceneSpec};
use crate::preset::{Document, Loaded, Loader, PresetError, suggest};

/// Start of the names of built-in texts in messages.
pub const FOLDER: &str = "builtin/scene/";

macro_rules! scenes {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("builtin/", $name, ".toml")))),*]
    };
}

/// Every built-in scene: name and text, sorted by name.
pub const BUILTIN: &[(&str, &str)] =
    scenes!["coil", "cylinder", "loop", "macro", "plane", "s", "sphere", "straight", "studio", "thesis"];

/// The scene that is taken where none is named.
pub const DEFAULT: &str = "coil";

/// The text of a built-in scene.
pub fn find(name: &str) -> Option<&'static str> {
    BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// Loads built-in scenes only: what their own includes need.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuiltinScenes;

impl Loader for BuiltinScenes {
    fn load(&self, path: &str, _from: &str) -> Result<Loaded, String> {
        let file = path.strip_prefix(FOLDER).unwrap_or(path);
        let name = file.strip_suffix(".toml").unwrap_or(file);
        match find(name) {
            Some(text) => Ok(Loaded { name: format!("{FOLDER}{name}.toml"), bytes: text.into() }),
            None => {
                let name: String = name.chars().take(80).collect();
                let help = suggest::nearest(&name, BUILTIN.iter().map(|(known, _)| *known));
                let help = help.map(|near| format!("; did you mean `{near}`?"));
                Err(format!("there is no built-in scene `{name}`{}", help.unwrap_or_default()))
            }
        }
    }
}

/// A built-in scene.
///
/// # Errors
/// If there is none of this name (or, a mistake of ours, it is not sound).
pub fn scene(name: &str) -> Result<SceneSpec, PresetError> {
    Ok(spec::read(&Document::load(name, &BuiltinScenes)?)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_lists_exactly_the_files_of_the_folder_and_each_is_sound() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/scene/builtin");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .expect("the folder builtin/")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("an ASCII name"))
            .filter_map(|file| file.strip_suffix(".toml").map(str::to_owned))
            .collect();
        files.sort();
        assert_eq!(BUILTIN.iter().map(|(name, _)| *name).collect::<Vec<_>>(), files);
        for (name, _) in BUILTIN {
            let document = Document::load(name, &BuiltinScenes).expect("valid TOML");
            let (scene, warnings) = spec::read(&document).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((scene.name.as_str(), warnings.len()), (*name, 0));
            assert!(!scene.description.is_empty(), "{name} has no description");
        }
        assert!(find(DEFAULT).is_some());
    }

    #[test]
    fn strangers_are_refused_with_a_suggestion() {
        let error = scene("sphare").expect_err("no such scene").to_string();
        assert!(error.contains("did you mean `sphere`?"), "{error}");
    }
}
