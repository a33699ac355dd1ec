//! A round gradient.

use std::ops::Range;

use super::shape;
use crate::base::{num, sdf};
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A round gradient: 1 at its centre, 0 at its rim and beyond.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RadialGradient {
    /// Place of the centre around the body; 0.5 is the middle of the back.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_u: f32,
    /// Place of the centre along the body.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_v: f32,
    /// How it falls from the centre to the rim.
    pub falloff: Falloff,
}

/// How a round gradient falls from 1 at the centre to 0 at the rim; t is the distance from 0 to 1.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// A cone: 1 - t.
    #[default]
    Linear,
    /// A bell without an edge at the centre or the rim: the cubic step.
    Smooth,
    /// A bowl upside down: 1 - t².
    Paraboloid,
    /// Half a sphere: sqrt(1 - t²).
    Dome,
}

impl Default for RadialGradient {
    fn default() -> Self {
        Self { center_u: 0.5, center_v: 0.5, falloff: Falloff::Linear }
    }
}

const SIZE: usize = 0;
const DU: usize = 1;

impl Operation for RadialGradient {
    const SPEC: Spec = Spec {
        name: "radial_gradient",
        summary: "A round gradient: 1 at its centre, 0 at its rim.",
        inputs: &[shape::size("size", 1.0, "Diameter of the rim."), OFFSETS[0], OFFSETS[1]],
        outputs: &[
            OutputSpec::scalar("value", "", "The gradient, 1 at the centre to 0."),
            OutputSpec::scalar("distance", "mm", "Distance from the nearest centre."),
        ],
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        1.5
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let n = domain.width;
        let mut buffers: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; n]);
        let [x, y, distance] = &mut buffers;
        for row in rows {
            shape::place(ins.row(DU, row), 0.0, 1.0 / n as f32, self.center_u, domain.girth_mm, x);
            shape::place(ins.row(DU + 1, row), domain.v(row), 0.0, self.center_v, domain.length_mm, y);
            lengths(x, y, distance);
            if let Some(value) = outs.row(0, row) {
                kernel(distance, ins.row(SIZE, row), 0.5 * domain.shorter_mm(), self.falloff, value);
            }
            if let Some(out) = outs.row(1, row) {
                out.copy_from_slice(distance);
            }
        }
    }
}

multiversion! {
    fn lengths(x: &[f32], y: &[f32], out: &mut [f32]) {
        for ((out, x), y) in out.iter_mut().zip(x).zip(y) {
            *out = sdf::length(*x, *y);
        }
    }
}

multiversion! {
    fn kernel(distance: &[f32], size: &[f32], half_mm: f32, falloff: Falloff, out: &mut [f32]) {
        for ((out, distance), size) in out.iter_mut().zip(distance).zip(size) {
            let radius = shape::half(*size, half_mm);
            // A gradient of no size is 0 everywhere.
            let t = if radius > 0.0 { (distance / radius.max(f32::MIN_POSITIVE)).min(1.0) } else { 1.0 };
            *out = match falloff {
                Falloff::Linear => 1.0 - t,
                Falloff::Smooth => 1.0 - t * t * (3.0 - 2.0 * t),
                Falloff::Paraboloid => 1.0 - t * t,
                Falloff::Dome => num::safe_sqrt(1.0 - t * t),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    #[test]
    fn a_cone_has_a_third_of_its_cylinder() {
        let domain = Domain { width: 150, height: 300, girth_mm: 50.0, length_mm: 100.0 };
        for (falloff, mean) in [
            (Falloff::Linear, 1.0 / 3.0),
            (Falloff::Paraboloid, 1.0 / 2.0),
            (Falloff::Dome, 2.0 / 3.0),
            (Falloff::Smooth, 0.3),
        ] {
            // Across the corner: the gradient goes on behind both seams.
            let node = RadialGradient { falloff, center_u: 0.0, center_v: 0.0 };
            let out = &run_node(&node, &domain, 1, &[Input::Value(0.8)], &Assets::new(), 0)[0];
            let expected = mean * std::f64::consts::PI * 0.4 * 0.4 / 2.0;
            assert!((num::mean(out.data()) - expected).abs() < 2e-4, "{falloff:?}");
        }
    }

    #[test]
    fn no_size_is_nothing() {
        let out = run_node(
            &RadialGradient::default(),
            &Domain::square(1),
            1,
            &[Input::Value(0.0)],
            &Assets::new(),
            0,
        );
        assert_eq!(out[0].data(), &[0.0]);
    }
}
