//! An ellipse.

use std::ops::Range;

use super::shape::{self, ROTATION, Shape};
use crate::base::sdf;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, Inputs, Operation, Outputs, Spec};

/// An ellipse; its distance is exact, not the usual estimate.
///
/// Its images continue over the seams. Sizes are fractions of the tile's shorter side.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ellipse {
    /// Place of the centre around the body; 0.5 is the middle of the back.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_u: f32,
    /// Place of the centre along the body.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_v: f32,
    /// Width of the edge from 0 to 1; 0 is as sharp as the texels allow, 0.02 is soft.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub softness: f32,
}

impl Default for Ellipse {
    fn default() -> Self {
        Self { center_u: 0.5, center_v: 0.5, softness: 0.0 }
    }
}

impl Operation for Ellipse {
    const SPEC: Spec = Spec {
        name: "ellipse",
        summary: "An ellipse.",
        inputs: &[
            shape::size("width", 0.6, "Diameter around the body before it is turned."),
            shape::size("height", 0.3, "Diameter along the body before it is turned."),
            ROTATION,
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: shape::OUTPUTS,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        30.0
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
            k: [0.0, 0.0, 0.0, 0.0],
        }
        .paint(cx, rows, ins, outs);
    }
}

shape::kernel!(kernel, |x, y, a, b, _k| sdf::ellipse(x, y, a, b));
