//! What a surface is made of: constants, and maps over them.

use std::sync::Arc;

use crate::base::LinearRgb;
use crate::optics::layered::Constants;

/// A surface. Where [`Material::maps`] has a map, it stands in place of the constant.
#[derive(Clone, Debug)]
pub struct Material {
    /// Indices, absorption, base and energy mode.
    pub constants: Constants,
    /// Albedo where there is no colour map.
    pub color: LinearRgb,
    /// Perceptual roughness (alpha = roughness^2) where there is no map, in [0, 1].
    pub roughness: f32,
    /// Film thickness where there is no map, nm; 0 is no film.
    pub thickness_nm: f32,
    /// The maps of a texture set.
    pub maps: Option<Arc<SkinMaps>>,
}

/// The maps of a set that shading reads, interleaved: one place, one read.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinMaps {
    /// Texels across u.
    pub width: usize,
    /// Texels along v.
    pub height: usize,
    /// Row by row; v = 0 first.
    pub texels: Vec<Texel>,
    /// Height of the surface, mm, if the set has it: row by row.
    pub height_mm: Option<Vec<f32>>,
    /// Physical size of the tile, mm: u, then v.
    pub size_mm: [f32; 2],
}

/// One texel, 32 bytes. What the set lacks is filled with the material's constants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Texel {
    /// Apparent albedo, linear RGB.
    pub color: [f32; 3],
    /// Perceptual roughness.
    pub roughness: f32,
    /// Unit normal in tangent space (OpenGL: x along growing u, y up the image, which is towards smaller v).
    pub normal: [f32; 3],
    /// Film thickness, nm.
    pub thickness_nm: f32,
}
