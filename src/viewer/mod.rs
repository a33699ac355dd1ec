//! THE WINDOW: a preset on a snake that turns, and sliders for everything that the preset says (feature `viewer`).
//!
//! ```text
//!                 ┌─ reload ── files that changed ─┐            threads of their own: the window never waits
//!  Desk ─────────►│                                ▼
//!  (files)   Session: preset + changes, undo ──► skin ── maps, small then sharp ──► picture ── frames ──► ui
//!                 ▲                                 newest request wins                newest request wins │
//!                 └──────────────────────────────── sliders, keys, mouse ────────────────────────────────┘
//! ```
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`run`], [`Start`] | opens the window, and comes back once it is closed |
//! | [`Desk`] | what the window asks of the machine's files; the command has one |
//! | [`Problem`] | what is wrong, with its line of text |
//!
//! `ui` alone knows the window's toolkit. What a change is, what is undone, what is saved and where the camera goes is
//! tested without a window.

mod desk;
mod fields;
mod history;
mod latest;
mod map_picture;
mod orbit;
mod picture;
mod problem;
mod reload;
mod save;
mod session;
mod setting;
mod skin;
mod stage;
#[cfg(test)]
mod testing;
mod ui;

use std::sync::Arc;

pub use desk::{Desk, Opened, OpenedScene};
pub use problem::{Place, Problem};
pub use setting::{Changes, Setting};

use crate::preview::{Gpu, PreviewError};

/// What the window begins with.
#[derive(Clone, Debug)]
pub struct Start {
    /// The preset.
    pub opened: Opened,
    /// Laid over it.
    pub changes: Changes,
    /// The scene's name.
    pub scene_word: String,
    /// The scene.
    pub scene: OpenedScene,
    /// Texels of the longer side of the sharpest maps.
    pub map_size: usize,
    /// Width and height of the window, points.
    pub size: [u32; 2],
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// Nothing draws the snake.
    #[error(transparent)]
    Adapter(#[from] PreviewError),
    /// Nothing shows the window.
    #[error("no window can be opened: {0}")]
    Window(String),
}

/// Open the window, and come back once it is closed.
///
/// # Errors
/// If there is no graphics adapter or no display.
pub fn run(start: Start, desk: Arc<dyn Desk>) -> Result<(), ViewerError> {
    let gpu = Gpu::new(None)?;
    ui::run(start, gpu, desk)
}
