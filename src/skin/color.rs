//! `[color]`: the ground, what varies it, and what each scale wears: rim, tip and root.

use serde::{Deserialize, Serialize};

use super::lowering::Lowering;
use crate::base::Srgb8;
use crate::node::color::OklabJitter;
use crate::node::combine::Multiply;
use crate::node::draft::Wire;
use crate::node::filter::Levels;

/// `[color]`: apparent colours, sRGB, of the ground and of each scale's parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Color {
    /// Ground colour of the back.
    pub base: Srgb8,
    /// Second ground colour, mixed in patches; the same as `base` if not set.
    pub base2: Option<Srgb8>,
    /// How much of `base2` shows where its patches are strongest.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub base2_amount: f32,
    /// Size of the patches.
    #[schemars(range(min = 0.2, max = 100.0), extend("x-unit" = "scales"))]
    pub patch_scales: f32,
    /// Colour toward the belly; the same as `base` if not set.
    pub flank: Option<Srgb8>,
    /// Where the flank's colour begins: 0 mid-back, 1 the belly's edge.
    #[schemars(range(min = 0.0, max = 1.5), extend("x-unit" = "flank"))]
    pub flank_from: f32,
    /// Where it is complete.
    #[schemars(range(min = 0.0, max = 1.5), extend("x-unit" = "flank"))]
    pub flank_to: f32,
    /// How much whole scales differ in hue.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "turn"))]
    pub vary_hue: f32,
    /// How much whole scales differ in chroma, as a share.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub vary_chroma: f32,
    /// How much whole scales differ in lightness.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub vary_lightness: f32,
    /// Fine fractal grain within the scales (thesis 4.2.1.1).
    #[schemars(range(min = 0.0, max = 0.5))]
    pub grain: f32,
    /// Colour of each dorsal scale's rim; no rim if not set.
    pub rim: Option<Srgb8>,
    /// Width of the rim, in row widths.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "pitch"))]
    pub rim_width: f32,
    /// Strength of the rim.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub rim_amount: f32,
    /// Rims begin here: 0 mid-back, 1 the belly's edge.
    #[schemars(range(min = 0.0, max = 1.5), extend("x-unit" = "flank"))]
    pub rim_from: f32,
    /// Rims end here.
    #[schemars(range(min = 0.0, max = 3.0), extend("x-unit" = "flank"))]
    pub rim_to: f32,
    /// Colour of each dorsal scale's tip; none if not set.
    pub tip: Option<Srgb8>,
    /// Length of the tip, as a share of the scale's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tip_length: f32,
    /// Strength of the tip.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tip_amount: f32,
    /// Tips begin here: 0 mid-back, 1 the belly's edge.
    #[schemars(range(min = 0.0, max = 1.5), extend("x-unit" = "flank"))]
    pub tip_from: f32,
    /// Share of the scales that have a tip, chosen by chance.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tip_share: f32,
    /// Darkening of each scale toward its root.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub root_shade: f32,
    /// Darkening of each scale toward its border, within the rim's width.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub edge_shade: f32,
    /// Skin between the scales.
    pub skin: Srgb8,
}

impl Default for Color {
    fn default() -> Self {
        Self {
            base: Srgb8([0x9a, 0x84, 0x68]),
            base2: None,
            base2_amount: 0.7,
            patch_scales: 4.0,
            flank: None,
            flank_from: 0.4,
            flank_to: 1.0,
            vary_hue: 0.006,
            vary_chroma: 0.08,
            vary_lightness: 0.02,
            grain: 0.04,
            rim: None,
            rim_width: 0.2,
            rim_amount: 1.0,
            rim_from: 0.0,
            rim_to: 3.0,
            tip: None,
            tip_length: 0.15,
            tip_amount: 1.0,
            tip_from: 0.0,
            tip_share: 1.0,
            root_shade: 0.25,
            edge_shade: 0.35,
            skin: Srgb8([0x3a, 0x2e, 0x22]),
        }
    }
}

impl Color {
    /// The ground: base, patches of the second base, flank.
    pub(super) fn ground(&self, l: &mut Lowering<'_>) -> Wire {
        let mut color = Wire::from(self.base);
        if let Some(base2) = self.base2 {
            let noise = l.patches("ground_patches", self.patch_scales, 3, 0.7, None);
            let mask = l.add(
                "ground_mask",
                Levels::default(),
                &[
                    ("image", noise),
                    ("in_low", 0.35.into()),
                    ("in_high", 0.65.into()),
                    ("out_high", self.base2_amount.into()),
                ],
            );
            color = l.mix("ground_base", color, base2.into(), mask);
        }
        if let Some(flank) = self.flank {
            let mask = l.lateral_ramp("flank_mask", self.flank_from, self.flank_to);
            color = l.mix("ground_flank", color, flank.into(), mask);
        }
        color
    }

