//! Placement: scales and copies, placed once and painted analytically, and the areas of a mask.

mod flood_fill;
mod flood_fill_gradient;
mod flood_fill_random;
mod scale_lattice;
mod scale_lay;
mod scale_paint;
mod scale_table;
mod scale_write;
mod tile_sampler;

use super::Op;

pub use flood_fill::{Connectivity, FloodFill};
pub use flood_fill_gradient::FloodFillGradient;
pub use flood_fill_random::FloodFillRandom;
pub use scale_lattice::{MAX_SCALES, ScaleLattice, ScaleShape};
pub use tile_sampler::{
    Affect, Blending, Distribution, MaskSampling, OffsetType, Parametrization, PatternKind, SizeMode,
    Symmetry, TileSampler,
};

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<ScaleLattice>(),
    Op::of::<TileSampler>(),
    Op::of::<FloodFill>(),
    Op::of::<FloodFillGradient>(),
    Op::of::<FloodFillRandom>(),
];
