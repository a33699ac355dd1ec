//! Translucency from the thickness of the tissue under the surface.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// Share of light that passes the tissue unscattered, by Beer and Lambert:
/// `exp(-max(height - base, 0) / mean_free_path)`. Thin skin and scale tips glow, thick scale bodies do not.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightToTranslucency {}

const HEIGHT: usize = 0;
const BASE: usize = 1;
const MEAN_FREE_PATH: usize = 2;

impl Operation for HeightToTranslucency {
    const SPEC: Spec = Spec {
        name: "height_to_translucency",
        category: Category::Convert,
        summary: "Makes translucency from a height: thin lets light through, thick does not.",
        inputs: &[
            InputSpec::plane("height", "mm", "Height of the surface."),
            InputSpec::drive(
                "base",
                0.0,
                (-100.0, 100.0),
                "mm",
                "Height at which the tissue is nothing thick; lower it to darken all, at or above the surface is 1.",
            ),
            InputSpec::drive(
                "mean_free_path",
                0.3,
                (0.0, 100.0),
                "mm",
                "How deep light goes before it falls to 37 %: 0.1 is horn, 1 is thin skin, 0 is opaque.",
            ),
        ],
        outputs: &[OutputSpec::scalar("translucency", "", "0 opaque to 1 nothing in the way.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        1.9
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            kernel(ins.row(HEIGHT, y), ins.row(BASE, y), ins.row(MEAN_FREE_PATH, y), outs.only(y));
        }
    }
}

multiversion! {
    fn kernel(height: &[f32], base: &[f32], path: &[f32], out: &mut [f32]) {
        for (((o, h), b), p) in out.iter_mut().zip(height).zip(base).zip(path) {
            let thickness = (h - b).max(0.0);
            // A path of 0 keeps both limits: 1 where there is no tissue, 0 elsewhere.
            let depth = thickness / p.max(1e-30);
            *o = if depth > 80.0 { 0.0 } else { num::exp(-depth) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(height: f32, base: f32, path: f32) -> f32 {
        let h = Plane::filled(1, 1, height);
        let inputs = [Input::Plane(&h), Input::Value(base), Input::Value(path)];
        run_node(&HeightToTranslucency::default(), &Domain::square(1), 0, &inputs, &Assets::new(), 0)[0]
            .at(0, 0)
    }

    #[test]
    fn it_is_beer_and_lambert() {
        for (h, base, path) in [(0.3, 0.0, 0.3), (1.0, 0.5, 0.2), (0.0, -0.6, 0.3)] {
            let expected = (-f64::from(h - base) / f64::from(path)).exp();
            assert!((f64::from(run(h, base, path)) / expected - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn limits_hold() {
        assert_eq!(run(0.0, 0.0, 0.3), 1.0);
        assert_eq!(run(-5.0, 0.0, 0.3), 1.0);
        assert_eq!(run(0.0, 0.0, 0.0), 1.0);
        assert_eq!(run(1e-6, 0.0, 0.0), 0.0);
        assert_eq!(run(1e30, 0.0, 0.3), 0.0);
        assert_eq!(run(f32::MAX, -f32::MAX, 1e-40), 0.0);
    }
}
