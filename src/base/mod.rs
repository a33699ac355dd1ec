//! GROUND FLOOR: the types every room shares. Imports nothing of ours.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Plane`], [`Rows`] | one f32 image on the torus, and a toroidal window of its rows |
//! | [`Domain`] | the grid: size in texels and in millimetres |
//! | [`hash`] | counter-based integer hashing, the only source of randomness |
//! | [`num`] | portable, vectorisable elementary functions |
//! | [`sdf`] | exact signed distances to plane shapes |
//! | [`simd`] | run-time dispatch that can be forced, with equal bits at every level |
//! | [`color`] | linear and sRGB colour as different types, Oklab, HSL |
//! | [`params`] | settings held against the ranges that their struct declares |
//! | [`kept`] | room to work in that is kept from one band to the next |
//! | [`pages`] | numbers in large pages, where the system has them |
//! | [`watch`] | telling what is at work, without a clock |
//! | [`MapKind`] | the maps a texture set can hold |

pub mod color;
pub mod domain;
pub mod hash;
pub mod kept;
pub mod map_kind;
pub mod num;
pub mod pages;
pub mod params;
pub mod plane;
pub mod sdf;
pub mod simd;
pub mod watch;

pub use color::{LinearRgb, Srgb8};
pub use domain::Domain;
pub use map_kind::MapKind;
pub use params::ParamError;
pub use plane::{Plane, Rows};
