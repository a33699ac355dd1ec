//! One number from a colour.

use std::ops::Range;

use crate::base::color::linear_to_oklab;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Which number stands for a colour.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum GrayscaleMode {
    /// Relative luminance: how much light (Rec. 709 weights of linear RGB).
    #[default]
    Luminance,
    /// Oklab lightness: how light it looks, 0.5 is middle grey.
    Lightness,
    /// Mean of the channels.
    Average,
    /// The largest channel.
    Max,
    /// The smallest channel.
    Min,
}

/// A scalar from a colour.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Grayscale {
    /// Which number stands for the colour: `luminance`, `lightness` (to the eye), `average`, `max` or `min`.
    pub mode: GrayscaleMode,
}

impl Operation for Grayscale {
    const SPEC: Spec = Spec {
        name: "grayscale",
        category: Category::Color,
        summary: "Makes a scalar from a colour.",
        inputs: &[InputSpec::color("color", "The colour, linear RGB.")],
        outputs: &[OutputSpec::scalar("value", "", "In [0, 1] for colours in [0, 1].")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        if self.mode == GrayscaleMode::Lightness { 6.0 } else { 0.3 }
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let [r, g, b] = ins.color_row(0, y);
            let out = outs.only(y);
            match self.mode {
                GrayscaleMode::Luminance => weighted(r, g, b, [0.2126, 0.7152, 0.0722], out),
                GrayscaleMode::Average => weighted(r, g, b, [1.0 / 3.0; 3], out),
                GrayscaleMode::Lightness => lightness(r, g, b, out),
                GrayscaleMode::Max => largest(r, g, b, 1.0, out),
                GrayscaleMode::Min => largest(r, g, b, -1.0, out),
            }
        }
    }
}

multiversion! {
    fn weighted(r: &[f32], g: &[f32], b: &[f32], weights: [f32; 3], out: &mut [f32]) {
        let [wr, wg, wb] = weights;
        for (((o, r), g), b) in out.iter_mut().zip(r).zip(g).zip(b) {
            // The weights sum to 1, but at the largest f32 rounding may still overflow.
            *o = (wr * r + wg * g + wb * b).max(f32::MIN).min(f32::MAX);
        }
    }
}

multiversion! {
    fn lightness(r: &[f32], g: &[f32], b: &[f32], out: &mut [f32]) {
        for (((o, r), g), b) in out.iter_mut().zip(r).zip(g).zip(b) {
            let limited = [r.max(-1e30).min(1e30), g.max(-1e30).min(1e30), b.max(-1e30).min(1e30)];
            *o = linear_to_oklab(limited)[0];
        }
    }
}

multiversion! {
    /// The largest channel; the smallest with a `sign` of -1.
    fn largest(r: &[f32], g: &[f32], b: &[f32], sign: f32, out: &mut [f32]) {
        for (((o, r), g), b) in out.iter_mut().zip(r).zip(g).zip(b) {
            *o = sign * (sign * r).max(sign * g).max(sign * b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::LinearRgb;
    use crate::node::color::texel;

    #[test]
    fn each_mode_is_its_definition() {
        let c = [0.3, 0.6, 0.15];
        for (mode, expected) in [
            (GrayscaleMode::Luminance, LinearRgb(c).luminance()),
            (GrayscaleMode::Lightness, linear_to_oklab(c)[0]),
            (GrayscaleMode::Average, 0.35),
            (GrayscaleMode::Max, 0.6),
            (GrayscaleMode::Min, 0.15),
        ] {
            let got = texel(&Grayscale { mode }, 0, &[&c])[0];
            assert!((got - expected).abs() < 1e-6, "{mode:?}: {got}");
            // A grey is itself in every mode but that of the eye.
            let grey = texel(&Grayscale { mode }, 0, &[&[0.25; 3]])[0];
            let expected = if mode == GrayscaleMode::Lightness { 0.25f32.cbrt() } else { 0.25 };
            assert!((grey - expected).abs() < 1e-5, "{mode:?}: {grey}");
        }
    }
}
