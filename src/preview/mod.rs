//! THE PICTURE, NOW: a scene drawn on a GPU, without a window. Imports optics and scene.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Gpu`] | an adapter and its device; software Vulkan counts |
//! | [`PreviewError`] | why there is no picture |
//! | [`SkinProgram`], [`SkinOptions`] | the shader of one material: only what it has |
//! | [`SkinData`], [`binding`] | its numbers and tables, and bind group 1 |
//! | [`lobe`] | what gloss does to light from all around |
//!
//! Nothing here panics over what a machine lacks: what cannot be done comes back as an error that names the number.

pub mod binding;
pub mod device;
pub mod error;
pub mod lobe;
pub mod material;
pub mod program;

pub use device::Gpu;
pub use error::PreviewError;
pub use material::{MaterialUniform, SkinData};
pub use program::{SkinOptions, SkinProgram, Slot};

#[cfg(test)]
mod skin_tests;
