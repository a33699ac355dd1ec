//! THE PICTURE, NOW: a scene drawn on a GPU, without a window. Imports optics and scene.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Gpu`] | an adapter and its device; software Vulkan counts |
//! | [`PreviewError`] | why there is no picture |
//!
//! Nothing here panics over what a machine lacks: what cannot be done comes back as an error that names the number.

pub mod device;
pub mod error;

pub use device::Gpu;
pub use error::PreviewError;
