//! A scalar through a ramp of colours.

use std::ops::Range;

use crate::base::color::{LinearRgb, Srgb8, linear_to_oklab, oklab_to_linear};
use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, ParamError, Spec};

/// A colour at a place of the ramp.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// The value that gets this colour.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = ""))]
    pub at: f32,
    /// The colour.
    pub color: Srgb8,
}

/// What lies between two stops.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// An even blend.
    #[default]
    Linear,
    /// A blend that eases out of each stop: no visible kink.
    Smooth,
    /// The colour of the stop before: flat steps.
    Constant,
}

/// Where colours are mixed.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MixSpace {
    /// As paint looks between two colours: even to the eye, no muddy middle.
    #[default]
    Oklab,
    /// As light adds up.
    Linear,
}

/// A ramp of colours over a scalar. Below the first stop and above the last the colour stays.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GradientMap {
    /// The ramp, in rising order: `[{ at = 0.0, color = "#1B1210" }, { at = 1.0, color = "#C8A06A" }]`. Two stops at
    /// the same place make a hard edge.
    pub stops: Vec<Stop>,
    /// What lies between two stops: `linear`, `smooth` or `constant`.
    pub interpolation: Interpolation,
    /// Where colours are mixed: `oklab` is even to the eye, `linear` as light adds up.
    pub mix: MixSpace,
}

impl Default for GradientMap {
    fn default() -> Self {
        let stop = |at, v| Stop { at, color: Srgb8([v; 3]) };
        Self {
            stops: vec![stop(0.0, 0), stop(1.0, 255)],
            interpolation: Interpolation::default(),
            mix: MixSpace::default(),
        }
    }
}

/// More stops than this are not a ramp but an image.
const MOST_STOPS: usize = 64;

impl GradientMap {
    /// The stops' colours in the space where they are mixed.
    fn colors(&self) -> Vec<[f32; 3]> {
        let linear = self.stops.iter().map(|s| LinearRgb::from(s.color).0);
        match self.mix {
            MixSpace::Linear => linear.collect(),
            MixSpace::Oklab => linear.map(linear_to_oklab).collect(),
        }
    }
}

impl Operation for GradientMap {
    const SPEC: Spec = Spec {
        name: "gradient_map",
        category: Category::Color,
        summary: "Colours a scalar by a ramp.",
        inputs: &[InputSpec::plane("value", "", "Place on the ramp, 0 to 1.")],
        outputs: &[OutputSpec::color("color", "The ramp's colour, linear RGB in [0, 1].")],
        ..Spec::FILTER
    };

    fn check(&self) -> Vec<ParamError> {
        let error = |message: String, help: &str| vec![ParamError::new("stops", message, help)];
        if self.stops.is_empty() || self.stops.len() > MOST_STOPS {
            return error(format!("{} stops", self.stops.len()), "write 1 to 64 stops");
        }
        if let Some(stop) = self.stops.iter().find(|s| !(0.0..=1.0).contains(&s.at)) {
            return error(format!("at = {} is out of range", stop.at), "allowed: 0 to 1");
        }
        if let Some(pair) = self.stops.windows(2).find(|w| w[0].at > w[1].at) {
            let message = format!("the stop at {} comes after the one at {}", pair[1].at, pair[0].at);
            return error(message, "sort the stops by `at`");
        }
        Vec::new()
    }

    fn cost_ns(&self) -> f32 {
        let mixed = if self.mix == MixSpace::Oklab { 1.5 } else { 0.0 };
        0.5 + 0.6 * self.stops.len() as f32 + mixed
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let colors = self.colors();
        for y in rows {
            let value = ins.row(0, y);
            let Some([r, g, b]) = outs.color_row(0, y) else { return };
            let [r0, g0, b0] = colors.first().copied().unwrap_or_default();
            r.fill(r0);
            g.fill(g0);
            b.fill(b0);
            for (i, (stop, &from)) in self.stops.iter().zip(&colors).enumerate() {
                // The last stop runs to itself: its colour holds to the end.
                let next = (i + 1).min(colors.len() - 1);
                segment(value, stop.at, self.stops[next].at, from, colors[next], self.interpolation, r, g, b);
            }
            if self.mix == MixSpace::Oklab {
                to_linear(r, g, b);
            }
        }
    }
}

