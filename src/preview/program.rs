//! Which files make the shader of one material.
//!
//! A slot is a place that one of several files fills; siblings define the same functions. What a material lacks is not in
//! the module at all, and so costs neither instructions nor a texture. The parts, and what they may be:
//!
//! | Part | Files |
//! | --- | --- |
//! | gloss | `gloss_none`, or `gloss_ggx` and `lobe` |
//! | film | `film_none` (a plain interface), or `film_series` with `fringes` or `fringes_filtered` |
//! | base | `base_none`, `base_matt` (no layers), or `base_layers` and `base_lambert` with the next two |
//! | layer | `layer_clear`, `layer_absorbing` |
//! | light below the film | `below_constant`, `below_table` |
//!
//! They use bind group 1, and define what the frame calls: `SurfacePoint`, `Skin`, `skin_view`, `skin_eval`, `skin_shine`,
//! `skin_ambient` and `skin_alpha`; see `skin.wgsl`.

use crate::optics::layered::Parts;
use crate::scene::SceneFeatures;

/// A file of WGSL.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Slot {
    /// Its name without the ending.
    pub name: &'static str,
    /// Its text.
    pub source: &'static str,
}

impl std::fmt::Debug for Slot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

macro_rules! slots {
    ($($name:literal),* $(,)?) => {
        [$(Slot { name: $name, source: include_str!(concat!("shaders/", $name, ".wgsl")) }),*]
    };
}

/// What is chosen rather than found in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinOptions {
    /// Terms of the series of film colours, at least 1: 3 is that of [`crate::optics::FilmColor`] where shading is concerned.
    pub film_order: u32,
    /// Whether film thickness that varies within a pixel is averaged, where a map holds it.
    pub footprint: bool,
    /// Layers that there are.
    pub parts: Parts,
}

impl Default for SkinOptions {
    fn default() -> Self {
        Self { film_order: 3, footprint: true, parts: Parts::All }
    }
}

/// The shader of one material, to be joined to that of the frame. Equal programs may share a pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinProgram {
    slots: Vec<Slot>,
    film_order: Option<u32>,
}

impl SkinProgram {
    /// For a material with these features; see [`SceneFeatures::of_material`].
    pub fn new(features: &SceneFeatures, options: &SkinOptions) -> Self {
        let mut slots = slots!["material", "skin"].to_vec();
        let matt = options.parts == Parts::Lambert;
        let gloss = features.interface && matches!(options.parts, Parts::All | Parts::Specular);
        let base = features.base && options.parts != Parts::Specular;
        let film = features.film && (gloss || (base && !matt));
        if gloss || (base && !matt) {
            slots.extend(slots!["fresnel"]);
            slots.extend(match (film, features.thickness_map && options.footprint) {
                (false, _) => slots!["film_none"].to_vec(),
                (true, false) => slots!["film_series", "beyond_none", "fringes"].to_vec(),
                (true, true) => slots!["film_series", "beyond_none", "fringes_filtered"].to_vec(),
            });
        }
        slots.extend(if gloss {
            slots!["gloss_ggx", "lobe"].to_vec()
        } else {
            slots!["gloss_none"].to_vec()
        });
        match (base, matt) {
            (false, _) => slots.extend(slots!["base_none"]),
            (true, true) => slots.extend(slots!["base_matt"]),
            (true, false) => {
                slots.extend(slots!["base_layers", "base_lambert", "below"]);
                let [clear, absorbing, constant, table] =
                    slots!["layer_clear", "layer_absorbing", "below_constant", "below_table"];
                slots.push(if features.absorber { absorbing } else { clear });
                slots.push(if features.thickness_map { table } else { constant });
            }
        }
        Self { slots, film_order: film.then_some(options.film_order.max(1)) }
    }

    /// The files, in the order in which they are joined.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Whether a file is in it.
    pub fn has(&self, name: &str) -> bool {
        self.slots.iter().any(|slot| slot.name == name)
    }

    /// The text.
    pub fn source(&self) -> String {
        self.slots.iter().map(|slot| slot.source).collect::<Vec<_>>().join("\n")
    }

    /// Values of the module's `override` constants, for the pipeline.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        self.film_order.iter().map(|order| ("FILM_ORDER", f64::from(*order))).collect()
    }
}
