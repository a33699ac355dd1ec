//! Inputs: what comes from files.

mod image;
mod resample;

use super::Op;

pub use image::{Channel, Encoding, Fit, Image};

/// The operations of this category.
pub const OPS: &[Op] = &[Op::of::<Image>()];
