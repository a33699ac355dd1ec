//! How a picture is computed.

use super::sampler::SamplerKind;
use crate::optics::Parts;

/// Everything but the scene that a picture depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples per pixel.
    pub samples: u32,
    /// Another noise.
    pub seed: u32,
    /// Light that is followed, and colours.
    pub transport: Transport,
    /// How lights are found.
    pub technique: Technique,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Which layers of the skin there are.
    pub stage: Stage,
    /// Most radiance, relative to D65, that a path may bring home by way of a second surface or more. It removes the bright
    /// specks of caustics, and is the one setting that darkens a picture: none for truth.
    pub clamp: Option<f32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 960,
            height: 540,
            samples: 64,
            seed: 0,
            transport: Transport::Full { bounces: 16 },
            technique: Technique::Mis,
            sampler: SamplerKind::Sobol,
            stage: Stage::All,
            clamp: None,
        }
    }
}

/// Which light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// All of it, in wavelengths, with coupled energy: the ground truth.
    Full {
        /// Surfaces that a path may meet.
        bounces: u32,
    },
    /// What a rasteriser can do: light that comes straight from its source, in red, green and blue, each material with its
    /// own energy mode.
    Direct {
        /// Whether objects keep the environment's light off each other.
        environment_shadows: bool,
    },
}

impl Transport {
    /// Surfaces that a path may meet.
    pub(super) fn bounces(self) -> u32 {
        match self {
            Self::Full { bounces } => bounces,
            Self::Direct { .. } => 1,
        }
    }

    /// Whether the environment's light goes through everything.
    pub(super) fn ghostly_environment(self) -> bool {
        self == Self::Direct { environment_shadows: false }
    }
}

/// How lights are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Technique {
    /// By chance: directions are those that the surface likes. Directional lights stay dark.
    Bsdf,
    /// At each surface one light is asked (next-event estimation), and lights that are met by chance do not count.
    NextEvent,
    /// Both, weighted by the power heuristic (Veach 1997, 9.2.4).
    #[default]
    Mis,
}

impl Technique {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsdf => "BSDF sampling",
            Self::NextEvent => "next-event estimation",
            Self::Mis => "both, MIS",
        }
    }

    /// Whether lights are asked.
    pub(super) fn asks(self) -> bool {
        self != Self::Bsdf
    }

    /// Weight of light that is met with density `surface` where asking finds it with density `light`. Mirrors, and the
    /// eye, have an infinite density.
    #[inline(always)]
    pub(super) fn weight_met(self, surface: f32, light: f32) -> f32 {
        match self {
            _ if surface == f32::INFINITY => 1.0,
            Self::Bsdf => 1.0,
            Self::NextEvent => 0.0,
            Self::Mis => power(surface, light),
        }
    }

    /// Weight of light that is asked for with density `light` where it is met with density `surface`.
    #[inline(always)]
    pub(super) fn weight_asked(self, light: f32, surface: f32) -> f32 {
        match self {
            Self::Bsdf => 0.0,
            Self::NextEvent => 1.0,
            Self::Mis => power(light, surface),
        }
    }
}

/// `a^2/(a^2 + b^2)`, without overflow.
#[inline(always)]
fn power(a: f32, b: f32) -> f32 {
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}

/// The thesis's four stages of the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// The base alone, without normal map or gloss.
    Diffuse,
    /// The base with the normal map.
    Normal,
    /// What the film reflects, alone.
    Film,
    /// All layers.
    #[default]
    All,
}

impl Stage {
    /// Whether the normal map counts.
    pub(super) fn has_bumps(self) -> bool {
        self != Self::Diffuse
    }

    /// The layers that there are.
    pub(super) fn parts(self) -> Parts {
        match self {
            Self::Diffuse | Self::Normal => Parts::Lambert,
            Self::Film => Parts::Specular,
            Self::All => Parts::All,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_both_ways_to_find_a_light_sum_to_1() {
        for technique in [Technique::Bsdf, Technique::NextEvent, Technique::Mis] {
            for (a, b) in [(1.0, 2.0), (1e-30, 1e30), (1e30, 1e-30), (0.3, 0.0)] {
                let sum = technique.weight_met(a, b) + technique.weight_asked(b, a);
                assert!(
                    (sum - 1.0).abs() < 1e-6 || (b == 0.0 && technique != Technique::Bsdf),
                    "{technique:?}"
                );
            }
            // A mirror's reflection of a lamp cannot be asked for.
            assert_eq!(technique.weight_met(f32::INFINITY, 3.0), 1.0);
        }
    }
}
