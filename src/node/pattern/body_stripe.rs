//! A stripe along the body.

use std::ops::Range;

use crate::base::num;
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A stripe along the whole body: one on the mid-back, or a mirrored pair.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BodyStripe {
    /// Where its middle lies, from the mid-back (0) to the belly's middle (0.5); past 0 there are two.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "girth"))]
    pub position: f32,
    /// Its width.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "girth"))]
    pub width: f32,
}

impl Default for BodyStripe {
    fn default() -> Self {
        Self { position: 0.0, width: 0.05 }
    }
}

const DISTORT: usize = 0;
const DU: usize = 1;

impl Operation for BodyStripe {
    const SPEC: Spec = Spec {
        name: "body_stripe",
        category: Category::Pattern,
        summary: "A stripe along the whole body: one on the mid-back, or a mirrored pair.",
        inputs: &[
            InputSpec::drive(
                "distort",
                0.0,
                (-1e6, 1e6),
                "mm",
                "Pushes the edges outward where positive: wire noise for ragged edges.",
            ),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("distance", "mm", "Distance to the nearest edge, positive inside.")],
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        0.6
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let girth_mm = cx.domain.girth_mm;
        for y in rows {
            kernel(
                self.position,
                0.5 * self.width,
                girth_mm,
                ins.row(DISTORT, y),
                ins.row(DU, y),
                outs.only(y),
            );
        }
    }
}

multiversion! {
    fn kernel(position: f32, half: f32, girth_mm: f32, distort: &[f32], du: &[f32], out: &mut [f32]) {
        let n = out.len();
        let texel = 1.0 / n as f32;
        let (distort, du) = (&distort[..n], &du[..n]);
        for i in 0..n {
            let u = (i as f32 + 0.5) * texel + du[i];
            let lateral = num::wrap_half(u - 0.5).abs();
            out[i] = (half - (lateral - position).abs()) * girth_mm + distort[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::eval::run_node;

    #[test]
    fn a_pair_covers_twice_its_width() {
        let stripe = BodyStripe { position: 0.2, width: 0.1 };
        let p = &run_node(&stripe, &Domain::square(200), 1, &[], &Default::default(), 0)[0];
        let inside = p.row(3).iter().filter(|&&d| d > 0.0).count();
        assert_eq!(inside, 40);
    }
}
