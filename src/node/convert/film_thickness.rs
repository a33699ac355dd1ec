//! Thickness of the iridescent film on the scales.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, ParamError, Spec};

/// Composes the thickness of the iridescent film, nm, from what varies over a scale and between scales:
///
/// `film = clamp(base + vertical * t + radial * radius + noise_amount * noise + random_amount * (2 random - 1), min,
/// max)`, then `thickness = skin + mask * (film - skin)`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmThickness {
    /// Keeps the film from getting thinner; 0 lets it vanish, 150 keeps it above the first blue.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-unit" = "nm"))]
    pub min: f32,
    /// Keeps the film from getting thicker; above 1000 the orders blend to grey.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-unit" = "nm"))]
    pub max: f32,
}

impl Default for FilmThickness {
    fn default() -> Self {
        Self { min: 0.0, max: 1200.0 }
    }
}

/// Amounts: how far each part may move the thickness.
const AMOUNT: (f32, f32) = (-10_000.0, 10_000.0);

impl Operation for FilmThickness {
    const SPEC: Spec = Spec {
        name: "film_thickness",
        category: Category::Convert,
        summary: "Composes the thickness of the iridescent film from gradients over each scale, noise and chance.",
        inputs: &[
            InputSpec::drive(
                "base",
                300.0,
                (0.0, 10_000.0),
                "nm",
                "Thickness where nothing else adds to it: 250 is blue to violet, 330 green, 400 red, 0 none.",
            ),
            InputSpec::drive(
                "vertical",
                0.0,
                AMOUNT,
                "nm",
                "What the film gains from `t` = 0 to `t` = 1: the colour runs along each scale.",
            ),
            InputSpec::drive(
                "t",
                0.0,
                (-1.0, 1.0),
                "",
                "Place along the scale: wire `t` of `scale_lattice`.",
            ),
            InputSpec::drive(
                "radial",
                0.0,
                AMOUNT,
                "nm",
                "What the film gains from `radius` = 0 to `radius` = 1: rings of colour on each scale.",
            ),
            InputSpec::drive(
                "radius",
                0.0,
                (0.0, 1.0),
                "",
                "Distance from the scale's centre: 0 centre, 1 outline.",
            ),
            InputSpec::drive(
                "noise_amount",
                0.0,
                AMOUNT,
                "nm",
                "What the film gains where `noise` is 1: 20 to 60 breaks up the colour.",
            ),
            InputSpec::drive("noise", 0.0, (-1.0, 1.0), "", "Noise, about 0."),
            InputSpec::drive(
                "random_amount",
                0.0,
                AMOUNT,
                "nm",
                "How much thinner or thicker whole scales are: 10 to 40.",
            ),
            InputSpec::drive(
                "random",
                0.5,
                (0.0, 1.0),
                "",
                "One number a scale; 0.5 is neither thinner nor thicker.",
            ),
            InputSpec::drive(
                "mask",
                1.0,
                (0.0, 1.0),
                "",
                "Where there is a film: 1 on scales, 0 on the skin between them; clamped.",
            ),
            InputSpec::drive("skin", 0.0, (0.0, 10_000.0), "nm", "Thickness where the mask is 0."),
        ],
        outputs: &[OutputSpec::scalar("thickness", "nm", "Thickness of the film, 0 is none.")],
        ..Spec::FILTER
    };

    fn check(&self) -> Vec<ParamError> {
        if self.min <= self.max {
            return Vec::new();
        }
        vec![ParamError::new(
            "min",
            format!("min = {} nm is above max = {} nm", self.min, self.max),
            "swap them",
        )]
    }

    fn cost_ns(&self) -> f32 {
        1.0
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let out = outs.only(y);
            out.copy_from_slice(ins.row(0, y));
            // Amount and variable of each part stand side by side: vertical, radial, noise.
            for part in [1, 3, 5] {
                add_part(ins.row(part, y), ins.row(part + 1, y), 0.0, 1.0, out);
            }
            add_part(ins.row(7, y), ins.row(8, y), -1.0, 2.0, out);
            finish(ins.row(9, y), ins.row(10, y), self.min, self.max, out);
        }
    }
}

/// More than any film, little enough that no sum of parts overflows.
const LIMIT: f32 = 1e30;

multiversion! {
    /// `out += amount * (offset + scale * variable)`.
    fn add_part(amount: &[f32], variable: &[f32], offset: f32, scale: f32, out: &mut [f32]) {
        for ((o, a), v) in out.iter_mut().zip(amount).zip(variable) {
            let part = a.max(-LIMIT).min(LIMIT) * (offset + scale * v.max(-LIMIT).min(LIMIT));
            *o += part.max(-LIMIT).min(LIMIT);
        }
    }
}

multiversion! {
    /// Clamp to the range and lay it where the mask is.
    fn finish(mask: &[f32], skin: &[f32], min: f32, max: f32, out: &mut [f32]) {
        for ((o, m), s) in out.iter_mut().zip(mask).zip(skin) {
            let m = num::saturate(*m);
            *o = s * (1.0 - m) + o.max(min).min(max) * m;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(node: &FilmThickness, values: [f32; 11]) -> f32 {
        let inputs: Vec<_> = values.iter().map(|&v| Input::Value(v)).collect();
        run_node(node, &Domain::square(1), 0, &inputs, &Assets::new(), 0)[0].at(0, 0)
    }

    /// base, vertical, t, radial, radius, noise amount, noise, random amount, random, mask, skin.
    const ALL: [f32; 11] = [300.0, 100.0, 0.5, -40.0, 0.25, 60.0, -0.5, 20.0, 0.75, 1.0, 7.0];

    #[test]
    fn the_parts_add_up() {
        // 300 + 50 - 10 - 30 + 10
        assert!((run(&FilmThickness::default(), ALL) - 320.0).abs() < 1e-3);
    }

    #[test]
    fn the_range_holds_and_the_skin_lies_outside_it() {
        let node = FilmThickness { min: 310.0, max: 315.0 };
        assert_eq!(run(&node, ALL), 315.0);
        let mut values = ALL;
        values[1] = -1000.0;
        assert_eq!(run(&node, values), 310.0);
        values[9] = 0.0;
        assert_eq!(run(&node, values), 7.0);
        values[9] = 0.5;
        assert_eq!(run(&node, values), 158.5);
    }

    #[test]
    fn nothing_wired_is_the_base() {
        let p = Plane::filled(1, 1, 250.0);
        let out = run_node(
            &FilmThickness::default(),
            &Domain::square(1),
            0,
            &[Input::Plane(&p)],
            &Assets::new(),
            0,
        );
        assert_eq!(out[0].at(0, 0), 250.0);
    }

    #[test]
    fn huge_parts_stay_in_range() {
        for v in [1e30, -1e30, f32::MAX, -f32::MAX, 1e-40] {
            let mut values = [v; 11];
            values[10] = 0.0;
            assert!((0.0..=1200.0).contains(&run(&FilmThickness::default(), values)), "{v}");
        }
    }

    #[test]
    fn a_turned_range_is_refused() {
        assert_eq!(FilmThickness { min: 2.0, max: 1.0 }.check()[0].key, "min");
    }
}
