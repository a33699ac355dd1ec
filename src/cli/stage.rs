//! What is rendered: a scene from its text, and a skin from a preset or a directory of maps.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::args::SizeArg;
use super::exit::{Exit, Failure};
use super::load::{Files, Preset};
use super::progress::Progress;
use super::{generate, memory, render};
use crate::base::MapKind;
use crate::eval::{self, Control};
use crate::io;
use crate::maps::{SetId, TextureSet, assemble};
use crate::preset::{Diagnostics, Document, Loaded, Loader, overrides};
use crate::scene::build::Inputs;
use crate::scene::builtin::{self, BuiltinScenes};
use crate::scene::import::{self, ImportError};
use crate::scene::spec::{self, SceneSpec};
use crate::scene::{EnvironmentImage, Mesh, Scene, SkinMaps};

/// A scene's text with the picture of its environment.
pub(super) struct SceneText {
    pub(super) spec: SceneSpec,
    pub(super) picture: Option<Arc<EnvironmentImage>>,
}

/// Reads scenes from files, and from the binary where there is no such file.
#[derive(Default)]
struct SceneFiles(Files);

impl Loader for SceneFiles {
    fn load(&self, path: &str, from: &str) -> Result<Loaded, String> {
        let file = Path::new(from).parent().unwrap_or(Path::new("")).join(path);
        let is_word = !path.ends_with(".toml") && !path.contains(['/', '\\']);
        if from.starts_with(builtin::FOLDER) || (is_word && !file.exists()) {
            return BuiltinScenes.load(path, from);
        }
        self.0.load(path, from)
    }
}

/// Read what `word` means: a scene file, or a built-in scene; then lay the settings over it.
///
/// # Errors
/// If there is no such scene, or its text, the settings or its picture cannot be read.
pub(super) fn text(word: &str, settings: &[String]) -> Result<SceneText, Failure> {
    let path = Path::new(word);
    let is_file = word.ends_with(".toml") || word.contains(['/', '\\']) || path.is_file();
    let mut document = if is_file {
        let files = SceneFiles::default();
        let loaded = files.load(word, "").map_err(|message| Failure::Message {
            exit: Exit::File,
            message,
            help: Some("built-in scenes are named without .toml".into()),
        })?;
        Document::load_text(loaded, &files)?
    } else {
        let loaded: Loaded = BuiltinScenes.load(word, "").map_err(|message| {
            let names: Vec<&str> = builtin::BUILTIN.iter().map(|(name, _)| *name).collect();
            Failure::usage(message, format!("scenes: {}; or a file that ends in .toml", names.join(", ")))
        })?;
        Document::load_text(loaded, &BuiltinScenes)?
    };
    let mut diagnostics = Diagnostics::new();
    for setting in settings {
        overrides::apply(&mut document, setting, &mut diagnostics);
    }
    diagnostics.finish(&document.sources)?;
    let (mut spec, warnings) = spec::read(&document)?;
    render::warnings(&warnings, &document.sources);
    if spec.name.is_empty() {
        spec.name = path.file_stem().map_or(word.into(), |s| s.to_string_lossy().into_owned());
    }
    let folder = if is_file { path.parent() } else { None }.unwrap_or(Path::new(""));
    let picture = spec.environment.picture().map(|file| picture(&folder.join(file))).transpose()?;
    Ok(SceneText { spec, picture: picture.map(Arc::new) })
}

/// Where a skin comes from.
pub(super) struct Source<'a> {
    /// A preset, or a directory.
    pub(super) word: &'a str,
    /// Over the preset's own.
    pub(super) settings: &'a [String],
    /// The individual, unless the preset's own.
    pub(super) seed: Option<u64>,
    /// Of the maps of a preset.
    pub(super) size: SizeArg,
}

/// Refuse options that shape the maps of a preset where the skin is a directory, whose maps are made: each option with
/// whether it was given.
///
/// # Errors
/// The first one that would do nothing.
pub(super) fn refuse_for_sets(word: &str, options: &[(&str, bool)]) -> Result<(), Failure> {
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) if Path::new(word).is_dir() => Err(Failure::usage(
            format!("{option} does nothing to `{word}`, a directory of maps that are made"),
            "render the preset itself, or `ophidian generate` other maps",
        )),
        _ => Ok(()),
    }
}

