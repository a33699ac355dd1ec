//! Filters: an image from an image, at a texel or around it.
//!
//! | Files | What they share |
//! | --- | --- |
//! | `levels`, `curve`, `histogram_scan`, `clamp`, `invert`, `threshold` | texel by texel |
//! | `gaussian_blur`, `box_blur` | `separable`: two one-dimensional passes |
//! | `edge_detect` | three rows |
//! | `distance`, `outline`, `morphology` | `edt`: distance on the torus |
//! | `directional_blur` | shifted rows, weighted |
//! | `warp`, `transform` | `sample`: bilinear look-up anywhere |
//! | `normalise` | the range of the whole plane |
//!
//! Lengths are fractions of the tile's shorter physical side or mm; angles are degrees, 0 around the body (+u) and
//! 90 tail-ward (+v).

mod box_blur;
mod clamp;
mod curve;
mod directional_blur;
mod distance;
mod edge_detect;
mod edt;
mod gaussian_blur;
mod histogram_scan;
mod invert;
mod levels;
mod morphology;
mod normalise;
mod outline;
mod sample;
mod separable;
#[cfg(test)]
mod testing;
mod threshold;
mod transform;
mod warp;

use super::Op;

pub use box_blur::BoxBlur;
pub use clamp::Clamp;
pub use curve::{Curve, Interpolation};
pub use directional_blur::DirectionalBlur;
pub use distance::Distance;
pub use edge_detect::{EdgeDetect, Measure, Operator};
pub use edt::LengthUnit;
pub use gaussian_blur::GaussianBlur;
pub use histogram_scan::HistogramScan;
pub use invert::Invert;
pub use levels::Levels;
pub use morphology::{Dilate, Erode};
pub use normalise::Normalise;
pub use outline::{Outline, Placement};
pub use threshold::{Edge, Threshold};
pub use transform::{StretchProfile, Transform};
pub use warp::{DirectionalWarp, Warp};

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<Levels>(),
    Op::of::<Curve>(),
    Op::of::<HistogramScan>(),
    Op::of::<Threshold>(),
    Op::of::<Clamp>(),
    Op::of::<Invert>(),
    Op::of::<Normalise>(),
    Op::of::<GaussianBlur>(),
    Op::of::<BoxBlur>(),
    Op::of::<DirectionalBlur>(),
    Op::of::<EdgeDetect>(),
    Op::of::<Distance>(),
    Op::of::<Outline>(),
    Op::of::<Dilate>(),
    Op::of::<Erode>(),
    Op::of::<Warp>(),
    Op::of::<DirectionalWarp>(),
    Op::of::<Transform>(),
];

/// Infinity (an overflow of finite values) as the greatest finite value of its sign.
#[inline(always)]
fn finite(x: f32) -> f32 {
    x.max(f32::MIN).min(f32::MAX)
}
