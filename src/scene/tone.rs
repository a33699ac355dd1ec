//! From radiance to what a screen shows: exposure, and curves that fit any brightness into [0, 1].

use serde::{Deserialize, Serialize};

use crate::base::color::{LinearRgb, linear_to_srgb};
use crate::base::num;

/// A tone curve: linear sRGB of any brightness to linear sRGB that a screen can show, in [0, 1].
///
/// Black is black, brighter is never darker (of AgX's fitted colours within 1e-4), and what is negative or NaN is read as
/// 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ToneMap {
    /// None: channels above 1 are cut. What is in [0, 1] stays as it is, for measuring.
    Clamp,
    /// `c/(1 + c)` (Reinhard et al. 2002, equation 3), each channel alone.
    Reinhard,
    /// ACES as fitted by Stephen Hill (BakingLab, 2016): filmic, contrasty.
    Aces,
    /// AgX as fitted by Benjamin Wrensch ("Minimal AgX implementation", 2023): bright colours fade to white.
    Agx,
    /// Khronos PBR Neutral (2024): colours below 0.8 as they are, less 0.04; only highlights are compressed.
    #[default]
    Neutral,
}

/// Brighter than this is this bright: squares stay finite.
const BRIGHTEST: f32 = 1e9;

impl ToneMap {
    /// Every curve.
    pub const ALL: [Self; 5] = [Self::Clamp, Self::Reinhard, Self::Aces, Self::Agx, Self::Neutral];

    /// The word for it in scenes and arguments.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
            Self::Agx => "agx",
            Self::Neutral => "neutral",
        }
    }

    /// The curve.
    pub fn map(self, color: LinearRgb) -> LinearRgb {
        // `max` first: it gives 0 for NaN.
        let c = color.0.map(|c| c.max(0.0).min(BRIGHTEST));
        let mapped = match self {
            Self::Clamp => c,
            Self::Reinhard => c.map(|c| c / (1.0 + c)),
            Self::Aces => aces(c),
            Self::Agx => agx(c),
            Self::Neutral => neutral(c),
        };
        LinearRgb(mapped.map(num::saturate))
    }

    /// The curve and then sRGB's encoding: what a file holds, each channel in [0, 1]. `exposure_ev` is a power of two
    /// before the curve.
    pub fn encode(self, color: LinearRgb, exposure_ev: f32) -> [f32; 3] {
        let gain = num::exp2(exposure_ev);
        let LinearRgb(mapped) = self.map(LinearRgb(color.0.map(|c| c * gain)));
        mapped.map(|c| num::saturate(linear_to_srgb(c)))
    }
}

