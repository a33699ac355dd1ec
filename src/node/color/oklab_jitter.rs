//! Colour that differs from scale to scale, in Oklab.

use std::ops::Range;

use super::jitter::draws;
use crate::base::color::{linear_to_oklab, oklab_to_linear};
use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Varies hue, chroma and lightness about a colour by one random number a scale, in Oklab: equal amounts look equal
/// at any hue, and a turn of the hue keeps the lightness.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OklabJitter {
    /// Three numbers are drawn from `random`; wire one number a scale. `false` moves all three together by
    /// `random` itself, which suits smooth noise.
    pub independent: bool,
}

impl Default for OklabJitter {
    fn default() -> Self {
        Self { independent: true }
    }
}

impl Operation for OklabJitter {
    const SPEC: Spec = Spec {
        name: "oklab_jitter",
        category: Category::Color,
        summary: "Varies colour from scale to scale, in Oklab.",
        inputs: &[
            InputSpec::color("color", "The colour, linear RGB; clamped to [0, 1] where it is changed."),
            InputSpec::drive(
                "random",
                0.5,
                (0.0, 1.0),
                "",
                "One number a scale: wire `random` of `scale_lattice` or of a flood fill.",
            ),
            InputSpec::drive(
                "hue",
                0.01,
                (0.0, 1.0),
                "turn",
                "How far the hue may turn either way: 0.01 is a nuance, 0.5 any hue.",
            ),
            InputSpec::drive(
                "chroma",
                0.1,
                (0.0, 1.0),
                "",
                "How much chroma may change either way, as a share of what is there: 0.1 is lively.",
            ),
            InputSpec::drive(
                "lightness",
                0.03,
                (0.0, 1.0),
                "",
                "How far the lightness may go either way, of black to white: 0.03 is natural, 0.15 is speckled.",
            ),
        ],
        outputs: &[OutputSpec::color("color", "The varied colour, linear RGB in [0, 1].")],
        random: true,
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        15.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let Some([r, g, b]) = outs.color_row(0, y) else { return };
            let [cr, cg, cb] = ins.color_row(0, y);
            let (random, hue, chroma, lightness) =
                (ins.row(1, y), ins.row(2, y), ins.row(3, y), ins.row(4, y));
            kernel(cr, cg, cb, random, hue, chroma, lightness, cx.seed, self.independent, r, g, b);
        }
    }
}

/// A colour with its Oklab hue turned, chroma scaled by 1 + `chroma` and lightness moved; all three at 0 return it as
/// it is, bit for bit. What leaves the gamut is clamped.
#[inline(always)]
fn varied(color: [f32; 3], hue: f32, chroma: f32, lightness: f32) -> [f32; 3] {
    let [l, a, b] = linear_to_oklab(color.map(num::saturate));
    let scale = (1.0 + chroma).max(0.0).min(1e3);
    let (cos, sin) = (num::cos_turns(hue) * scale, num::sin_turns(hue) * scale);
    let l = num::saturate(l + lightness);
    let changed = oklab_to_linear([l, a * cos - b * sin, a * sin + b * cos]).map(num::saturate);
    let same = hue == 0.0 && chroma == 0.0 && lightness == 0.0;
    let pick = |k: usize| if same { color[k] } else { changed[k] };
    [pick(0), pick(1), pick(2)]
}

multiversion! {
    fn kernel(
        cr: &[f32],
        cg: &[f32],
        cb: &[f32],
        random: &[f32],
        hue: &[f32],
        chroma: &[f32],
        lightness: &[f32],
        seed: u32,
        independent: bool,
        r: &mut [f32],
        g: &mut [f32],
        b: &mut [f32],
    ) {
        let n = r.len();
        let (cr, cg, cb, random) = (&cr[..n], &cg[..n], &cb[..n], &random[..n]);
        let (hue, chroma, lightness) = (&hue[..n], &chroma[..n], &lightness[..n]);
        let (g, b) = (&mut g[..n], &mut b[..n]);
        for x in 0..n {
            let [h, c, l] = draws(random[x], seed, independent);
            [r[x], g[x], b[x]] = varied([cr[x], cg[x], cb[x]], h * hue[x], c * chroma[x], l * lightness[x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::color::texel;

    #[test]
    fn each_amount_moves_its_own_coordinate() {
        let c = [0.3, 0.2, 0.1];
        let lch = |c: [f32; 3]| {
            let [l, a, b] = linear_to_oklab(c);
            (l, (a * a + b * b).sqrt(), num::atan2_turns(b, a))
        };
        let (l, chroma, hue) = lch(c);
        let (l1, c1, h1) = lch(varied(c, 0.05, 0.0, 0.0));
        assert!((l1 - l).abs() < 1e-4 && (c1 - chroma).abs() < 1e-4 && (h1 - hue - 0.05).abs() < 1e-3);
        let (l1, c1, h1) = lch(varied(c, 0.0, -0.5, 0.0));
        assert!((l1 - l).abs() < 1e-4 && (c1 - 0.5 * chroma).abs() < 1e-4 && (h1 - hue).abs() < 1e-3);
        let (l1, c1, h1) = lch(varied(c, 0.0, 0.0, 0.1));
        assert!((l1 - l - 0.1).abs() < 1e-4 && (c1 - chroma).abs() < 1e-4 && (h1 - hue).abs() < 1e-3);
    }

    #[test]
    fn amounts_of_0_change_no_bit() {
        let c = [0.123, 0.7, 0.02];
        assert_eq!(texel(&OklabJitter::default(), 3, &[&c, &[0.8], &[0.0], &[0.0], &[0.0]]), c);
    }

    #[test]
    fn scales_differ_and_the_same_scale_does_not() {
        let c = [0.3, 0.2, 0.05];
        let at = |random: f32, seed| texel(&OklabJitter::default(), seed, &[&c, &[random]]);
        assert_eq!(at(0.4, 1), at(0.4, 1));
        assert_ne!(at(0.4, 1), at(0.41, 1));
        assert_ne!(at(0.4, 1), at(0.4, 2));
        let together = OklabJitter { independent: false };
        let mid = texel(&together, 1, &[&c, &[0.5]]);
        assert!(mid.iter().zip(c).all(|(a, b)| (a - b).abs() < 1e-6), "{mid:?}");
    }
}
