//! The materials of a scene, ready for paths.

use super::path::Channels;
use super::surface::Point;
use crate::optics::base_layer::Base;
use crate::optics::layered::{self, Energy};
use crate::optics::{Bands, FilmError, Layers, Parts, View};
use crate::scene::Scene;

/// Every material, with its tables.
pub(super) struct Skins {
    layers: Vec<Layers<f32>>,
}

impl Skins {
    /// With the energy mode that a transport wants: light in all its ways needs every bit of energy to be somewhere.
    ///
    /// # Errors
    /// If a material has an index out of range.
    pub(super) fn new(scene: &Scene, full: bool) -> Result<Self, FilmError> {
        let layers = scene.materials.iter().map(|material| {
            let mut constants = material.constants;
            if full {
                constants.energy = Energy::Coupled;
                // Bases that wrap around are no BRDF.
                constants.base = Base::Lambert;
            }
            Layers::new(&constants)
        });
        Ok(Self { layers: layers.collect::<Result<_, _>>()? })
    }

    /// The skin at a point, seen from `wo`.
    #[inline(always)]
    pub(super) fn view<'a, B: Bands<f32, N>, const N: usize>(
        &'a self,
        point: &Point,
        channels: &'a Channels<B, N>,
        wo: [f32; 3],
        parts: Parts,
    ) -> View<'a, f32, B, N> {
        let layers = &self.layers[point.material];
        let local = layered::Point {
            thickness_nm: point.texel.thickness_nm,
            roughness: point.texel.roughness,
            albedo: channels.bands.upsample(point.texel.color),
            absorption: channels.bands.upsample(layers.constants().absorption),
        };
        layers.view(&channels.bands, &local, wo, parts)
    }
}
