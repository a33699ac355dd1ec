//! What the window asks of the machine: files are read and written by who opened it.

use std::path::PathBuf;
use std::sync::Arc;

use super::problem::Problem;
use crate::graph::Graph;
use crate::maps::TextureSet;
use crate::preset::{Document, PresetError};
use crate::scene::{EnvironmentImage, SceneSpec};

/// A preset that was read.
#[derive(Clone, Debug)]
pub struct Opened {
    /// What it was asked for by: a file's path, or the name of a built-in preset.
    pub word: String,
    /// Its tables, with everything that it includes.
    pub document: Document,
    /// The folder that its image files are relative to.
    pub folder: PathBuf,
    /// [`Desk::stamp`] of it, from before it was read.
    pub stamp: u64,
}

/// A scene that was read.
#[derive(Clone, Debug)]
pub struct OpenedScene {
    /// Its text.
    pub spec: SceneSpec,
    /// The picture of its environment, if it has one.
    pub picture: Option<Arc<EnvironmentImage>>,
}

/// Reads and writes files for the window; called from its threads.
pub trait Desk: Send + Sync {
    /// Read a preset, whatever was read before.
    ///
    /// # Errors
    /// Everything that is wrong with its text.
    fn open(&self, word: &str) -> Result<Opened, Vec<Problem>>;
    /// A number that is another one once any file of the preset has changed.
    fn stamp(&self, opened: &Opened) -> u64;
    /// Read the image files of a graph into it.
    ///
    /// # Errors
    /// Every file that cannot be read, at the place that names it.
    fn images(&self, opened: &Opened, graph: &mut Graph) -> Result<(), PresetError>;
    /// Read a scene.
    ///
    /// # Errors
    /// Everything that is wrong with its text, or a picture that cannot be read.
    fn scene(&self, word: &str) -> Result<OpenedScene, Vec<Problem>>;
    /// Bytes that maps may take; `None` where nobody knows.
    fn memory(&self) -> Option<u64>;
    /// Write a text to a file, whole or not at all.
    ///
    /// # Errors
    /// A sentence.
    fn save(&self, path: &str, text: &str) -> Result<(), String>;
    /// Write a set of maps to a folder, whole or not at all; returns what was written, in a few words.
    ///
    /// # Errors
    /// A sentence.
    fn export(&self, set: &TextureSet, folder: &str) -> Result<String, String>;
}
