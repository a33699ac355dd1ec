//! How a gradient runs from 0 to 1.

use crate::base::num;

/// How a gradient runs from 0 to 1 within its period.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// Straight from 0 to 1, then a jump.
    Ramp,
    /// Straight from 0 to 1 and back.
    #[default]
    Mirrored,
    /// A cosine wave from 0 to 1 and back.
    Wave,
}

impl Profile {
    /// As a number for kernels.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::Ramp => 0,
            Self::Mirrored => 1,
            Self::Wave => 2,
        }
    }
}

/// The gradient at `phase` periods, in [0, 1].
#[inline(always)]
pub(super) fn shade(phase: f32, code: u32) -> f32 {
    let ramp = num::fract(phase).min(1.0);
    let mirrored = 1.0 - (2.0 * ramp - 1.0).abs();
    let wave = 0.5 - 0.5 * num::cos_turns(ramp);
    match code {
        0 => ramp,
        1 => mirrored,
        _ => num::saturate(wave),
    }
}
