//! GROUND TRUTH: a spectral path tracer on the CPU. Imports optics and scene.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Renderer`] | a scene made ready; [`Renderer::render`] makes the picture |
//! | [`Settings`] | size, samples, transport, technique, sampler, stage |
//! | [`Film`], [`Pixel`] | sums of samples, their variance, and what was met first |
//!
//! Paths carry four wavelengths. At each surface one light is asked and one direction followed, weighted against each
//! other. A picture is a pure function of scene and settings: random numbers are hashes of seed, pixel, sample and bounce,
//! and a pixel is summed by one thread in the order of its samples.

mod bvh;
mod film;
mod lights;
mod path;
mod render;
mod sampler;
mod settings;
mod silhouette;
mod skin;
mod sobol;
mod surface;

#[cfg(test)]
mod tests;

pub use film::{Film, Pixel};
pub use render::{Control, RenderError, Renderer};
pub use sampler::SamplerKind;
pub use settings::{Settings, Stage, Technique, Transport};