/// Maps to render, and whose they are.
pub(super) struct Skin {
    /// Name of the preset.
    pub(super) name: String,
    maps: Arc<TextureSet>,
}

impl Skin {
    /// Evaluate a preset, or read a directory that `generate` wrote; only the maps that are wanted.
    ///
    /// # Errors
    /// If there is no such preset or set, it is not sound, or memory does not suffice.
    pub(super) fn load(
        source: &Source<'_>,
        wanted: &[MapKind],
        stop: &AtomicBool,
        progress: &Progress,
        pool: &rayon::ThreadPool,
    ) -> Result<Self, Failure> {
        let dir = Path::new(source.word);
        if dir.is_dir() {
            let set = io::read_set(dir, wanted)?;
            return Ok(Self { name: set.preset.clone(), maps: Arc::new(set) });
        }
        let preset = Preset::open(source.word, source.settings)?;
        let mut graph = preset.graph()?;
        if let Some(seed) = source.seed {
            graph = graph.with_seed(seed);
        }
        // A preset of nodes may lack some; the scene's material stands in.
        let wanted: Vec<MapKind> = wanted.iter().copied().filter(|k| graph.maps.contains_key(k)).collect();
        let domain = source.size.domain(graph.girth_mm, graph.length_mm);
        let plan = generate::plan(&graph, &wanted, domain, memory::budget(None))?;
        let told = |share: f32, step: &str| progress.share(share, step);
        let control = Control { cancel: Some(stop), progress: Some(&told), watch: None };
        let evaluation =
            pool.install(|| eval::run(&plan, control)).map_err(|_| Failure::Told(Exit::Interrupted))?;
        let id = SetId::new(&graph, domain);
        Ok(Self { name: graph.name, maps: Arc::new(assemble(evaluation, id)) })
    }
}

/// The scene with the skin on its subject, or on a mesh of one's own.
///
/// # Errors
/// If the subject cannot be made.
pub(super) fn build(text: &SceneText, skin: &Skin, mesh: Option<Mesh>) -> Result<Scene, Failure> {
    let spec = &text.spec;
    let set = &skin.maps;
    let inputs = Inputs {
        maps: Some(Arc::new(SkinMaps::new(set, spec.material.texel()))),
        optics: set.optics,
        mesh,
        picture: text.picture.clone(),
        size_mm: [set.domain.girth_mm, set.domain.length_mm],
    };
    Scene::build(spec, &inputs)
        .map_err(|e| Failure::usage(e, "see `ophidian schema --scene` for what a scene says"))
}

/// A mesh of one's own.
///
/// # Errors
/// If the file cannot be read, or holds no mesh that a skin can be laid on.
pub(super) fn mesh(path: &Path) -> Result<Mesh, Failure> {
    let bytes = io::read_bytes(path, import::MOST_BYTES)?;
    let read = match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("obj") => import::obj(&bytes),
        Some("glb") => import::glb(&bytes),
        _ => {
            let message = format!("{}: a mesh is an .obj or a .glb file", path.display());
            return Err(Failure::usage(message, "export it from a modelling program as glTF binary"));
        }
    };
    read.map_err(|e| Failure::Message {
        exit: if matches!(e, ImportError::Format { .. }) { Exit::File } else { Exit::Bad },
        message: format!("{}: {e}", path.display()),
        help: None,
    })
}

/// The picture of an environment.
fn picture(path: &Path) -> Result<EnvironmentImage, Failure> {
    let asset = io::read_image(path)?;
    let plane = |c: usize| asset.channels[c.min(asset.channels.len() - 1)].data();
    let texels = (0..plane(0).len()).map(|i| [0, 1, 2].map(|c| plane(c)[i])).collect();
    EnvironmentImage::new(asset.channels[0].width(), asset.channels[0].height(), texels).map_err(|e| {
        Failure::usage(
            format!("{}: {e}", path.display()),
            "an environment is linear light, finite and not negative",
        )
    })
}
