//! Linear and sRGB colour, which never share a type; Oklab and HSL.

use serde::{Deserialize, Serialize};

use super::num;

/// Linear RGB with sRGB primaries and white D65. Albedos lie in [0, 1]; intermediate values may not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearRgb(pub [f32; 3]);

/// A colour as artists type it: sRGB, eight bits a channel, `"#rrggbb"` (or `"#rgb"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Srgb8(pub [u8; 3]);

/// Why a text is no colour.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a colour: write \"#rrggbb\", sRGB in hexadecimal, such as \"#9C3B24\"")]
pub struct ColorError(pub String);

impl std::str::FromStr for Srgb8 {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, ColorError> {
        let fail = || ColorError(text.chars().take(40).collect());
        let hex = text.strip_prefix('#').ok_or_else(fail)?;
        if !hex.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(fail());
        }
        let n = u32::from_str_radix(hex, 16).map_err(|_| fail())?;
        match hex.len() {
            6 => Ok(Self([(n >> 16) as u8, (n >> 8) as u8, n as u8])),
            3 => {
                let d = |shift: u32| ((n >> shift & 0xf) * 17) as u8;
                Ok(Self([d(8), d(4), d(0)]))
            }
            _ => Err(fail()),
        }
    }
}

impl TryFrom<String> for Srgb8 {
    type Error = ColorError;

    fn try_from(text: String) -> Result<Self, ColorError> {
        text.parse()
    }
}

impl From<Srgb8> for String {
    fn from(c: Srgb8) -> Self {
        c.to_string()
    }
}

impl std::fmt::Display for Srgb8 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02X}{g:02X}{b:02X}")
    }
}

impl schemars::JsonSchema for Srgb8 {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Color".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": "string",
            "format": "color",
            "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$",
            "description": "An sRGB colour, \"#rrggbb\"."
        })
    }
}

/// The sRGB transfer function, encoded to linear, both in [0, 1] (IEC 61966-2-1).
#[inline(always)]
pub fn srgb_to_linear(e: f32) -> f32 {
    let low = e * (1.0 / 12.92);
    let high = num::powf((e + 0.055) * (1.0 / 1.055), 2.4);
    if e <= 0.04045 { low } else { high }
}

/// The inverse sRGB transfer function, linear to encoded, both in [0, 1] (IEC 61966-2-1).
#[inline(always)]
pub fn linear_to_srgb(l: f32) -> f32 {
    let low = l * 12.92;
    let high = 1.055 * num::powf(l, 1.0 / 2.4) - 0.055;
    if l <= 0.003_130_8 { low } else { high }
}

impl From<Srgb8> for LinearRgb {
    fn from(c: Srgb8) -> Self {
        Self(c.0.map(|v| srgb_to_linear(f32::from(v) / 255.0)))
    }
}

impl From<LinearRgb> for Srgb8 {
    /// The nearest sRGB colour; out-of-range channels are clamped.
    fn from(c: LinearRgb) -> Self {
        Self(c.0.map(|v| (linear_to_srgb(num::saturate(v)) * 255.0 + 0.5) as u8))
    }
}

impl LinearRgb {
    /// Relative luminance, Rec. 709 weights.
    pub fn luminance(self) -> f32 {
        let [r, g, b] = self.0;
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }
}

