//! Combiners: an image from several, texel by texel.

mod mix;

use super::Op;

pub use mix::Mix;

/// The operations of this category.
pub const OPS: &[Op] = &[Op::of::<Mix>()];
