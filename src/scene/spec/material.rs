//! `[material]`: the optics of the skin, in a scene's words.

use serde::{Deserialize, Serialize};

use crate::base::{LinearRgb, Srgb8};
use crate::optics::base_layer::{Base, Tint};
use crate::optics::layered::{Albedo, Constants, Energy};
use crate::optics::{Grating, SkinOptics};
use crate::scene::material::Texel;

/// What the base below the layers is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BaseSpec {
    /// Matt.
    #[default]
    Lambert,
    /// Squared half-Lambert, of the same energy, tinted by `blood`.
    HalfLambert,
    /// Light that spreads in the flesh below a surface of `curvature_per_mm`, and comes through where it is thin.
    Curved,
}

/// Where the tint of a half-Lambert base begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TintSpec {
    /// Where light comes along the normal.
    #[default]
    FromNormal,
    /// Where light grazes.
    FromHorizon,
}

/// `[material]`: the optics of the skin, and what stands in for maps that are not there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialSpec {
    /// Refractive index outside: air has 1, water 1.33.
    #[schemars(range(min = 1.0, max = 4.0))]
    pub n_outside: f32,
    /// Refractive index of the film, keratin's 1.55 unless set; the preset's own unless set here.
    #[schemars(range(min = 1.0, max = 4.0))]
    pub n_film: Option<f32>,
    /// Refractive index of the layer below the film, or of the surface where there is no film; the preset's own unless
    /// set here, and 2 where neither sets it.
    #[schemars(range(min = 1.0, max = 4.0))]
    pub n_layer: Option<f32>,
    /// Absorption coefficient times thickness of that layer, for red, green and blue; the preset's own unless set here,
    /// and 0, clear, where neither sets it.
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    pub absorption: Option<[f32; 3]>,
    /// What the colour map holds; the preset's own unless set here, and `apparent` where neither sets it.
    pub albedo: Option<Albedo>,
    /// How the light that is not reflected is shared out.
    pub energy: Energy,
    /// What the base is. Path tracing of all light takes lambert.
    pub base: BaseSpec,
    /// Tint of a half_lambert base for red, green and blue; 1 is none.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub blood: [f32; 3],
    /// Where the tint begins.
    pub tint: TintSpec,
    /// Curvature of a curved base, 1 over the radius; 0 is flat.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "1/mm"))]
    pub curvature_per_mm: f32,
    /// Thickness of the flesh below a curved base, as measured: light from behind comes through, a tenth of the red at 4 mm.
    /// Unless set, none does.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "mm"))]
    pub thickness_mm: Option<f32>,
    /// Cauchy coefficients of film and layer, whose indices are those at 589.3 nm; keratin of feathers has 5890.
    #[schemars(inner(range(min = -100_000.0, max = 100_000.0)), extend("x-unit" = "nm^2"))]
    pub dispersion_nm2: [f32; 2],
    /// Distance of the ridges of a diffraction grating.
    #[schemars(range(min = 100.0, max = 2400.0), extend("x-unit" = "nm"))]
    pub grating_period_nm: f32,
    /// Amplitude of those ridges, half of peak to valley; 0 is no grating.
    #[schemars(range(min = 0.0, max = 500.0), extend("x-unit" = "nm"))]
    pub grating_height_nm: f32,
    /// Direction across the ridges, from the tangent u towards v.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub grating_deg: f32,
    /// Colour where there is no map, sRGB.
    pub color: Srgb8,
    /// Roughness where there is no map; alpha is its square.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Film thickness where there is no map; 0 is no film.
    #[schemars(range(min = 0.0, max = 3_000_000.0), extend("x-unit" = "nm"))]
    pub film_nm: f32,
}

impl Default for MaterialSpec {
    fn default() -> Self {
        Self {
            n_outside: 1.0,
            n_film: None,
            n_layer: None,
            absorption: None,
            albedo: None,
            energy: Energy::Flat,
            base: BaseSpec::Lambert,
            blood: [1.0; 3],
            tint: TintSpec::FromNormal,
            curvature_per_mm: 0.0,
            thickness_mm: None,
            dispersion_nm2: [0.0; 2],
            grating_period_nm: 1000.0,
            grating_height_nm: 0.0,
            grating_deg: 0.0,
            color: Srgb8([0x6e, 0x4a, 0x2c]),
            roughness: 0.25,
            film_nm: 0.0,
        }
    }
}

impl MaterialSpec {
    /// What stands in for maps that are not there.
    pub fn texel(&self) -> Texel {
        Texel {
            color: LinearRgb::from(self.color).0,
            roughness: self.roughness,
            normal: [0.0, 0.0, 1.0],
            thickness_nm: self.film_nm,
        }
    }

    /// The constants of the BRDF on a skin of these optics: what the scene sets wins.
    pub fn constants(&self, skin: SkinOptics) -> Constants {
        let Self { n_film, n_layer, absorption, albedo, energy, .. } = *self;
        let own = SkinOptics { n_film, n_layer, absorption, albedo };
        Constants {
            energy,
            base: match self.base {
                BaseSpec::Lambert => Base::Lambert,
                BaseSpec::HalfLambert => Base::HalfLambert {
                    blood: self.blood,
                    tint: match self.tint {
                        TintSpec::FromNormal => Tint::FromNormal,
                        TintSpec::FromHorizon => Tint::FromHorizon,
                    },
                },
                BaseSpec::Curved => Base::Curved {
                    curvature_per_mm: self.curvature_per_mm,
                    thickness_mm: self.thickness_mm.unwrap_or(f32::INFINITY),
                },
            },
            dispersion_nm2: self.dispersion_nm2,
            grating: (self.grating_height_nm > 0.0).then_some(Grating {
                period_nm: self.grating_period_nm,
                height_nm: self.grating_height_nm,
                direction_rad: self.grating_deg.to_radians(),
            }),
            ..own.or(skin).constants(self.n_outside)
        }
    }
}