fn multiply(m: [[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

fn aces(color: [f32; 3]) -> [f32; 3] {
    let inside = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    let outside =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve =
        |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    multiply(outside, multiply(inside, color).map(curve))
}

fn agx(color: [f32; 3]) -> [f32; 3] {
    let inset = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_142_97],
    ];
    let outset = [
        [1.196_879, -0.098_020_88, -0.099_029_744],
        [-0.052_896_757, 1.151_903_1, -0.098_961_18],
        [-0.052_971_636, -0.098_043_45, 1.151_073_7],
    ];
    let (low, high) = (-12.473_93_f32, 4.026_069_f32);
    let curve = |v: f32| {
        let x = num::saturate((num::log2(v) - low) / (high - low));
        let p = [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
        p.iter().rev().fold(0.0, |sum, c| sum * x + c)
    };
    // The curve gives what a display of exponent 2.2 takes.
    multiply(outset, multiply(inset, color).map(curve)).map(|c| num::powf(c.max(0.0), 2.2))
}

fn neutral(color: [f32; 3]) -> [f32; 3] {
    let (start, desaturation) = (0.8 - 0.04, 0.15);
    let least = color[0].min(color[1]).min(color[2]);
    // The reflection that a dielectric of 1.5 adds to a picture of a colour, taken away again.
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color.map(|c| c - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < start {
        return color;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let gray = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    color.map(|c| num::lerp(c * (new_peak / peak), new_peak, gray))
}

/// How an exposure is found from a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metering {
    /// The geometric mean of the luminances becomes this, such as 0.18.
    LogAverage(f32),
    /// The luminance that this share of the texels stays below becomes `target`: highlights are kept by 0.99 and 1.
    Percentile {
        /// Share of the texels, in [0, 1].
        share: f32,
        /// What that luminance becomes.
        target: f32,
    },
}

impl Metering {
    /// The exposure as a power of two, in [-64, 64]. Black texels and those that are not finite tell nothing and are left
    /// out; without any other it is 0.
    pub fn exposure_ev(self, texels: &[[f32; 3]]) -> f32 {
        let luminances = texels.iter().map(|t| LinearRgb(*t).luminance());
        let mut lit: Vec<f32> = luminances.filter(|l| l.is_finite() && *l > 0.0).collect();
        if lit.is_empty() {
            return 0.0;
        }
        let (measured, target) = match self {
            Self::LogAverage(target) => {
                (lit.iter().map(|l| libm::log2(f64::from(*l))).sum::<f64>() / lit.len() as f64, target)
            }
            Self::Percentile { share, target } => {
                let at = (num::saturate(share) * (lit.len() - 1) as f32) as usize;
                let (_, l, _) = lit.select_nth_unstable_by(at, f32::total_cmp);
                (libm::log2(f64::from(*l)), target)
            }
        };
        let ev = libm::log2(f64::from(target.max(f32::MIN_POSITIVE))) - measured;
        ev.max(-64.0).min(64.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_scenes_say() {
        for map in ToneMap::ALL {
            assert_eq!(serde_json::to_value(map).unwrap(), map.name());
        }
    }

    #[test]
    fn limits_are_limits() {
        for map in ToneMap::ALL {
            let LinearRgb(black) = map.map(LinearRgb::default());
            assert!(black.iter().all(|c| *c < 2e-4), "{map:?} {black:?}");
            for huge in [1e6, 1e30, f32::INFINITY] {
                let LinearRgb(white) = map.map(LinearRgb([huge; 3]));
                assert!(white.iter().all(|c| *c > 0.97 && *c <= 1.0), "{map:?} {white:?}");
            }
            for odd in [[f32::NAN; 3], [-1.0, f32::INFINITY, f32::NAN], [f32::NEG_INFINITY, 1e-40, 3.0]] {
                let out = map.encode(LinearRgb(odd), 1.0);
                assert!(out.iter().all(|c| (0.0..=1.0).contains(c)), "{map:?} {odd:?} {out:?}");
            }
        }
    }

    #[test]
    fn more_light_is_never_darker() {
        for map in ToneMap::ALL {
            for hue in [[1.0, 1.0, 1.0], [1.0, 0.3, 0.05], [0.02, 0.2, 0.9]] {
                let mut last = -1.0;
                for i in 0..2000 {
                    let brightness = num::exp2(-14.0 + 0.014 * i as f32);
                    let l = map.map(LinearRgb(hue.map(|c: f32| c * brightness))).luminance();
                    // Greys to rounding; AgX's outset lets saturated highlights fall by 1e-5 near white.
                    let slack = if map == ToneMap::Agx && hue != [1.0; 3] { 1e-4 } else { 2e-6 };
                    assert!(l >= last - slack, "{map:?} {hue:?} {brightness}: {l} after {last}");
                    last = l;
                }
            }
        }
    }

    /// Values worked out by hand from the published formulas.
    #[test]
    fn curves_are_the_published_ones() {
        let gray = |map: ToneMap, l: f32| map.map(LinearRgb([l; 3])).0[1];
        assert_eq!(gray(ToneMap::Clamp, 0.25), 0.25);
        assert_eq!(gray(ToneMap::Reinhard, 1.0), 0.5);
        // Neutral: x - 0.04 up to 0.8; 6.25 x^2 below 0.08; at 1: 1 - 0.24^2/(0.96 + 0.24 - 0.76).
        assert!((gray(ToneMap::Neutral, 0.5) - 0.46).abs() < 1e-6);
        assert!((gray(ToneMap::Neutral, 0.04) - 0.01).abs() < 1e-6);
        assert!((gray(ToneMap::Neutral, 1.0) - (1.0 - 0.0576 / 0.44)).abs() < 1e-6);
        // ACES: at 1, (1.0245786 - 0.000090537)/(0.983729 + 0.432951 + 0.238081) = 0.61914.
        assert!((gray(ToneMap::Aces, 1.0) - 0.619_1).abs() < 1e-3);
        // AgX keeps middle grey near middle grey: x = (log2(0.18) + 12.47393)/16.5 = 0.60606.
        let x: f32 = 0.606_06;
        let display =
            -0.00232 + x * (0.1191 + x * (0.4298 + x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
        assert!((gray(ToneMap::Agx, 0.18) - display.powf(2.2)).abs() < 1e-3);
        assert!((0.15..0.22).contains(&gray(ToneMap::Agx, 0.18)));
    }

    #[test]
    fn saturated_highlights_fade_to_white_where_that_is_the_curve() {
        for (map, least) in [(ToneMap::Agx, 0.3), (ToneMap::Neutral, 0.5)] {
            let LinearRgb(c) = map.map(LinearRgb([100.0, 0.0, 0.0]));
            assert!(c[1] > least, "{map:?} {c:?}");
        }
        assert_eq!(ToneMap::Clamp.map(LinearRgb([100.0, 0.0, 0.0])), LinearRgb([1.0, 0.0, 0.0]));
    }

    #[test]
    fn meters_bring_what_they_measure_to_the_target() {
        let texels: Vec<[f32; 3]> =
            (0..100).map(|i| [0.5 * (i + 1) as f32; 3]).chain([[0.0; 3], [f32::NAN; 3]]).collect();
        let ev = Metering::Percentile { share: 1.0, target: 1.0 }.exposure_ev(&texels);
        assert!((ev + 50.0_f32.log2()).abs() < 1e-5);
        let ev = Metering::LogAverage(0.18).exposure_ev(&[[4.0; 3], [1.0; 3], [0.0; 3]]);
        assert!((ev - (0.18_f32 / 2.0).log2()).abs() < 1e-5);
        // Twice the light is one step less.
        let brighter: Vec<[f32; 3]> = texels.iter().map(|t| t.map(|c| 2.0 * c)).collect();
        let step =
            Metering::LogAverage(0.2).exposure_ev(&texels) - Metering::LogAverage(0.2).exposure_ev(&brighter);
        assert!((step - 1.0).abs() < 1e-5);
        assert_eq!(Metering::LogAverage(0.18).exposure_ev(&[[0.0; 3]]), 0.0);
    }
}