    /// What every scale wears over its colour: variation, grain, tip, rim, shading, and the skin between.
    pub(super) fn dress(&self, l: &mut Lowering<'_>, color: Wire) -> Wire {
        let mut color = color;
        if self.vary_hue > 0.0 || self.vary_chroma > 0.0 || self.vary_lightness > 0.0 {
            let random = l.scales.port("random");
            color = l.add(
                "scale_variation",
                OklabJitter::default(),
                &[
                    ("color", color),
                    ("random", random),
                    ("hue", self.vary_hue.into()),
                    ("chroma", self.vary_chroma.into()),
                    ("lightness", self.vary_lightness.into()),
                ],
            );
        }
        if self.grain > 0.0 {
            let grain = l.grain("color_grain", 3.0, 4);
            let gain = l.add(
                "grain_gain",
                Levels::default(),
                &[
                    ("image", grain),
                    ("in_low", 0.2.into()),
                    ("in_high", 0.8.into()),
                    ("out_low", (1.0 - 2.0 * self.grain).into()),
                    ("out_high", 1.0.into()),
                ],
            );
            color = l.add("grained", Multiply::default(), &[("a", color), ("b", gain)]);
        }
        color = self.tips(l, color);
        color = self.shades(l, color);
        color = self.rims(l, color);
        let cover = l.scales.port("cover");
        l.mix("skin_color", self.skin.into(), color, cover)
    }

    fn tips(&self, l: &mut Lowering<'_>, color: Wire) -> Wire {
        let Some(tip) = self.tip else { return color };
        let mut mask = l.add(
            "tip_ramp",
            Levels::default(),
            &[
                ("image", l.scales.port("t")),
                ("in_low", (1.0 - self.tip_length).into()),
                ("in_high", (1.0 - 0.4 * self.tip_length).into()),
                ("out_high", self.tip_amount.into()),
            ],
        );
        mask = l.dorsal_only("tip_dorsal", mask);
        if self.tip_share < 1.0 {
            let chosen = l.add(
                "tip_chosen",
                Levels::default(),
                &[
                    ("image", l.scales.port("random")),
                    ("in_low", (1.0 - self.tip_share).into()),
                    ("in_high", (1.0 - self.tip_share + 1e-3).into()),
                ],
            );
            mask = l.multiply("tip_share", mask, chosen);
        }
        if self.tip_from > 0.0 {
            let window = l.lateral_ramp("tip_from", self.tip_from, self.tip_from + 0.15);
            mask = l.multiply("tip_window", mask, window);
        }
        l.mix("tipped", color, tip.into(), mask)
    }

    fn shades(&self, l: &mut Lowering<'_>, color: Wire) -> Wire {
        let mut color = color;
        if self.root_shade > 0.0 {
            let gain = l.add(
                "root_gain",
                Levels::default(),
                &[
                    ("image", l.scales.port("t")),
                    ("in_low", 0.1.into()),
                    ("in_high", 0.6.into()),
                    ("out_low", (1.0 - self.root_shade).into()),
                ],
            );
            color = l.add("rooted", Multiply::default(), &[("a", color), ("b", gain)]);
        }
        if self.edge_shade > 0.0 {
            let width = 0.12 * l.row_mm;
            let gain = l.add(
                "edge_gain",
                Levels::default(),
                &[
                    ("image", l.scales.port("edge")),
                    ("in_low", 0.0.into()),
                    ("in_high", width.into()),
                    ("out_low", (1.0 - self.edge_shade).into()),
                ],
            );
            color = l.add("edged", Multiply::default(), &[("a", color), ("b", gain)]);
        }
        color
    }

    fn rims(&self, l: &mut Lowering<'_>, color: Wire) -> Wire {
        let Some(rim) = self.rim else { return color };
        let width = self.rim_width * l.row_mm;
        let mut mask = l.add(
            "rim_ramp",
            Levels::default(),
            &[
                ("image", l.scales.port("edge")),
                ("in_low", (0.6 * width).into()),
                ("in_high", (1.1 * width).into()),
                ("out_low", self.rim_amount.into()),
                ("out_high", 0.0.into()),
            ],
        );
        mask = l.dorsal_only("rim_dorsal", mask);
        if self.rim_from > 0.0 {
            let window = l.lateral_ramp("rim_from", self.rim_from, self.rim_from + 0.15);
            mask = l.multiply("rim_begin", mask, window);
        }
        if self.rim_to < 2.0 {
            let window = l.lateral_ramp("rim_to", self.rim_to, self.rim_to - 0.15);
            mask = l.multiply("rim_end", mask, window);
        }
        l.mix("rimmed", color, rim.into(), mask)
    }
}
