//! `[scales]`: form and lattice of the scales.

use serde::{Deserialize, Serialize};

use super::{Belly, Body};
use crate::node::place::{ScaleLattice, ScaleShape};

/// `[scales]`: how many rows, what shape, how they overlap and rise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scales {
    /// Dorsal rows at midbody, odd where one lies on the mid-back. 13 (mamba), 21 (milk snake), 57 (ball python).
    #[schemars(range(min = 1, max = 1000), extend("x-unit" = "rows"))]
    pub rows: u32,
    /// `leaf` (lanceolate, mostly keeled), `rhombus`, `hexagon` (blunt) or `granule`.
    pub shape: ScaleShape,
    /// Size of every scale on its lattice: below 1 skin shows between them.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub size: f32,
    /// Width against length: 1 touches its neighbours, above it overlaps them.
    #[schemars(range(min = 0.2, max = 2.0))]
    pub width: f32,
    /// Part of a scale that lies under the one before it.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "pitch"))]
    pub overlap: f32,
    /// Sharpness of the tip: 1 pointed, 0 blunt.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub apex: f32,
    /// Rounding of corners, 0 sharp to 1 round.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roundness: f32,
    /// Width of the vertebral row against the others; 1.6 in kraits.
    #[schemars(range(min = 0.5, max = 4.0))]
    pub vertebral: f32,
    /// Width of the lowest row against the mid-back; 1.3 to 1.6.
    #[schemars(range(min = 0.3, max = 4.0))]
    pub lowest: f32,
    /// Rows next to the belly over which they grow; 4 to 5 in pythons.
    #[schemars(range(min = 1.0, max = 1000.0), extend("x-unit" = "rows"))]
    pub lowest_rows: f32,
    /// Slant of the rows, tail-ward from the mid-back; 15 to 40 in racers, kraits and mambas.
    #[schemars(range(min = -60.0, max = 60.0), extend("x-unit" = "degrees"))]
    pub oblique_deg: f32,
    /// How far a scale rises over its base; 0.04 to 0.12 of its length measured.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub relief: f32,
    /// The same for belly scutes.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub ventral_relief: f32,
    /// Where along it a scale is highest; 0.72 to 0.86 measured.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub peak: f32,
    /// How much it falls off to its sides: 0 flat, 1 to the base.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub dome: f32,
    /// Width of its rounded rim, in row widths.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "pitch"))]
    pub bevel: f32,
    /// Height of the keel, in row widths: 0 smooth, 0.06 weak, 0.12 strong.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub keel: f32,
    /// Width of the keel, as a share of the scale's.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub keel_width: f32,
    /// How far the keel runs toward the tip; weak keels stop short.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keel_length: f32,
    /// Share of the rows, from the mid-back down, that are keeled.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keel_rows: f32,
    /// Irregularity of place, size and turn: 0 is a machine's, 1 natural, 3 rough.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub jitter: f32,
}

impl Default for Scales {
    fn default() -> Self {
        let lattice = ScaleLattice::default();
        Self {
            rows: lattice.rows,
            shape: lattice.shape,
            size: lattice.size,
            width: lattice.width,
            overlap: lattice.overlap,
            apex: lattice.apex,
            roundness: lattice.roundness,
            vertebral: lattice.vertebral,
            lowest: lattice.lowest,
            lowest_rows: lattice.lowest_rows,
            oblique_deg: lattice.oblique_deg,
            relief: lattice.relief,
            ventral_relief: lattice.ventral_relief,
            peak: lattice.peak,
            dome: lattice.dome,
            bevel: lattice.bevel,
            keel: lattice.keel,
            keel_width: lattice.keel_width,
            keel_length: lattice.keel_length,
            keel_rows: lattice.keel_rows,
            jitter: 1.0,
        }
    }
}

impl Scales {
    /// The lattice of this anatomy.
    pub fn lattice(&self, body: &Body, belly: &Belly) -> ScaleLattice {
        ScaleLattice {
            rows: self.rows,
            count: body.count(),
            ventrals: if belly.width > 0.0 { body.ventrals() } else { 0 },
            ventral_width: belly.width,
            shape: self.shape,
            overlap: self.overlap,
            size: self.size,
            width: self.width,
            apex: self.apex,
            roundness: self.roundness,
            vertebral: self.vertebral,
            lowest: self.lowest,
            lowest_rows: self.lowest_rows,
            oblique_deg: self.oblique_deg,
            relief: self.relief,
            ventral_relief: self.ventral_relief,
            peak: self.peak,
            dome: self.dome,
            bevel: self.bevel,
            keel: self.keel,
            keel_width: self.keel_width,
            keel_length: self.keel_length,
            keel_rows: self.keel_rows,
            jitter_position: (0.02 * self.jitter).min(1.0),
            jitter_size: (0.03 * self.jitter).min(0.9),
            jitter_rotation_deg: (1.2 * self.jitter).min(45.0),
            jitter_height: (0.1 * self.jitter).min(1.0),
        }
    }
}