multiversion! {
    /// Write the colours of one segment where the value lies at or above its start.
    fn segment(
        value: &[f32],
        start: f32,
        end: f32,
        from: [f32; 3],
        to: [f32; 3],
        interpolation: Interpolation,
        r: &mut [f32],
        g: &mut [f32],
        b: &mut [f32],
    ) {
        let n = value.len();
        let (r, g, b) = (&mut r[..n], &mut g[..n], &mut b[..n]);
        let (smooth, steps) = (interpolation == Interpolation::Smooth, interpolation == Interpolation::Constant);
        for x in 0..n {
            let v = value[x];
            let t = num::linear_step(start, end, v);
            let t = if smooth { t * t * (3.0 - 2.0 * t) } else { t };
            let t = if steps { 0.0 } else { t };
            let here = v >= start;
            r[x] = if here { num::lerp(from[0], to[0], t) } else { r[x] };
            g[x] = if here { num::lerp(from[1], to[1], t) } else { g[x] };
            b[x] = if here { num::lerp(from[2], to[2], t) } else { b[x] };
        }
    }
}

multiversion! {
    /// Oklab to linear RGB in place; mixes of colours in gamut may leave it by a little and are clamped.
    fn to_linear(r: &mut [f32], g: &mut [f32], b: &mut [f32]) {
        for ((r, g), b) in r.iter_mut().zip(g).zip(b) {
            [*r, *g, *b] = oklab_to_linear([*r, *g, *b]).map(num::saturate);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::color::texel;

    fn ramp(interpolation: Interpolation, mix: MixSpace) -> GradientMap {
        let stops = [(0.0, "#000000"), (0.25, "#9C3B24"), (0.75, "#E8C070"), (1.0, "#ffffff")]
            .map(|(at, c)| Stop { at, color: c.parse().expect("a colour") });
        GradientMap { stops: stops.to_vec(), interpolation, mix }
    }

    fn at(node: &GradientMap, v: f32) -> Vec<f32> {
        texel(node, 0, &[&[v]])
    }

    #[test]
    fn every_stop_has_its_colour_and_the_ends_hold() {
        for mix in [MixSpace::Linear, MixSpace::Oklab] {
            for how in [Interpolation::Linear, Interpolation::Smooth, Interpolation::Constant] {
                let node = ramp(how, mix);
                for stop in &node.stops {
                    let v = at(&node, stop.at);
                    assert_eq!(Srgb8::from(LinearRgb([v[0], v[1], v[2]])), stop.color, "{mix:?} {how:?}");
                }
                assert_eq!(at(&node, -1e30), at(&node, 0.0));
                assert_eq!(at(&node, 1e30), at(&node, 1.0));
            }
        }
    }

    #[test]
    fn between_stops_lies_the_stated_blend() {
        let [a, b] =
            [1, 2].map(|i| LinearRgb::from(ramp(Interpolation::Linear, MixSpace::Linear).stops[i].color).0);
        for (how, v, t) in [
            (Interpolation::Linear, 0.375, 0.25),
            (Interpolation::Smooth, 0.375, 0.156_25),
            (Interpolation::Constant, 0.74, 0.0),
        ] {
            let linear = at(&ramp(how, MixSpace::Linear), v);
            let oklab = at(&ramp(how, MixSpace::Oklab), v);
            let (la, lb) = (linear_to_oklab(a), linear_to_oklab(b));
            let expected = oklab_to_linear([0, 1, 2].map(|k| la[k] + (lb[k] - la[k]) * t));
            for k in 0..3 {
                assert!((linear[k] - (a[k] + (b[k] - a[k]) * t)).abs() < 1e-6, "{how:?}");
                assert!((oklab[k] - expected[k]).abs() < 1e-5, "{how:?}");
            }
        }
    }

    #[test]
    fn two_stops_at_one_place_are_a_hard_edge() {
        let stop = |at, v: u8| Stop { at, color: Srgb8([v; 3]) };
        let stops = vec![stop(0.0, 0), stop(0.5, 0), stop(0.5, 255), stop(1.0, 255)];
        let node = GradientMap { stops, mix: MixSpace::Linear, ..Default::default() };
        assert_eq!((at(&node, 0.499_99)[0], at(&node, 0.5)[0]), (0.0, 1.0));
    }

    #[test]
    fn unsorted_empty_and_wild_stops_are_refused_and_do_no_harm() {
        let mut node = ramp(Interpolation::Linear, MixSpace::Linear);
        assert!(node.check().is_empty());
        node.stops.swap(1, 2);
        assert!(node.check()[0].help.contains("sort"));
        assert!(at(&node, 0.5).iter().all(|v| v.is_finite()));
        node.stops[0].at = f32::NAN;
        assert!(node.check()[0].message.contains("NaN"));
        node.stops.clear();
        assert!(node.check()[0].message.contains("0 stops"));
        assert_eq!(at(&node, 0.5), [0.0; 3]);
    }

    #[test]
    fn settings_survive_a_round_trip() {
        let node = ramp(Interpolation::Smooth, MixSpace::Linear);
        let text = toml::to_string(&node).expect("it is plain data");
        assert!(text.contains("color = \"#9C3B24\""), "{text}");
        assert_eq!(toml::from_str::<GradientMap>(&text), Ok(node));
    }
}
