//! Models of pigment: marks on the body's own coordinates, and patterns that grow on a grid of their own.

mod body_position;
mod body_stripe;
mod field;
mod gray_scott;
mod marks;
mod young_automaton;

use super::Op;

pub use body_position::BodyPosition;
pub use body_stripe::BodyStripe;
pub use gray_scott::{GrayScott, Reaction};
pub use marks::{MarkShape, Marks, Sides};
pub use young_automaton::{Activation, YoungAutomaton};

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<BodyPosition>(),
    Op::of::<BodyStripe>(),
    Op::of::<Marks>(),
    Op::of::<GrayScott>(),
    Op::of::<YoungAutomaton>(),
];
