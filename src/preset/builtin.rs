//! The presets that come with the library, in its binary.

use super::diagnostic::PresetError;
use super::document::Document;
use super::include::{Loaded, Loader};
use super::suggest;

/// Start of the names of built-in texts in messages.
const FOLDER: &str = "builtin/";

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../presets/", $name, ".toml")))),*]
    };
}

/// Every built-in preset: name and text, sorted by name.
pub const BUILTIN: &[(&str, &str)] = presets![
    "acrochordus_javanicus",
    "atheris_hispida",
    "bitis_gabonica",
    "bitis_nasicornis",
    "bothrops_alternatus",
    "bungarus_fasciatus",
    "crotalus_atrox",
    "dendroaspis_viridis",
    "drymarchon_couperi",
    "epicrates_cenchria",
    "erythrolamprus_miliaris",
    "lampropeltis_triangulum",
    "leiopython_albertisii",
    "malayopython_reticulatus",
    "micrurus_diastema",
    "morelia_viridis",
    "pantherophis_guttatus",
    "phalotris_lemniscatus",
    "philodryas_aestiva",
    "philodryas_olfersii",
    "ptychophis_flavovirgatus",
    "python_regius",
    "thamnophis_sirtalis",
    "xenopeltis_unicolor",
];

/// The text of a built-in preset.
pub fn find(name: &str) -> Option<&'static str> {
    let at = BUILTIN.binary_search_by_key(&name, |(name, _)| name).ok()?;
    Some(BUILTIN[at].1)
}

/// The name of the built-in preset that `word` means: its name in any case, spaces or hyphens for underscores, or
/// its common name. The nearest ones are in the error.
///
/// # Errors
/// What to do instead: a suggestion, or the list of names.
pub fn named(word: &str) -> Result<&'static str, String> {
    let plain = |text: &str| text.trim().to_lowercase().replace([' ', '-'], "_").replace(['\'', '’'], "");
    let wanted = plain(word);
    if let Some((name, _)) = BUILTIN.iter().find(|(name, _)| *name == wanted) {
        return Ok(name);
    }
    let common: Vec<(&str, String)> = BUILTIN
        .iter()
        .flat_map(|(name, text)| common_names(text).into_iter().map(|common| (*name, plain(&common))))
        .collect();
    if let Some((name, _)) = common.iter().find(|(_, common)| *common == wanted) {
        return Ok(name);
    }
    let names = BUILTIN.iter().map(|(name, _)| *name);
    let near = suggest::nearest(&wanted, names.chain(common.iter().map(|(_, common)| common.as_str())));
    // A near common name stands for the preset that has it.
    let near = near.map(|near| common.iter().find(|(_, c)| c == near).map_or(near, |(name, _)| *name));
    Err(match near {
        Some(near) => format!("did you mean `{near}`?"),
        None => "`ophidian presets` lists the built-in ones; a file's name ends in .toml".into(),
    })
}

/// The common name, as a whole and in parts: "Milk snake (red form)" is also "Milk snake", "Urutu / crossed pit
/// viper" is also each of the two.
fn common_names(text: &str) -> Vec<String> {
    let document = Document::parse("", text).ok();
    let name = document.as_ref().and_then(|d| d.root.get("common_name")?.get_ref().as_str());
    let Some(name) = name else { return Vec::new() };
    let short = name.split_once(" (").map_or(name, |(short, _)| short);
    let parts = std::iter::once(name).chain(std::iter::once(short)).chain(short.split(" / "));
    parts.map(str::to_owned).collect()
}

/// Loads built-in presets only: what a library user without files, and the presets' own includes, need.
#[derive(Clone, Copy, Debug, Default)]
pub struct Builtins;

impl Loader for Builtins {
    fn load(&self, path: &str, _from: &str) -> Result<Loaded, String> {
        let file = path.strip_prefix(FOLDER).unwrap_or(path);
        let name = file.strip_suffix(".toml").unwrap_or(file);
        match find(name) {
            Some(text) => Ok(Loaded { name: format!("{FOLDER}{name}.toml"), bytes: text.into() }),
            None => {
                let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
                let help = suggest::nearest(name, names).map(|n| format!("; did you mean `{n}`?"));
                let name: String = name.chars().take(80).collect();
                Err(format!("there is no built-in preset `{name}`{}", help.unwrap_or_default()))
            }
        }
    }
}

/// Whether a source of this name is a built-in preset's text.
pub fn is_builtin(source: &str) -> bool {
    source.starts_with(FOLDER)
}

/// The document of a built-in preset.
///
/// # Errors
/// If there is none of this name (or, a mistake of ours, it is not sound).
pub fn document(name: &str) -> Result<Document, PresetError> {
    Document::load(name, &Builtins)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_lists_exactly_the_files_of_the_folder_in_order() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/presets");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .expect("the folder presets/")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("an ASCII name"))
            .filter_map(|file| file.strip_suffix(".toml").map(str::to_owned))
            .collect();
        files.sort();
        let table: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
        assert_eq!(table, files);
        for name in table {
            assert!(name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'), "{name}");
        }
    }

    #[test]
    fn presets_are_found_by_name_in_any_writing_and_by_common_name() {
        for word in
            ["lampropeltis_triangulum", "Lampropeltis triangulum", "LAMPROPELTIS-TRIANGULUM", "milk snake"]
        {
            assert_eq!(named(word), Ok("lampropeltis_triangulum"), "{word}");
        }
        for word in ["lampropeltis_triangulun", "milk snak"] {
            assert_eq!(named(word), Err("did you mean `lampropeltis_triangulum`?".into()), "{word}");
        }
        assert!(named("zzz").is_err_and(|help| help.contains("ophidian presets")));
    }

    #[test]
    fn parts_of_common_names_are_names() {
        let names = |name: &str| common_names(&format!("common_name = '{name}'"));
        assert_eq!(names("Milk snake (red form)")[1..], ["Milk snake", "Milk snake"]);
        assert_eq!(names("Urutu / crossed pit viper")[2..], ["Urutu", "crossed pit viper"]);
        assert!(common_names("common_name = 3").is_empty() && common_names("x").is_empty());
    }

    #[test]
    fn the_loader_names_texts_and_refuses_strangers() {
        let loaded = Builtins.load("lampropeltis_triangulum.toml", "").expect("a built-in preset");
        assert!(is_builtin(&loaded.name));
        assert_eq!(Builtins.load(&loaded.name, "").expect("by its own name"), loaded);
        assert!(Builtins.load("../Cargo.toml", "").is_err());
    }
}
