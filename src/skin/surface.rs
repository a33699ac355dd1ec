//! `[surface]`: gloss and micro-relief.

use serde::{Deserialize, Serialize};

use super::lowering::Lowering;
use crate::node::combine::Add;
use crate::node::draft::Wire;
use crate::node::filter::{Clamp, Levels};

/// `[surface]`: how glossy the scales are and what is finer than a scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Surface {
    /// Roughness of dorsal scales: 0.1 a sunbeam snake's polish, 0.7 a viper's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Roughness of belly scutes.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ventral_roughness: f32,
    /// Roughness of the skin between scales.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub skin_roughness: f32,
    /// Variation of roughness by fine noise, plus or minus.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub roughness_noise: f32,
    /// Variation of roughness from scale to scale, plus or minus.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub roughness_vary: f32,
    /// Shed state: 0 freshly shed (roughness times 0.7), 0.5 usual, 1 about to shed (milky, times 1.8).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub shed: f32,
    /// Height of the micro-relief on scales, as a share of their relief.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub micro_relief: f32,
    /// Height of the wrinkles of the skin between scales, as a share of the scales' relief.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub skin_wrinkles: f32,
    /// Strength of the ambient occlusion map: 1 is physical and faint, as scales are low; 2 to 3 reads.
    #[schemars(range(min = 0.0, max = 4.0))]
    pub occlusion: f32,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            roughness: 0.35,
            ventral_roughness: 0.25,
            skin_roughness: 0.7,
            roughness_noise: 0.04,
            roughness_vary: 0.02,
            shed: 0.5,
            micro_relief: 0.03,
            skin_wrinkles: 0.15,
            occlusion: 2.5,
        }
    }
}

impl Surface {
    /// Height, mm: the lattice's, with micro-relief and wrinkles.
    pub(super) fn height(&self, l: &mut Lowering<'_>) -> Wire {
        let mut height = l.scales.port("height");
        let relief_mm = l.lattice.relief * l.pitch_mm;
        if self.micro_relief > 0.0 {
            let noise = l.grain("micro_relief", 5.0, 3);
            let micro = l.add(
                "micro_height",
                Levels::default(),
                &[("image", noise), ("out_high", (self.micro_relief * relief_mm).into())],
            );
            height = l.add("height_micro", Add::default(), &[("a", height), ("b", micro)]);
        }
        if self.skin_wrinkles > 0.0 {
            let noise = l.grain("skin_noise", 8.0, 3);
            let wrinkle = l.add(
                "skin_wrinkle",
                Levels::default(),
                &[("image", noise), ("out_high", (self.skin_wrinkles * relief_mm).into())],
            );
            let cover = l.scales.port("cover");
            let only_skin = l.mix("skin_height", wrinkle, 0.0.into(), cover);
            height = l.add("surface_height", Add::default(), &[("a", height), ("b", only_skin)]);
        }
        height
    }

    /// Roughness, [0.02, 1]; `rough` are masks with a roughness of their own.
    pub(super) fn roughness(&self, l: &mut Lowering<'_>, rough: &[(Wire, f32)]) -> Wire {
        // 0.7 at 0, 1 at 0.5, 1.8 at 1 (SPECIES.md 2.9).
        let shed = if self.shed <= 0.5 { 0.7 + 0.6 * self.shed } else { 1.0 + 1.6 * (self.shed - 0.5) };
        let mut roughness = Wire::Scalar((self.roughness * shed).min(1.0));
        if l.lattice.ventrals > 0 {
            let scutes = l.scute_mask();
            roughness =
                l.mix("roughness_belly", roughness, (self.ventral_roughness * shed).min(1.0).into(), scutes);
        }
        for (i, (mask, value)) in rough.iter().enumerate() {
            roughness = l.mix(format!("roughness_layer{}", i + 1), roughness, (*value).into(), mask.clone());
        }
        let cover = l.scales.port("cover");
        roughness = l.mix("roughness_skin", self.skin_roughness.into(), roughness, cover);
        if self.roughness_noise > 0.0 {
            let noise = l.grain("roughness_grain", 4.0, 5);
            let amount = 2.0 * self.roughness_noise;
            let noise = l.add(
                "roughness_fine",
                Levels::default(),
                &[("image", noise), ("out_low", (-amount).into()), ("out_high", amount.into())],
            );
            roughness = l.add("roughness_noisy", Add::default(), &[("a", roughness), ("b", noise)]);
        }
        if self.roughness_vary > 0.0 {
            let vary = l.add(
                "roughness_each",
                Levels::default(),
                &[
                    ("image", l.scales.port("random")),
                    ("out_low", (-self.roughness_vary).into()),
                    ("out_high", self.roughness_vary.into()),
                ],
            );
            roughness = l.add("roughness_varied", Add::default(), &[("a", roughness), ("b", vary)]);
        }
        // A roughness of 0 is a mirror, which no skin is.
        l.add(
            "roughness",
            Clamp::default(),
            &[("image", roughness), ("low", 0.02.into()), ("high", 1.0.into())],
        )
    }
}
