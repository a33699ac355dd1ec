//! The optics of a skin as a text gives them: what is not set is left to someone else.

use serde::{Deserialize, Serialize};

use super::layered::{Albedo, Constants};

/// What a skin is made of optically, besides its maps. Every key may be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SkinOptics {
    /// Refractive index of the film: keratin has 1.55.
    #[schemars(range(min = 1.0, max = 4.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n_film: Option<f32>,
    /// Refractive index of the layer below the film; where there is no film, of the surface. Unlike the film's it is what
    /// makes interference strong.
    #[schemars(range(min = 1.0, max = 4.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n_layer: Option<f32>,
    /// Absorption coefficient times thickness of that layer, for red, green and blue; 0 is clear.
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption: Option<[f32; 3]>,
    /// What the colour map holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo: Option<Albedo>,
}

impl SkinOptics {
    /// Whether nothing is set.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// These where they are set, else `other`.
    pub fn or(self, other: Self) -> Self {
        Self {
            n_film: self.n_film.or(other.n_film),
            n_layer: self.n_layer.or(other.n_layer),
            absorption: self.absorption.or(other.absorption),
            albedo: self.albedo.or(other.albedo),
        }
    }

    /// The constants of the BRDF, in air unless `n_outside` says otherwise; what is not set is [`Constants::default`]'s.
    pub fn constants(&self, n_outside: f32) -> Constants {
        let Constants { indices: [_, n_film, n_layer], absorption, albedo, .. } = Constants::default();
        Constants {
            indices: [n_outside, self.n_film.unwrap_or(n_film), self.n_layer.unwrap_or(n_layer)],
            absorption: self.absorption.unwrap_or(absorption),
            albedo: self.albedo.unwrap_or(albedo),
            ..Constants::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_wins_and_what_nobody_sets_is_the_default() {
        let own = SkinOptics { n_layer: Some(1.6), ..SkinOptics::default() };
        let other = SkinOptics {
            n_layer: Some(1.7),
            absorption: Some([1.0, 2.0, 3.0]),
            albedo: Some(Albedo::Intrinsic),
            ..SkinOptics::default()
        };
        let both = own.or(other);
        assert_eq!(both, SkinOptics { n_layer: Some(1.6), ..other });
        let made = both.constants(1.33);
        assert_eq!((made.indices, made.absorption), ([1.33, 1.55, 1.6], [1.0, 2.0, 3.0]));
        assert_eq!(made.albedo, Albedo::Intrinsic);
        assert_eq!(SkinOptics::default().constants(1.0), Constants::default());
        assert!(SkinOptics::default().is_empty() && !own.is_empty());
    }
}
