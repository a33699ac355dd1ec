//! Ophidian core (the architecture page is written last).
#![deny(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]
pub mod base;
pub mod eval;
pub mod node;
