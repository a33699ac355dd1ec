//! The whole BRDF of the skin: a film over an absorbing layer over a diffuse base.

/// What is the same over a whole surface. Every index is that of a clear medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Refractive indices: outside, film, layer below the film.
    pub indices: [f32; 3],
    /// Absorption coefficient times thickness of the layer, along the normal, for red, green, blue.
    pub absorption: [f32; 3],
    /// What the albedo of the base is.
    pub albedo: Albedo,
    /// How the light that is not reflected is shared out.
    pub energy: Energy,
}

impl Default for Constants {
    /// The thesis's: keratin of 1.55 on 2.0 in air, nothing absorbed.
    fn default() -> Self {
        Self {
            indices: [1.0, 1.55, 2.0],
            absorption: [0.0; 3],
            albedo: Albedo::Apparent,
            energy: Energy::Flat,
        }
    }
}

/// What the albedo of the base means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Albedo {
    /// What is seen from outside without absorption: what textures hold.
    #[default]
    Apparent,
    /// Of the base itself, below the interface.
    Intrinsic,
}

/// How the light that is not reflected is shared out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Energy {
    /// Transmittance at the angles to the normal: fast, right for smooth surfaces.
    #[default]
    Flat,
    /// What the rough surface does not reflect, by a table: conserves energy at any roughness.
    Coupled,
}
