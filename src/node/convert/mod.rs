//! Converters: from one physical quantity to another. Heights are in mm, so slopes are mm per mm.

mod film_thickness;
mod height_to_ambient_occlusion;
mod height_to_curvature;
mod height_to_normal;
mod height_to_translucency;

use super::Op;

pub use film_thickness::FilmThickness;
pub use height_to_ambient_occlusion::HeightToAmbientOcclusion;
pub use height_to_curvature::HeightToCurvature;
pub use height_to_normal::{HeightToNormal, NormalFormat};
pub use height_to_translucency::HeightToTranslucency;

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<HeightToNormal>(),
    Op::of::<HeightToAmbientOcclusion>(),
    Op::of::<HeightToCurvature>(),
    Op::of::<HeightToTranslucency>(),
    Op::of::<FilmThickness>(),
];

/// Steepest slope that a converter tells from a wall, mm per mm. Squares and products of two stay far below the
/// largest f32; at this slope the surface is within 1e-6 rad of vertical.
const STEEPEST: f32 = 1e6;

/// A slope limited to [`STEEPEST`]; NaN (infinite minus infinite) reads as the steepest descent.
#[inline(always)]
fn limit_slope(slope: f32) -> f32 {
    slope.max(-STEEPEST).min(STEEPEST)
}

/// Slope of the surface by central differences, per mm: `(after - before) * per_mm`, limited.
///
/// * `per_mm` - 1 / (2 texel size in mm).
#[inline(always)]
fn slope(before: f32, after: f32, per_mm: f32) -> f32 {
    limit_slope((after - before) * per_mm)
}
