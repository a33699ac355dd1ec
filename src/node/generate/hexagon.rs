//! A hexagon.

use std::ops::Range;

use super::shape::{self, ROTATION, Shape};
use crate::base::sdf;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, Outputs, Spec};

/// A hexagon with two straight sides along the body and a tip at each end; regular where `width` is 0.866 `length` and
/// `shoulder` is 0.5.
///
/// Its images continue over the seams. Sizes are fractions of the tile's shorter side.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Hexagon {
    /// Part of the length where the sides are straight: 0 is a rhombus, 0.5 regular, 0.9 nearly a rectangle.
    #[schemars(range(min = 0.0, max = 0.99))]
    pub shoulder: f32,
    /// Place of the centre around the body; 0.5 is the middle of the back.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_u: f32,
    /// Place of the centre along the body.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_v: f32,
    /// How round the corners are: 0 sharp, 0.2 worn, 1 as round as the shape allows.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub rounding: f32,
    /// Width of the edge from 0 to 1; 0 is as sharp as the texels allow, 0.02 is soft.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub softness: f32,
}

impl Default for Hexagon {
    fn default() -> Self {
        Self { shoulder: 0.5, center_u: 0.5, center_v: 0.5, rounding: 0.0, softness: 0.0 }
    }
}

impl Operation for Hexagon {
    const SPEC: Spec = Spec {
        name: "hexagon",
        summary: "A hexagon with tips along the body, regular or stretched.",
        inputs: &[
            shape::size("width", 0.433, "From one straight side to the other."),
            shape::size("length", 0.5, "From tip to tip."),
            ROTATION,
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: shape::OUTPUTS,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        5.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        Shape {
            center_u: self.center_u,
            center_v: self.center_v,
            softness: self.softness,
            sizes: [0, 1],
            rotation: Some(2),
            offsets: 3,
            kernel,
            k: [self.rounding, self.shoulder.min(0.99), 0.0, 0.0],
        }
        .paint(cx, rows, ins, outs);
    }
}

shape::kernel!(kernel, |x, y, a, b, k| {
    // The rhombus that the sloping sides continue to, cut at the straight sides.
    let hx = a / (1.0 - k[1]);
    let inner = sdf::rhombus_inradius(hx, b).min(a);
    sdf::rounded_truncated_rhombus(x, y, hx, b, a, b, k[0] * inner)
});
