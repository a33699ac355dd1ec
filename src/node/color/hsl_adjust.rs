//! Hue, saturation and lightness.

use std::ops::Range;

use crate::base::color::{hsl_to_rgb, linear_to_srgb, rgb_to_hsl, srgb_to_linear};
use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Turns the hue and changes saturation and lightness, as the slider trio of every paint program: HSL of the
/// sRGB-encoded colour.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HslAdjust {}

impl Operation for HslAdjust {
    const SPEC: Spec = Spec {
        name: "hsl_adjust",
        category: Category::Color,
        summary: "Changes hue, saturation and lightness.",
        inputs: &[
            InputSpec::color("color", "The colour, linear RGB; clamped to [0, 1] where it is changed."),
            InputSpec::drive(
                "hue",
                0.0,
                (-1.0, 1.0),
                "turn",
                "Turns the hue: 1/3 makes red green; 0.02 is a nuance.",
            ),
            InputSpec::drive(
                "saturation",
                0.0,
                (-1.0, 1.0),
                "",
                "-1 is grey, 0 as it is, 1 doubles the saturation.",
            ),
            InputSpec::drive("lightness", 0.0, (-1.0, 1.0), "", "-1 is black, 0 as it is, 1 is white."),
        ],
        outputs: &[OutputSpec::color("color", "The changed colour, linear RGB in [0, 1].")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        25.0
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let Some([r, g, b]) = outs.color_row(0, y) else { return };
            let [cr, cg, cb] = ins.color_row(0, y);
            kernel(cr, cg, cb, ins.row(1, y), ins.row(2, y), ins.row(3, y), r, g, b);
        }
    }
}

/// A colour with its HSL changed; all three at 0 return it as it is, bit for bit.
///
/// * `hue` - turns, any.
/// * `saturation`, `lightness` - in [-1, 1], else clamped.
#[inline(always)]
pub(super) fn adjusted(color: [f32; 3], hue: f32, saturation: f32, lightness: f32) -> [f32; 3] {
    // Channel by channel: a closure given to `map` is not inlined into the wider SIMD levels, 20 times slower.
    let [r, g, b] = color;
    let [h, s, l] = rgb_to_hsl([encoded(r), encoded(g), encoded(b)]);
    let saturation = saturation.max(-1.0).min(1.0);
    let lightness = lightness.max(-1.0).min(1.0);
    let s = num::saturate(s * (1.0 + saturation));
    let room = if lightness > 0.0 { 1.0 - l } else { l };
    let [nr, ng, nb] = hsl_to_rgb([h + num::fract(hue), s, num::saturate(l + lightness * room)]);
    let same = hue == 0.0 && saturation == 0.0 && lightness == 0.0;
    [
        if same { r } else { decoded(nr) },
        if same { g } else { decoded(ng) },
        if same { b } else { decoded(nb) },
    ]
}

/// Linear to sRGB, both clamped to [0, 1].
#[inline(always)]
fn encoded(c: f32) -> f32 {
    linear_to_srgb(num::saturate(c))
}

/// sRGB to linear, both clamped to [0, 1].
#[inline(always)]
fn decoded(c: f32) -> f32 {
    num::saturate(srgb_to_linear(num::saturate(c)))
}

multiversion! {
    fn kernel(
        cr: &[f32],
        cg: &[f32],
        cb: &[f32],
        hue: &[f32],
        saturation: &[f32],
        lightness: &[f32],
        r: &mut [f32],
        g: &mut [f32],
        b: &mut [f32],
    ) {
        let n = r.len();
        let (cr, cg, cb) = (&cr[..n], &cg[..n], &cb[..n]);
        let (hue, saturation, lightness) = (&hue[..n], &saturation[..n], &lightness[..n]);
        let (g, b) = (&mut g[..n], &mut b[..n]);
        for x in 0..n {
            [r[x], g[x], b[x]] = adjusted([cr[x], cg[x], cb[x]], hue[x], saturation[x], lightness[x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{LinearRgb, Srgb8};
    use crate::node::color::texel;

    fn run(color: &str, hue: f32, saturation: f32, lightness: f32) -> Srgb8 {
        let c = LinearRgb::from(color.parse::<Srgb8>().expect("a colour")).0;
        let v = texel(&HslAdjust::default(), 0, &[&c, &[hue], &[saturation], &[lightness]]);
        Srgb8::from(LinearRgb([v[0], v[1], v[2]]))
    }

    #[test]
    fn zeros_change_no_bit() {
        let c = [0.123, 1.7, -0.2];
        assert_eq!(texel(&HslAdjust::default(), 0, &[&c, &[0.0], &[0.0], &[0.0]]), c);
    }

    #[test]
    fn a_third_of_a_turn_permutes_the_primaries() {
        assert_eq!(run("#ff0000", 1.0 / 3.0, 0.0, 0.0).to_string(), "#00FF00");
        assert_eq!(run("#ff0000", -1.0 / 3.0, 0.0, 0.0).to_string(), "#0000FF");
        assert_eq!(run("#9C3B24", 1.0, 0.0, 0.0).to_string(), "#9C3B24");
    }

    #[test]
    fn the_ends_are_grey_black_and_white() {
        // HSL lightness of #9C3B24 is (0x9C + 0x24) / 2 = 0x60.
        assert_eq!(run("#9C3B24", 0.0, -1.0, 0.0).to_string(), "#606060");
        assert_eq!(run("#9C3B24", 0.0, 0.0, -1.0).to_string(), "#000000");
        assert_eq!(run("#9C3B24", 0.0, 0.0, 1.0).to_string(), "#FFFFFF");
    }
}
