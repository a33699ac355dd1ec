//! A desk without files, for tests.

use super::desk::{Desk, Opened, OpenedScene};
use super::problem::Problem;
use crate::graph::Graph;
use crate::maps::TextureSet;
use crate::preset::{PresetError, builtin};
use crate::scene;

/// Has the built-in presets and scenes.
pub(super) struct Table;

impl Desk for Table {
    fn open(&self, word: &str) -> Result<Opened, Vec<Problem>> {
        let document = builtin::document(word).map_err(|e| Problem::of_error(&e))?;
        Ok(Opened { word: word.into(), document, folder: Default::default(), stamp: 0 })
    }

    fn stamp(&self, _: &Opened) -> u64 {
        0
    }

    fn images(&self, _: &Opened, _: &mut Graph) -> Result<(), PresetError> {
        Ok(())
    }

    fn scene(&self, word: &str) -> Result<OpenedScene, Vec<Problem>> {
        let spec = scene::builtin::scene(word).map_err(|e| Problem::of_error(&e))?;
        Ok(OpenedScene { spec, picture: None })
    }

    fn memory(&self) -> Option<u64> {
        None
    }

    fn save(&self, path: &str, _: &str) -> Result<(), String> {
        Err(format!("{path} is no file"))
    }

    fn export(&self, _: &TextureSet, folder: &str) -> Result<String, String> {
        Err(format!("{folder} is no folder"))
    }
}
