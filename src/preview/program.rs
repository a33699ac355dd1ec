//! Which files make the shader of one material.
//!
//! A slot is a place that one of several files fills; siblings define the same functions. What a material lacks is not in
//! the module at all, and so costs neither instructions nor a texture. The parts, and what they may be:
//!
//! | Part | Files |
//! | --- | --- |
//! | gloss | `gloss_none`, or `microfacets` with `lobe` and the next |
//! | its ridges | `gloss_ggx` (none), or `gloss_grating` with `airy` |
//! | film | `film_none` (a plain interface), `film_dispersed` with `airy`, or `film_series` with the next two |
//! | its fringes | `fringes`, `fringes_filtered` |
//! | beyond its critical angle | `beyond_none`, `beyond_frustrated` |
//! | base | `base_none`, `base_matt` (no layers) with `cosine`, or `base_layers` with the next four |
//! | light from around | `base_lambert` with `cosine`, or `curve` with `base_wrapped` or `base_translucent` |
//! | layer | `layer_clear`, `layer_absorbing`, `layer_dispersed` |
//! | what enters | `pass_flat`, or `pass_coupled` with `lobe` |
//! | light below the film | `below_constant`, `below_table`, `below_rough` |
//!
//! They use bind group 1, and define what the frame calls: `SurfacePoint`, `Skin`, `skin_view`, `skin_eval`, `skin_shine`,
//! `skin_tints`, `skin_lobes`, `skin_ambient` and `skin_alpha`; see `skin.wgsl`.

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
    /// Terms of the series of film colours, at least 1. 3 are what the reference takes in red, green and blue; each costs a
    /// third of the film's time. 2 are off by 2e-4 (RMS) for the default film, by far more where n2 is n0.
    pub film_order: u32,
    /// Whether film thickness that varies within a pixel is averaged, where a map holds it.
    pub footprint: bool,
    /// Wavelengths by which the orders of a grating are drawn, 2 to 32; see [`super::orders`] for what fewer cost.
    pub grating_wavelengths: u32,
    /// Layers that there are.
    pub parts: Parts,
}

impl Default for SkinOptions {
    fn default() -> Self {
        Self { film_order: 3, footprint: true, grating_wavelengths: 16, parts: Parts::All }
    }
}

/// The shader of one material, to be joined to that of the frame. Equal programs may share a pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinProgram {
    slots: Vec<Slot>,
    film_order: Option<u32>,
    grating_wavelengths: Option<u32>,
}

impl SkinProgram {
    /// For a material with these features; see [`SceneFeatures::of_material`].
    pub fn new(features: &SceneFeatures, options: &SkinOptions) -> Self {
        // What is below a surface that does nothing to light is as if bare.
        let bare = !(features.interface || features.absorber || features.wrapped_base);
        let matt = bare || options.parts == Parts::Lambert;
        let gloss = features.interface && matches!(options.parts, Parts::All | Parts::Specular);
        let base = features.base && options.parts != Parts::Specular;
        // Something that light goes through, or is reflected by.
        let layers = gloss || (base && !matt);
        let grating = features.grating && gloss;
        // A grating without a film is shaded as one of thickness 0: Mesa 22.3 crashes over `film_none` with ridges.
        let film = (features.film || grating) && layers;
        let coupled = features.coupled_energy && features.interface && base && !matt;
        let one = |yes: bool, [if_yes, if_no]: [Slot; 2]| if yes { if_yes } else { if_no };

        let mut slots = slots!["material", "skin"].to_vec();
        if layers {
            slots.extend(slots!["fresnel"]);
        }
        let dispersed = features.dispersion && layers;
        if dispersed || grating {
            slots.extend(slots!["airy"]);
        }
        if dispersed {
            slots.extend(slots!["film_dispersed"]);
        } else if film {
            slots.extend(slots!["film_series"]);
            slots.push(one(features.total_reflection, slots!["beyond_frustrated", "beyond_none"]));
            let filtered = features.thickness_map && options.footprint;
            slots.push(one(filtered, slots!["fringes_filtered", "fringes"]));
        } else if layers {
            slots.extend(slots!["film_none"]);
        }
        if gloss {
            slots.extend(slots!["microfacets"]);
            slots.push(one(grating, slots!["gloss_grating", "gloss_ggx"]));
        } else {
            slots.extend(slots!["gloss_none"]);
        }
        if gloss || coupled {
            slots.extend(slots!["lobe"]);
        }
        if base && !matt {
            slots.extend(slots!["base_layers", "below"]);
            if features.wrapped_base {
                slots.extend(slots!["curve"]);
                slots.push(one(features.translucent_base, slots!["base_translucent", "base_wrapped"]));
            } else {
                slots.extend(slots!["cosine", "base_lambert"]);
            }
            let absorbing = one(dispersed, slots!["layer_dispersed", "layer_absorbing"]);
            slots.push(one(features.absorber, [absorbing, slots!["layer_clear"][0]]));
            slots.push(one(coupled, slots!["pass_coupled", "pass_flat"]));
            let flat = one(features.thickness_map, slots!["below_table", "below_constant"]);
            slots.push(if coupled { slots!["below_rough"][0] } else { flat });
        } else {
            if base {
                slots.extend(slots!["cosine"]);
            }
            slots.push(one(base, slots!["base_matt", "base_none"]));
        }
        let film_order = (film && !dispersed).then_some(options.film_order.max(1));
        let grating_wavelengths = grating.then_some(options.grating_wavelengths.clamp(2, 32));
        Self { slots, film_order, grating_wavelengths }
    }

    /// Wavelengths by which the orders of a grating are drawn, if there is one.
    pub fn grating_wavelengths(&self) -> Option<u32> {
        self.grating_wavelengths
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
