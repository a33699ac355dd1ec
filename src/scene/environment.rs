//! What is all around: a sky, a studio, a picture, or nothing.

use std::sync::Arc;

use crate::base::LinearRgb;

/// Radiance from every direction, relative to D65.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same from everywhere; black is none.
    Constant(LinearRgb),
    /// An equirectangular picture: rows from the zenith (y up) to the nadir, columns once around.
    Image(Arc<EnvironmentImage>),
}

/// An equirectangular picture, as read from a file or computed from a formula.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Radiance, row by row; finite and not negative.
    pub texels: Vec<[f32; 3]>,
}
