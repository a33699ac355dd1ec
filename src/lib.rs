//! Ophidian core (the architecture page is written last).
#![warn(unreachable_pub)]
pub mod base;
pub mod eval;
pub mod node;
