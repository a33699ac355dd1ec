//! Models of pigment: patterns that grow on a grid of their own and are then sampled.

mod field;
mod gray_scott;
mod young_automaton;

use super::Op;

pub use gray_scott::{GrayScott, Reaction};
pub use young_automaton::{Activation, YoungAutomaton};

/// The operations of this category.
pub const OPS: &[Op] = &[Op::of::<GrayScott>(), Op::of::<YoungAutomaton>()];
