//! Ophidian core (the architecture page is written last).
#![warn(unreachable_pub)]

pub mod base;
#[cfg(feature = "cli")]
pub mod cli;
pub mod eval;
pub mod graph;
#[cfg(feature = "files")]
pub mod io;
pub mod maps;
pub mod node;
pub mod plan;
pub mod preset;
pub mod skin;
