//! Edge detection by the gradient.

use std::ops::Range;

use super::finite;
use super::separable::pad_row;
use crate::base::Domain;
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// The 3x3 weights that estimate the gradient.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Operator {
    /// Weights 1 2 1 across the difference: smoother.
    Sobel,
    /// Weights 3 10 3: least dependent on the direction of the edge.
    #[default]
    Scharr,
}

/// What the gradient is measured in.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Change of value over `width`, `strength` limited to 1.
    #[default]
    Normalised,
    /// Change of value per mm, not limited.
    PerMm,
}

/// How steeply the image changes.
///
/// Smooth images give the same slope at any resolution. A hard edge is one texel wide, so its slope grows with the
/// resolution: blur it first, or use `outline`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EdgeDetect {
    /// The 3x3 weights that estimate the gradient.
    pub operator: Operator,
    /// What the gradient is measured in.
    pub measure: Measure,
    /// Strengthens the result: the distance over which a change of 1 counts as 1, as a fraction of the tile's shorter
    /// side; only with `measure = "normalised"`; 0.01.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub width: f32,
}

impl Default for EdgeDetect {
    fn default() -> Self {
        Self { operator: Operator::default(), measure: Measure::default(), width: 0.01 }
    }
}

/// Values are limited to this, so that sums and squares stay finite.
const LIMIT: f32 = 1e18;

const STRENGTH: usize = 0;
const SLOPE_U: usize = 1;
const SLOPE_V: usize = 2;

impl Operation for EdgeDetect {
    const SPEC: Spec = Spec {
        name: "edge_detect",
        summary: "Finds edges: how steeply the image changes.",
        inputs: &[InputSpec::image("image", "Where edges are looked for.")],
        outputs: &[
            OutputSpec::same("strength", "Length of the gradient; in [0, 1] if normalised, else per mm."),
            OutputSpec::same("slope_u", "Change around the body, signed, in the same measure, not limited."),
            OutputSpec::same("slope_v", "Change tail-ward, signed, in the same measure, not limited."),
        ],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Around { x: 1, y: 1 }
    }

    fn cost_ns(&self) -> f32 {
        2.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let (side, middle) = match self.operator {
            Operator::Sobel => (0.125, 0.25),
            Operator::Scharr => (3.0 / 32.0, 10.0 / 32.0),
        };
        let (scale, limit) = match self.measure {
            Measure::Normalised => (self.width * cx.domain.shorter_mm(), 1.0),
            Measure::PerMm => (1.0, f32::MAX),
        };
        let per_u = scale / cx.domain.texel_u_mm();
        let per_v = scale / cx.domain.texel_v_mm();
        let mut near = [vec![], vec![], vec![]];
        let mut slope = [vec![0.0; outs.width()], vec![0.0; outs.width()]];
        for y in rows {
            for (k, row) in near.iter_mut().enumerate() {
                pad_row(ins.row(0, y + k as i64 - 1), 1, 1, row);
                limit_values(row);
            }
            let [u, v] = &mut slope;
            gradient(&near[0], &near[1], &near[2], side, middle, per_u, per_v, u, v);
            if let Some(out) = outs.row(STRENGTH, y) {
                length(u, v, limit, out);
            }
            for (output, slope) in [(SLOPE_U, u), (SLOPE_V, v)] {
                if let Some(out) = outs.row(output, y) {
                    out.copy_from_slice(slope);
                }
            }
        }
    }
}

multiversion! {
    fn limit_values(row: &mut [f32]) {
        for v in row { *v = v.max(-LIMIT).min(LIMIT); }
    }
}

multiversion! {
    // Rows padded by one texel at each end.
    fn gradient(
        above: &[f32], here: &[f32], below: &[f32], side: f32, middle: f32, per_u: f32, per_v: f32,
        u: &mut [f32], v: &mut [f32],
    ) {
        let n = u.len();
        let v = &mut v[..n];
        let (al, am, ar) = (&above[..n], &above[1..n + 1], &above[2..n + 2]);
        let (hl, hr) = (&here[..n], &here[2..n + 2]);
        let (bl, bm, br) = (&below[..n], &below[1..n + 1], &below[2..n + 2]);
        for i in 0..n {
            let du = side * ((ar[i] - al[i]) + (br[i] - bl[i])) + middle * (hr[i] - hl[i]);
            let dv = side * ((bl[i] - al[i]) + (br[i] - ar[i])) + middle * (bm[i] - am[i]);
            u[i] = finite(du * per_u);
            v[i] = finite(dv * per_v);
        }
    }
}

multiversion! {
    fn length(u: &[f32], v: &[f32], limit: f32, out: &mut [f32]) {
        for ((o, u), v) in out.iter_mut().zip(u).zip(v) {
            *o = (*u * *u + *v * *v).sqrt().min(limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_bands_agree, assert_finite, assert_shifts_along, grid, noise};
    use super::*;
    use crate::base::Plane;
    use crate::eval::{Input::Plane as P, run_node};
    use crate::node::Assets;

    /// A ramp of 0.5 and -0.25 per mm on a grid whose texels are 2 mm x 3 mm, away from its seams.
    #[test]
    fn a_ramp_has_its_slope_in_mm() {
        let d = Domain { width: 12, height: 9, girth_mm: 24.0, length_mm: 27.0 };
        let ramp = Plane::from_fn(12, 9, |x, y| 0.5 * 2.0 * x as f32 - 0.25 * 3.0 * y as f32);
        for operator in [Operator::Sobel, Operator::Scharr] {
            let node = EdgeDetect { operator, measure: Measure::PerMm, width: 0.0 };
            let out = run_node(&node, &d, 1, &[P(&ramp)], &Assets::new(), 0);
            for (plane, expected) in out.iter().zip([(0.25f32 + 0.0625).sqrt(), 0.5, -0.25]) {
                assert!((plane.at(5, 4) - expected).abs() < 1e-5, "{operator:?}");
            }
        }
    }

    #[test]
    fn normalised_counts_the_change_over_the_width_up_to_1() {
        let ramp = Plane::from_fn(40, 40, |x, _| 0.1 * x as f32);
        let at = |width| {
            let node = EdgeDetect { width, ..EdgeDetect::default() };
            run_node(&node, &grid(40, 40), 1, &[P(&ramp)], &Assets::new(), 0)[0].at(20, 20)
        };
        assert!((at(0.1) - 0.4).abs() < 1e-5);
        assert_eq!((at(0.0), at(1.0)), (0.0, 1.0));
    }

    #[test]
    fn bands_agree_the_torus_has_no_seam_and_all_is_finite() {
        let a = noise(19, 11, 1);
        for measure in [Measure::Normalised, Measure::PerMm] {
            let node = EdgeDetect { measure, ..EdgeDetect::default() };
            assert_bands_agree(&node, &grid(19, 11), &[P(&a)]);
            assert_shifts_along(&node, &grid(19, 11), &a, &[]);
            assert_finite(&node, &[]);
        }
    }
}
