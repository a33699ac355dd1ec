//! The one integration-test binary: what holds across rooms.

mod bad_presets;
mod cli;
mod conformance;
mod docs;
mod layers;
mod mutations;
