//! Placement: copies on a grid, and what fills closed areas.

mod tile_sampler;

use super::Op;

pub use tile_sampler::{
    Affect, Blending, Distribution, MaskSampling, OffsetType, Parametrization, PatternKind, SizeMode,
    Symmetry, TileSampler,
};

/// The operations of this category.
pub const OPS: &[Op] = &[Op::of::<TileSampler>()];
