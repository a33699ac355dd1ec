//! The one integration-test binary: what holds across rooms.

mod bad_presets;
mod cli;
mod conformance;
mod demand;
mod determinism;
mod docs;
mod film;
mod golden;
mod layers;
mod made;
mod memory;
mod mutations;
#[cfg(feature = "preview")]
mod preview;
mod registration;
mod render;
mod report;
mod resolution;
mod series;
mod slabs;
mod species;
mod tiling;
#[cfg(feature = "viewer")]
mod view;