/// Linear RGB to Oklab (L in [0, 1] for colours in gamut).
///
/// Source: Bjorn Ottosson, "A perceptual color space for image processing" (2020), revised matrices of 2021.
#[inline(always)]
pub fn linear_to_oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
    let l = num::cbrt(0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b);
    let m = num::cbrt(0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b);
    let s = num::cbrt(0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b);
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// Oklab to linear RGB; may leave [0, 1] for colours out of gamut.
#[inline(always)]
pub fn oklab_to_linear([l, a, b]: [f32; 3]) -> [f32; 3] {
    let l_ = l + 0.396_337_78 * a + 0.215_803_76 * b;
    let m_ = l - 0.105_561_346 * a - 0.063_854_17 * b;
    let s_ = l - 0.089_484_18 * a - 1.291_485_5 * b;
    let (l, m, s) = (l_ * l_ * l_, m_ * m_ * m_, s_ * s_ * s_);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

/// RGB in [0, 1] to hue (turns), saturation, lightness, each in [0, 1]. Greys have hue 0 and saturation 0.
#[inline(always)]
pub fn rgb_to_hsl([r, g, b]: [f32; 3]) -> [f32; 3] {
    let max = r.max(g).max(b);
    let min = r.min(g).min(b);
    let l = 0.5 * (max + min);
    let c = max - min;
    let d = 1.0 - (2.0 * l - 1.0).abs();
    let s = if d > 1e-6 { c / d } else { 0.0 };
    let safe = if c > 0.0 { c } else { 1.0 };
    let h = if max == r {
        (g - b) / safe
    } else if max == g {
        2.0 + (b - r) / safe
    } else {
        4.0 + (r - g) / safe
    };
    let h = if c > 0.0 { h / 6.0 } else { 0.0 };
    [h - h.floor(), num::saturate(s), l]
}

/// Hue (turns, any), saturation and lightness in [0, 1] to RGB.
#[inline(always)]
pub fn hsl_to_rgb([h, s, l]: [f32; 3]) -> [f32; 3] {
    let c = (1.0 - (2.0 * l - 1.0).abs()) * s;
    let channel = |k: f32| {
        let x = num::fract(h + k / 3.0) * 6.0;
        let t = num::saturate((x - 3.0).abs() - 1.0);
        l + c * (t - 0.5)
    };
    [channel(0.0), channel(2.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_parses_and_prints() {
        assert_eq!("#9C3B24".parse(), Ok(Srgb8([0x9c, 0x3b, 0x24])));
        assert_eq!("#fff".parse(), Ok(Srgb8([255; 3])));
        for bad in ["9C3B24", "#12345", "#gg0000", "#+12345", "", "#é12"] {
            assert!(bad.parse::<Srgb8>().is_err(), "{bad}");
        }
        assert_eq!(Srgb8([1, 2, 3]).to_string(), "#010203");
    }

    #[test]
    fn srgb_bytes_survive_a_round_trip() {
        for v in 0..=255 {
            let c = Srgb8([v, 255 - v, v / 2]);
            assert_eq!(Srgb8::from(LinearRgb::from(c)), c);
        }
    }

    /// Published values: Ottosson's table gives XYZ; white and the sRGB primaries are widely tabulated.
    #[test]
    fn oklab_of_white_and_red_are_the_published_values() {
        let [l, a, b] = linear_to_oklab([1.0; 3]);
        assert!((l - 1.0).abs() < 1e-5 && a.abs() < 1e-4 && b.abs() < 1e-4);
        let [l, a, b] = linear_to_oklab([1.0, 0.0, 0.0]);
        assert!((l - 0.627_955).abs() < 1e-4 && (a - 0.224_863).abs() < 1e-4 && (b - 0.125_846).abs() < 1e-4);
        let back = oklab_to_linear(linear_to_oklab([0.2, 0.5, 0.1]));
        for (x, y) in back.iter().zip([0.2, 0.5, 0.1]) {
            assert!((x - y).abs() < 1e-4);
        }
    }

    #[test]
    fn hsl_inverts() {
        for c in [[0.8, 0.1, 0.3], [0.1, 0.8, 0.3], [0.2, 0.1, 0.9], [0.5, 0.5, 0.5], [0.0; 3], [1.0; 3]] {
            let back = hsl_to_rgb(rgb_to_hsl(c));
            for (x, y) in back.iter().zip(c) {
                assert!((x - y).abs() < 1e-5, "{c:?} {back:?}");
            }
        }
    }
}
