//! convert nodes.
use super::Op;

/// The operations of this category.
pub const OPS: &[Op] = &[];
