//! `[belly]`: the scutes' share of the girth, and their colours.

use serde::{Deserialize, Serialize};

use super::lowering::Lowering;
use crate::base::Srgb8;
use crate::node::combine::{Max, Multiply};
use crate::node::draft::Wire;
use crate::node::filter::Levels;
use crate::node::generate::{Fractal, WhiteNoise};

/// How the belly's second colour lies on the scutes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BellyPattern {
    /// It is not used.
    #[default]
    None,
    /// Squares, scute by scute: corn and milk snakes.
    Checks,
    /// Dots at the scutes' ends: garter snakes.
    Ends,
    /// Irregular patches.
    Patches,
    /// Fine dots.
    Speckle,
}

/// `[belly]`: width and colours of the belly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Belly {
    /// Share of the girth that the belly scutes span; 0 for none.
    #[schemars(range(min = 0.0, max = 0.8), extend("x-unit" = "girth"))]
    pub width: f32,
    /// Colour of the scutes.
    pub color: Srgb8,
    /// Second colour.
    pub color2: Option<Srgb8>,
    /// How the second colour lies.
    pub pattern: BellyPattern,
    /// Share of the belly that it takes.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub amount: f32,
    /// Lowest dorsal rows that wear the belly's colour.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "rows"))]
    pub rows: f32,
    /// Rows over which the back's colour passes into the belly's.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "rows"))]
    pub blend_rows: f32,
}

impl Default for Belly {
    fn default() -> Self {
        Self {
            width: 0.3,
            color: Srgb8([0xe4, 0xdc, 0xc6]),
            color2: None,
            pattern: BellyPattern::None,
            amount: 0.35,
            rows: 0.0,
            blend_rows: 1.0,
        }
    }
}

impl Belly {
    /// The belly laid over the back's colour.
    pub(super) fn paint(&self, l: &mut Lowering<'_>, back: Wire) -> Wire {
        // Rows of the flank, as a share of the half girth that the back takes.
        let row = (1.0 - l.belly) / (0.5 * l.lattice.rows as f32) / (1.0 - l.belly);
        let edge = 1.0 - self.rows * row;
        let blend = (self.blend_rows * row).max(1e-3);
        let mut mask = l.lateral_ramp("belly_ramp", edge - blend, edge + 0.02);
        if self.rows <= 0.0 && self.blend_rows <= 0.0 {
            mask = 0.0.into();
        }
        if l.lattice.ventrals > 0 {
            let scutes = l.scute_mask();
            mask = l.add("belly_mask", Max::default(), &[("a", mask), ("b", scutes)]);
        }
        let mut color = Wire::from(self.color);
        if let (Some(color2), Some(mask2)) = (self.color2, self.mask2(l, mask.clone())) {
            color = l.mix("belly_colors", color, color2.into(), mask2);
        }
        l.mix("belly_over_back", back, color, mask)
    }

    /// Where the second colour is; it need not hold where `belly` is 0.
    fn mask2(&self, l: &mut Lowering<'_>, belly: Wire) -> Option<Wire> {
        let threshold = |l: &mut Lowering<'_>, field: Wire, at: f32, soft: f32| {
            l.add(
                "belly_pattern",
                Levels::default(),
                &[("image", field), ("in_low", (at - soft).into()), ("in_high", (at + soft).into())],
            )
        };
        let scutes = l.lattice.ventrals.max(1);
        match self.pattern {
            BellyPattern::None => None,
            BellyPattern::Checks => {
                // Cells one scute long and a third of the belly wide, black or white by chance.
                let cells_u = ((3.0 / l.belly.max(0.05)).round() as u32).max(1);
                let (_, dv) = l.offsets(1.0);
                // Half a cell aside, so that no border runs along the belly's middle, where the tile ends.
                let du = 0.5 / cells_u as f32;
                let inputs = [("du", du.into()), ("dv", dv)];
                let chance = l.add("belly_checks", WhiteNoise { cells_u, cells_v: scutes }, &inputs);
                Some(threshold(l, chance, 1.0 - self.amount, 0.01))
            }
            BellyPattern::Ends => {
                let s = l.scales.port("s");
                let ends = l.add("belly_ends", Multiply::default(), &[("a", s.clone()), ("b", s)]);
                let at = (1.0 - self.amount) * (1.0 - self.amount);
                Some(threshold(l, ends, at, 0.08))
            }
            BellyPattern::Patches | BellyPattern::Speckle => {
                let scute_mm = l.length_mm / scutes as f32;
                let size =
                    if self.pattern == BellyPattern::Patches { 2.5 * scute_mm } else { 0.35 * scute_mm };
                let (cells_u, cells_v) = l.cells(size);
                let noise = Fractal { cells_u, cells_v, octaves: 4, ..Fractal::default() };
                let noise = l.add("belly_noise", noise, &[("where", belly)]);
                Some(threshold(l, noise, 0.5 + 0.25 * (0.5 - self.amount), 0.03))
            }
        }
    }
}
