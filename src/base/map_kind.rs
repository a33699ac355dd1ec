//! The maps a texture set can hold.

use serde::{Deserialize, Serialize};

/// One map of a texture set.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MapKind {
    /// Apparent diffuse albedo, linear RGB in [0, 1]; written as sRGB.
    Color,
    /// Height of the surface, mm.
    Height,
    /// Tangent-space normal, from the height; written as (n + 1) / 2.
    Normal,
    /// Perceptual roughness (alpha = roughness^2), in [0, 1].
    Roughness,
    /// Thickness of the iridescent film, nm.
    Iridescence,
    /// Ambient occlusion, 1 is open, in [0, 1].
    AmbientOcclusion,
    /// Mean curvature of the height, 1/mm; 0 is flat, positive is convex.
    Curvature,
    /// Translucency, 0 opaque to 1 thin, in [0, 1].
    Translucency,
    /// Identity of the scale under the texel: 0 is skin, else 1 + its index in the instance table.
    ScaleId,
    /// The pigment pattern: 0 ground, 1 mark; in [0, 1].
    PatternMask,
}

impl MapKind {
    /// Every map, in the order they are written and listed.
    pub const ALL: [Self; 10] = [
        Self::Color,
        Self::Height,
        Self::Normal,
        Self::Roughness,
        Self::Iridescence,
        Self::AmbientOcclusion,
        Self::Curvature,
        Self::Translucency,
        Self::ScaleId,
        Self::PatternMask,
    ];

    /// The five maps of the thesis (000, section 4.2).
    pub const FIVE: [Self; 5] = [Self::Color, Self::Height, Self::Normal, Self::Roughness, Self::Iridescence];

    /// The name in presets, on the command line and in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Height => "height",
            Self::Normal => "normal",
            Self::Roughness => "roughness",
            Self::Iridescence => "iridescence",
            Self::AmbientOcclusion => "ambient_occlusion",
            Self::Curvature => "curvature",
            Self::Translucency => "translucency",
            Self::ScaleId => "scale_id",
            Self::PatternMask => "pattern_mask",
        }
    }

    /// The map of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }

    /// Channels: 3 for colour and normal, else 1.
    pub fn channels(self) -> usize {
        match self {
            Self::Color | Self::Normal => 3,
            _ => 1,
        }
    }

    /// The values that files of whole numbers store as 0 and 1, where a preset does not say it.
    pub fn default_range(self) -> [f32; 2] {
        match self {
            Self::Normal | Self::Curvature => [-1.0, 1.0],
            Self::Iridescence => [0.0, 1000.0],
            // Ids are stored as they are.
            Self::ScaleId => [0.0, 65_535.0],
            _ => [0.0, 1.0],
        }
    }

    /// The unit of its values, empty for pure numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Height => "mm",
            Self::Iridescence => "nm",
            Self::Curvature => "1/mm",
            _ => "",
        }
    }
}

impl std::fmt::Display for MapKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
