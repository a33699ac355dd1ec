//! `[body]`: the tile's physical size, from the animal's measures.

use serde::{Deserialize, Serialize};

/// `[body]`: how thick the snake is, how long its scales, and how much of it the tile holds.
///
/// The tile is the whole girth by a whole number of scales and of pattern repeats, so its ends meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// Diameter at midbody; the tile is as wide as the girth, pi times that.
    #[schemars(range(min = 0.5, max = 1000.0), extend("x-unit" = "mm"))]
    pub diameter_mm: f32,
    /// Length of a dorsal scale along the body, from one to the next of its row. Snout-vent length over the ventrals,
    /// divided by `dorsals_per_ventral`.
    #[schemars(range(min = 0.01, max = 500.0), extend("x-unit" = "mm"))]
    pub scale_pitch_mm: f32,
    /// Dorsal scales of a row per belly scute: 1 in colubrids, elapids and vipers, about 1.5 in boas and pythons, 0
    /// where there are no scutes.
    #[schemars(range(min = 0.0, max = 4.0))]
    pub dorsals_per_ventral: f32,
    /// Pattern repeats in the tile; each varies like an individual's do. 3 to 5.
    #[schemars(range(min = 1, max = 1000))]
    pub repeats: u32,
    /// Scales of a row per pattern repeat. Most blotched snakes have 5 to 13.
    #[schemars(range(min = 0.5, max = 1000.0), extend("x-unit" = "scales"))]
    pub period_scales: f32,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            diameter_mm: 20.0,
            scale_pitch_mm: 3.3,
            dorsals_per_ventral: 1.0,
            repeats: 4,
            period_scales: 7.0,
        }
    }
}

impl Body {
    /// Girth, mm.
    pub fn girth_mm(&self) -> f32 {
        std::f32::consts::PI * self.diameter_mm
    }

    /// Scales of a row along the tile: the whole number nearest to the repeats' scales.
    pub fn count(&self) -> u32 {
        ((self.repeats as f32 * self.period_scales).round() as u32).max(1)
    }

    /// Scutes along the tile: a whole number.
    pub fn ventrals(&self) -> u32 {
        if self.dorsals_per_ventral <= 0.0 {
            return 0;
        }
        ((self.count() as f32 / self.dorsals_per_ventral).round() as u32).max(1)
    }

    /// Length of the tile, mm.
    pub fn length_mm(&self) -> f32 {
        self.count() as f32 * self.scale_pitch_mm
    }
}
