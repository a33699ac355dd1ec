//! A regular polygon.

use std::ops::Range;

use super::shape::{self, ROTATION, Shape};
use crate::base::{num, sdf};
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, Outputs, Spec};

/// A regular polygon with a corner towards the head (v = 0) at rotation 0.
///
/// Its images continue over the seams. Sizes are fractions of the tile's shorter side.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polygon {
    /// Number of sides.
    #[schemars(range(min = 3, max = 64))]
    pub sides: u32,
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

impl Default for Polygon {
    fn default() -> Self {
        Self { sides: 5, center_u: 0.5, center_v: 0.5, rounding: 0.0, softness: 0.0 }
    }
}

impl Operation for Polygon {
    const SPEC: Spec = Spec {
        name: "polygon",
        summary: "A regular polygon with 3 to 64 sides.",
        inputs: &[
            shape::size("size", 0.5, "Diameter of the circle through the corners."),
            ROTATION,
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: shape::OUTPUTS,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        25.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let n = self.sides.clamp(3, 64) as f32;
        Shape {
            center_u: self.center_u,
            center_v: self.center_v,
            softness: self.softness,
            sizes: [0, 0],
            rotation: Some(1),
            offsets: 2,
            kernel,
            k: [self.rounding, n, sdf::polygon_tan(n), num::cos_turns(0.5 / n)],
        }
        .paint(cx, rows, ins, outs);
    }
}

shape::kernel!(kernel, |x, y, a, _b, k| {
    // A turned frame: the first corner, not the first side, points to -v.
    let apothem = a * k[3];
    let r = k[0] * apothem;
    let (x, y) = sdf::turn(-y, x, k[3], k[2] * k[3]);
    sdf::polygon(x, y, k[1], k[2], apothem - r) - r
});
