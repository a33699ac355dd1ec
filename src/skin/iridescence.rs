//! `[iridescence]`: thickness of the film on the scales, nm.

use serde::{Deserialize, Serialize};

use super::lowering::Lowering;
use crate::node::convert::FilmThickness;
use crate::node::draft::Wire;
use crate::node::filter::Levels;

/// `[iridescence]`: the equivalent thin film, per scale: a gradient along it, one from its middle, noise and chance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Iridescence {
    /// Mean thickness; 0 is no film. 260 to 400 in iridescent snakes (art values).
    #[schemars(range(min = 0.0, max = 3_000_000.0), extend("x-unit" = "nm"))]
    pub thickness_nm: f32,
    /// What the film gains from a scale's root to its tip, as a share of the mean.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub vertical: f32,
    /// What it gains from a scale's middle line to its sides, as a share of the mean.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub radial: f32,
    /// Fractal noise, plus or minus, as a share of the mean.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub noise: f32,
    /// Difference from scale to scale, plus or minus, as a share of the mean.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub vary: f32,
    /// Thickness on the skin between scales.
    #[schemars(range(min = 0.0, max = 3_000_000.0), extend("x-unit" = "nm"))]
    pub skin_nm: f32,
}

impl Default for Iridescence {
    fn default() -> Self {
        Self { thickness_nm: 0.0, vertical: 0.15, radial: 0.05, noise: 0.04, vary: 0.03, skin_nm: 0.0 }
    }
}

impl Iridescence {
    /// Greatest thickness that the parts can add up to, nm; at least 1, so that files have a range.
    pub(super) fn max_nm(&self) -> f32 {
        let spread = 0.5 * self.vertical.abs() + 0.5 * self.radial.abs() + self.noise + self.vary;
        (self.thickness_nm * (1.0 + spread)).max(self.skin_nm).max(1.0)
    }

    /// Film thickness, nm.
    pub(super) fn film(&self, l: &mut Lowering<'_>) -> Wire {
        if self.thickness_nm <= 0.0 {
            if self.skin_nm <= 0.0 {
                return 0.0.into();
            }
            let cover = l.scales.port("cover");
            return l.mix("film", self.skin_nm.into(), 0.0.into(), cover);
        }
        let nm = self.thickness_nm;
        let centred = |l: &mut Lowering<'_>, name: &str, image: Wire, low: f32, high: f32| {
            l.add(
                name,
                Levels::default(),
                &[
                    ("image", image),
                    ("in_low", low.into()),
                    ("in_high", high.into()),
                    ("out_low", (-0.5).into()),
                    ("out_high", 0.5.into()),
                ],
            )
        };
        let t = l.scales.port("t");
        let t = centred(l, "film_t", t, 0.2, 1.0);
        let s = l.scales.port("s");
        let s2 = l.multiply("film_s2", s.clone(), s);
        let radius = centred(l, "film_radius", s2, 0.0, 1.0);
        let noise = l.grain("film_noise", 2.0, 5);
        let noise = centred(l, "film_noise_signed", noise, 0.2, 0.8);
        let (random, mask) = (l.scales.port("random"), l.scales.port("cover"));
        l.add(
            "film",
            FilmThickness { min: 0.0, max: self.max_nm() },
            &[
                ("base", nm.into()),
                ("vertical", (self.vertical * nm).into()),
                ("t", t),
                ("radial", (self.radial * nm).into()),
                ("radius", radius),
                ("noise_amount", (2.0 * self.noise * nm).into()),
                ("noise", noise),
                ("random_amount", (self.vary * nm).into()),
                ("random", random),
                ("mask", mask),
                ("skin", self.skin_nm.into()),
            ],
        )
    }
}
