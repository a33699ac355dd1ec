//! Combiners: an image from several, texel by texel.
//!
//! All but [`Mix`] and [`Switch`] lay `b` on `a` by a formula and show it by `amount`, a mask. The formulas are in
//! the files of the nodes; what they share is in `blend.rs`.

mod add;
mod blend;
mod difference;
mod divide;
mod max;
mod min;
mod mix;
mod multiply;
mod overlay;
mod power;
mod screen;
mod smooth_max;
mod smooth_min;
mod soft_light;
mod subtract;
mod switch;

use super::Op;

pub use add::Add;
pub use difference::Difference;
pub use divide::Divide;
pub use max::Max;
pub use min::Min;
pub use mix::Mix;
pub use multiply::Multiply;
pub use overlay::Overlay;
pub use power::Power;
pub use screen::Screen;
pub use smooth_max::SmoothMax;
pub use smooth_min::SmoothMin;
pub use soft_light::SoftLight;
pub use subtract::Subtract;
pub use switch::Switch;

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<Mix>(),
    Op::of::<Add>(),
    Op::of::<Subtract>(),
    Op::of::<Multiply>(),
    Op::of::<Divide>(),
    Op::of::<Min>(),
    Op::of::<Max>(),
    Op::of::<SmoothMin>(),
    Op::of::<SmoothMax>(),
    Op::of::<Screen>(),
    Op::of::<Overlay>(),
    Op::of::<SoftLight>(),
    Op::of::<Difference>(),
    Op::of::<Power>(),
    Op::of::<Switch>(),
];
