//! `view`: opens the window, and reads and writes files for it.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;
use std::sync::Arc;

use super::args::View;
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::{memory, stage};
use crate::graph::Graph;
use crate::io::{self, WriteOptions};
use crate::maps::TextureSet;
use crate::preset::{Item, PresetError, Table, builtin};
use crate::viewer::{self, Changes, Desk, Opened, OpenedScene, Problem, Setting, Start, ViewerError};

/// Open the window, and come back once it is closed.
pub(super) fn run(args: &View) -> Result<Exit, Failure> {
    let preset = Preset::open(&args.preset, &args.set.settings)?;
    // What is wrong with the preset is told here, where the window would have nothing to show.
    preset.graph()?;
    let mut changes = Changes::new();
    if let Some(seed) = args.seed {
        let seed = i64::try_from(seed);
        let seed =
            seed.map_err(|_| Failure::usage("--seed is beyond what presets hold", "choose a smaller one"))?;
        changes.insert("seed".into(), Setting::Whole(seed));
    }
    let text = stage::text(&args.scene, &[])?;
    let desk = Files { settings: args.set.settings.clone() };
    let start = Start {
        opened: desk.opened(&args.preset, preset),
        changes,
        scene_word: args.scene.clone(),
        scene: OpenedScene { spec: text.spec, picture: text.picture },
        map_size: usize::from(args.map_size),
        size: args.size.0.map(|n| n as u32),
    };
    if let Some(threads) = args.threads {
        // Once per process, and nothing has worked yet.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    }
    viewer::run(start, Arc::new(desk)).map_err(|error| {
        let help = match &error {
            ViewerError::Adapter(_) => {
                "on Linux install a Vulkan driver; mesa-vulkan-drivers has one that is software"
            }
            ViewerError::Window(_) => "`ophidian preview` writes a picture without a display",
        };
        Failure::usage(error, help)
    })?;
    Ok(Exit::Done)
}

/// Files of this machine, with what the command line lays over presets.
struct Files {
    settings: Vec<String>,
}

impl Files {
    fn opened(&self, word: &str, preset: Preset) -> Opened {
        let mut opened =
            Opened { word: word.into(), document: preset.document, folder: preset.folder, stamp: 0 };
        opened.stamp = self.stamp(&opened);
        opened
    }
}

impl Desk for Files {
    fn open(&self, word: &str) -> Result<Opened, Vec<Problem>> {
        Preset::open(word, &self.settings).map(|preset| self.opened(word, preset)).map_err(problems)
    }

    fn stamp(&self, opened: &Opened) -> u64 {
        let mut hasher = DefaultHasher::new();
        let mut add = |path: &Path| {
            let about = std::fs::metadata(path).ok();
            about.map(|about| (about.len(), about.modified().ok())).hash(&mut hasher);
        };
        for source in opened.document.sources.sources().iter().filter(|s| !builtin::is_builtin(&s.name)) {
            add(Path::new(&source.name));
        }
        // Texts that name a file beside the preset: images.
        texts(&opened.document.root, &mut |text| {
            if text.ends_with(".png") || text.ends_with(".exr") {
                add(&opened.folder.join(text));
            }
        });
        hasher.finish()
    }

    fn images(&self, opened: &Opened, graph: &mut Graph) -> Result<(), PresetError> {
        let preset = Preset { document: opened.document.clone(), folder: opened.folder.clone() };
        preset.load_assets(graph)
    }

    fn scene(&self, word: &str) -> Result<OpenedScene, Vec<Problem>> {
        let text = stage::text(word, &[]).map_err(problems)?;
        Ok(OpenedScene { spec: text.spec, picture: text.picture })
    }

    fn memory(&self) -> Option<u64> {
        memory::budget(None)
    }

    fn save(&self, path: &str, text: &str) -> Result<(), String> {
        io::write_text(Path::new(path), text).map_err(|e| e.to_string())
    }

    fn export(&self, set: &TextureSet, folder: &str) -> Result<String, String> {
        let files = io::write_set(set, Path::new(folder), &WriteOptions::default(), &|_| ());
        files.map(|files| format!("{} maps written to {folder}", files.len())).map_err(|e| e.to_string())
    }
}

/// Every text of a table.
fn texts(table: &Table, told: &mut dyn FnMut(&str)) {
    fn inside(item: &Item, told: &mut dyn FnMut(&str)) {
        match item {
            Item::String(text) => told(text),
            Item::Array(items) => items.iter().for_each(|item| inside(item.get_ref(), told)),
            Item::Table(table) => texts(table, told),
            _ => {}
        }
    }
    table.values().for_each(|item| inside(item.get_ref(), told));
}

fn problems(failure: Failure) -> Vec<Problem> {
    match failure {
        Failure::Preset(error) => Problem::of_error(&error),
        Failure::Message { message, help, .. } => vec![Problem::plain(message, help.unwrap_or_default())],
        Failure::Told(_) => vec![Problem::plain("it cannot be read", "")],
    }
}
