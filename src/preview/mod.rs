//! THE PICTURE, NOW: a scene drawn on a GPU, without a window. Imports optics and scene.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Gpu`] | an adapter and its device; software Vulkan counts |
//! | [`Renderer`], [`Options`], [`Picture`] | a scene on the device, and pictures of it in linear light |
//! | [`Development`] | what makes of linear light what a screen shows, on the device |
//! | [`PreviewError`] | why there is no picture |
//! | [`SkinProgram`], [`SkinOptions`] | the shader of one material: only what it has |
//! | [`SkinData`], [`binding`] | its numbers and tables, and bind group 1 |
//! | [`lobe`] | what gloss does to light from all around |
//! | [`orders`] | tables of the orders of a diffraction grating |
//!
//! A picture takes one pass: objects by the light of suns and rectangles, each small light with a shadow map drawn before
//! the first picture, and by the environment filtered beforehand; then what is behind them. Adapters that are programs
//! take more: triangles of the subject are recorded, each pixel of it is shaded once (deferred shading), then all else, and
//! edges are smoothed. Where pictures are averaged, each of another place
//! within pixels and with other small lights, four or more need no edges of their own. Light comes straight from its
//! source, and the environment's through everything, as `Transport::Direct` of the path tracer has it; or, where it is asked for,
//! not through what is in the picture: two or three passes more, before.
//!
//! Nothing here panics over what a machine lacks: what cannot be done comes back as an error that names the number.

mod background;
pub mod binding;
mod constants;
mod deferred;
pub mod develop;
pub mod device;
mod edges;
mod environment;
pub mod error;
mod film_table;
mod frame;
mod lamps;
mod levels;
pub mod lobe;
pub mod material;
mod mesh;
mod occlusion;
mod options;
pub mod orders;
pub mod program;
mod relief;
mod render;
mod shaded;
mod shadows;
mod slots;
mod target;
mod textures;
mod timing;
mod whole;

pub use develop::Development;
pub use device::Gpu;
pub use error::PreviewError;
pub use material::{MaterialUniform, SkinData};
pub use options::{Options, enough_triangles};
pub use program::{SkinOptions, SkinProgram, Slot};
pub use render::{Picture, Renderer};

#[cfg(test)]
mod skin_tests;
