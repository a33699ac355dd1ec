//! Generators: shapes, gradients and noise. Each takes the [`super::spec::OFFSETS`] inputs `du`, `dv` last.
//!
//! Noise values lie in [0, 1], signed noise shown as `0.5 + 0.5 n`, so 0.5 is "nothing"; Worley's distances are in
//! cells. Every noise is periodic for any whole number of cells.

mod angular_gradient;
mod blue_noise;
mod constant;
mod disc;
mod ellipse;
mod fractal;
mod hexagon;
mod lattice;
mod leaf;
mod linear_gradient;
mod perlin_noise;
mod polygon;
mod profile;
mod radial_gradient;
mod rectangle;
mod rhombus;
mod ring;
mod shape;
mod simplex_noise;
mod stripes;
mod value_noise;
mod white_noise;
mod worley;

#[cfg(test)]
mod noise_tests;

use super::Op;
use crate::multiversion;

pub use angular_gradient::{AngularGradient, Rays};
pub use blue_noise::BlueNoise;
pub use constant::Constant;
pub use disc::Disc;
pub use ellipse::Ellipse;
pub use fractal::{Basis, Fractal, Sum};
pub use hexagon::Hexagon;
pub use lattice::Metric;
pub(in crate::node) use lattice::{Coords, Part, columns};
pub use leaf::Leaf;
pub use linear_gradient::LinearGradient;
pub use perlin_noise::PerlinNoise;
pub use polygon::Polygon;
pub use profile::Profile;
pub use radial_gradient::{Falloff, RadialGradient};
pub use rectangle::Rectangle;
pub use rhombus::Rhombus;
pub use ring::Ring;
pub use simplex_noise::SimplexNoise;
pub use stripes::{Direction, Stripes};
pub use value_noise::ValueNoise;
pub use white_noise::WhiteNoise;
pub use worley::Worley;

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<Constant>(),
    Op::of::<Rectangle>(),
    Op::of::<Disc>(),
    Op::of::<Ellipse>(),
    Op::of::<Ring>(),
    Op::of::<Leaf>(),
    Op::of::<Rhombus>(),
    Op::of::<Hexagon>(),
    Op::of::<Polygon>(),
    Op::of::<LinearGradient>(),
    Op::of::<RadialGradient>(),
    Op::of::<AngularGradient>(),
    Op::of::<Stripes>(),
    Op::of::<ValueNoise>(),
    Op::of::<PerlinNoise>(),
    Op::of::<SimplexNoise>(),
    Op::of::<Worley>(),
    Op::of::<Fractal>(),
    Op::of::<WhiteNoise>(),
    Op::of::<BlueNoise>(),
];

multiversion! {
    /// Signed noise to [0, 1].
    fn to_unit(out: &mut [f32]) {
        for o in out { *o = 0.5 + 0.5 * *o; }
    }
}
