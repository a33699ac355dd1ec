//! Generators: shapes, gradients and noise. Each takes the [`super::spec::OFFSETS`] inputs `du`, `dv` last.

mod constant;

use super::Op;

pub use constant::Constant;

/// The operations of this category.
pub const OPS: &[Op] = &[Op::of::<Constant>()];
