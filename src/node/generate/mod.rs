//! Generators: shapes, gradients and noise. Each takes the [`super::spec::OFFSETS`] inputs `du`, `dv` last.

mod angular_gradient;
mod constant;
mod disc;
mod ellipse;
mod hexagon;
mod leaf;
mod linear_gradient;
mod polygon;
mod profile;
mod radial_gradient;
mod rectangle;
mod rhombus;
mod ring;
mod shape;
mod stripes;

use super::Op;

pub use angular_gradient::{AngularGradient, Rays};
pub use constant::Constant;
pub use disc::Disc;
pub use ellipse::Ellipse;
pub use hexagon::Hexagon;
pub use leaf::Leaf;
pub use linear_gradient::LinearGradient;
pub use polygon::Polygon;
pub use profile::Profile;
pub use radial_gradient::{Falloff, RadialGradient};
pub use rectangle::Rectangle;
pub use rhombus::Rhombus;
pub use ring::Ring;
pub use stripes::{Direction, Stripes};

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
];
