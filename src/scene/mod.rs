//! WHAT BOTH RENDERERS SEE: meshes, materials, lights, an environment and a camera. Imports optics and maps.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Scene`], [`Object`] | everything, in scene units |
//! | [`Mesh`] | triangles with normals, tangents and texture coordinates |
//! | [`Material`], [`SkinMaps`] | what a surface is made of |
//! | [`Snake`], [`Pose`] | the animal's form: how it lies, swept to a mesh |
//! | [`import`] | meshes of one's own |
//! | [`displace`], [`tangents`] | a height map moves vertices; tangents by MikkTSpace |
//! | [`Camera`], [`Light`] | where from, and by what light |
//! | [`Environment`], [`sky`], [`studio`] | what is all around, and how it is sampled |
//! | [`SceneSpec`], [`builtin`] | a scene as text, and those that come with the library |
//! | [`SceneFeatures`] | which parts a scene needs |
//! | [`tone`], [`bloom`] | exposure, and curves to what a screen shows; what a lens spreads |
//!
//! The scene unit is the diameter of the animal's body at its thickest; [`Scene::mm_per_unit`] says how long that is. x is
//! to the right, y up, z towards the viewer. No files here: images and meshes come as bytes or planes.

pub mod bloom;
pub mod build;
pub mod builtin;
pub mod camera;
pub mod curve;
pub mod displace;
pub mod environment;
pub mod features;
pub mod import;
pub mod light;
pub mod material;
pub mod mesh;
mod plain;
pub mod pose;
pub mod sky;
pub mod snake;
pub mod spec;
pub mod studio;
pub mod tangents;
pub mod tone;

pub use build::{Inputs, SceneError, skin};
pub use camera::{Camera, View};
pub use environment::{
    Environment, EnvironmentError, EnvironmentImage, EnvironmentSample, EnvironmentSampler,
};
pub use features::SceneFeatures;
pub use light::{Light, LightHit, LightSample};
pub use material::{Material, SkinMaps, Texel};
pub use mesh::Mesh;
pub use pose::Pose;
pub use snake::Snake;
pub use spec::SceneSpec;

/// Everything that is rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name in reports.
    pub name: String,
    /// Millimetres of one scene unit.
    pub mm_per_unit: f32,
    /// What there is.
    pub objects: Vec<Object>,
    /// What objects are made of.
    pub materials: Vec<Material>,
    /// Where from.
    pub camera: Camera,
    /// Lights besides the environment.
    pub lights: Vec<Light>,
    /// What is all around.
    pub environment: Environment,
    /// Factor on the picture before tone mapping, as a power of two.
    pub exposure_ev: f32,
}

/// A mesh of one material.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name in messages.
    pub name: String,
    /// Its form.
    pub mesh: Mesh,
    /// Index into [`Scene::materials`].
    pub material: usize,
}
