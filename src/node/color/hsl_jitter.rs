//! Colour that differs from scale to scale, in HSL.

use std::ops::Range;

use super::hsl_adjust::adjusted;
use super::jitter::draws;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Varies hue, saturation and lightness about a colour by one random number a scale, in HSL as `hsl_adjust`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HslJitter {
    /// Three numbers are drawn from `random`; wire one number a scale. `false` moves all three together by
    /// `random` itself, which suits smooth noise.
    pub independent: bool,
}

impl Default for HslJitter {
    fn default() -> Self {
        Self { independent: true }
    }
}

impl Operation for HslJitter {
    const SPEC: Spec = Spec {
        name: "hsl_jitter",
        category: Category::Color,
        summary: "Varies colour from scale to scale, in HSL.",
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
                "saturation",
                0.1,
                (0.0, 1.0),
                "",
                "How much saturation may change either way, as a share of what is there: 0.1 is lively.",
            ),
            InputSpec::drive(
                "lightness",
                0.03,
                (0.0, 1.0),
                "",
                "How far the lightness may go either way, 1 to black or white: 0.03 is natural, 0.15 is speckled.",
            ),
        ],
        outputs: &[OutputSpec::color("color", "The varied colour, linear RGB in [0, 1].")],
        random: true,
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        28.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let Some([r, g, b]) = outs.color_row(0, y) else { return };
            let [cr, cg, cb] = ins.color_row(0, y);
            let (random, hue, saturation, lightness) =
                (ins.row(1, y), ins.row(2, y), ins.row(3, y), ins.row(4, y));
            kernel(cr, cg, cb, random, hue, saturation, lightness, cx.seed, self.independent, r, g, b);
        }
    }
}

multiversion! {
    fn kernel(
        cr: &[f32],
        cg: &[f32],
        cb: &[f32],
        random: &[f32],
        hue: &[f32],
        saturation: &[f32],
        lightness: &[f32],
        seed: u32,
        independent: bool,
        r: &mut [f32],
        g: &mut [f32],
        b: &mut [f32],
    ) {
        let n = r.len();
        let (cr, cg, cb, random) = (&cr[..n], &cg[..n], &cb[..n], &random[..n]);
        let (hue, saturation, lightness) = (&hue[..n], &saturation[..n], &lightness[..n]);
        let (g, b) = (&mut g[..n], &mut b[..n]);
        for x in 0..n {
            let [h, c, l] = draws(random[x], seed, independent);
            [r[x], g[x], b[x]] = adjusted([cr[x], cg[x], cb[x]], h * hue[x], c * saturation[x], l * lightness[x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::color::texel;

    #[test]
    fn it_is_hsl_adjust_by_the_drawn_amounts() {
        let c = [0.3, 0.2, 0.05];
        let got = texel(&HslJitter { independent: false }, 1, &[&c, &[0.75], &[0.2], &[0.4], &[0.1]]);
        assert_eq!(got, adjusted(c, 0.1, 0.2, 0.05));
    }

    #[test]
    fn amounts_of_0_change_no_bit() {
        let c = [0.123, 0.7, 0.02];
        assert_eq!(texel(&HslJitter::default(), 3, &[&c, &[0.8], &[0.0], &[0.0], &[0.0]]), c);
    }

    #[test]
    fn scales_differ_and_the_same_scale_does_not() {
        let c = [0.3, 0.2, 0.05];
        let at = |random: f32, seed| texel(&HslJitter::default(), seed, &[&c, &[random]]);
        assert_eq!(at(0.4, 1), at(0.4, 1));
        assert_ne!(at(0.4, 1), at(0.41, 1));
        assert_ne!(at(0.4, 1), at(0.4, 2));
        let together = HslJitter { independent: false };
        let mid = texel(&together, 1, &[&c, &[0.5]]);
        assert!(mid.iter().zip(c).all(|(a, b)| (a - b).abs() < 1e-6), "{mid:?}");
    }
}
