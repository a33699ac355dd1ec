//! Curve: values through a drawn function.

use std::ops::Range;

use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, ParamError, Prepared, Spec};

/// How a curve runs between its points.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Smooth, and rising or falling wherever the points do: no overshoot.
    #[default]
    Monotone,
    /// Straight lines.
    Linear,
}

/// Each value is looked up on a curve through the given points; flat before the first and after the last.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Curve {
    /// What the curve goes through: `[x, y]` pairs with rising x, 1 to 64 of them; `[[0, 0], [1, 1]]` changes nothing.
    pub points: Vec<[f32; 2]>,
    /// How the curve runs between the points.
    pub interpolation: Interpolation,
}

impl Default for Curve {
    fn default() -> Self {
        Self { points: vec![[0.0, 0.0], [1.0, 1.0]], interpolation: Interpolation::default() }
    }
}

/// Most points that are accepted.
const MAX_POINTS: usize = 64;
/// Greatest coordinate of a point.
const MAX_VALUE: f32 = 1e6;
/// Least distance of two points in x.
const MIN_STEP: f32 = 1e-6;

/// A cubic in `x - start`, valid over `length`.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start: f32,
    length: f32,
    c: [f32; 4],
}

impl Operation for Curve {
    const SPEC: Spec = Spec {
        name: "curve",
        summary: "Looks each value up on a curve through given points.",
        inputs: &[InputSpec::image("image", "What is looked up.")],
        outputs: &[OutputSpec::same("result", "The curve's values.")],
        ..Spec::FILTER
    };

    fn check(&self) -> Vec<ParamError> {
        let mut errors = Vec::new();
        let mut error = |message: String, help: &str| errors.push(ParamError::new("points", message, help));
        if self.points.is_empty() || self.points.len() > MAX_POINTS {
            error(format!("points has {} entries", self.points.len()), "give 1 to 64 points");
        }
        if self.points.iter().flatten().any(|v| v.abs() > MAX_VALUE) {
            error("a point lies outside -1e6 to 1e6".into(), "give smaller values");
        }
        if let Some(w) = self.points.windows(2).find(|w| w[1][0] - w[0][0] < MIN_STEP) {
            let message = format!("x of points does not rise from {} to {}", w[0][0], w[1][0]);
            error(message, "order the points by x, at least 1e-6 apart; for a step use `threshold`");
        }
        errors
    }

    fn cost_ns(&self) -> f32 {
        0.5 * self.points.len() as f32
    }

    fn prepare(&self, _: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(pieces(&self.points, self.interpolation)))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let pieces: &Vec<Piece> = cx.prepared();
        for y in rows {
            let (image, out) = (ins.row(0, y), outs.only(y));
            out.fill(pieces[0].c[0]);
            for p in pieces {
                kernel(p.start, p.length, &p.c, image, out);
            }
        }
    }
}

/// The curve's cubics in order of x; the last has no length and holds the last value.
///
/// Tangents are the weighted harmonic means of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984), which keep
/// the cubics monotone; at the ends the slope of the segment.
fn pieces(points: &[[f32; 2]], interpolation: Interpolation) -> Vec<Piece> {
    let flat = |[x, y]: [f32; 2]| Piece { start: x, length: 0.0, c: [y, 0.0, 0.0, 0.0] };
    let n = points.len();
    let at = |i: usize| points[i].map(f64::from);
    // Points that the check refuses still give numbers.
    let step = |i: usize| (at(i + 1)[0] - at(i)[0]).max(f64::from(MIN_STEP));
    let slope = |i: usize| (at(i + 1)[1] - at(i)[1]) / step(i);
    let tangent = |i: usize| {
        if i == 0 {
            return slope(0);
        }
        if i == n - 1 {
            return slope(n - 2);
        }
        let (a, b) = (slope(i - 1), slope(i));
        let (ha, hb) = (step(i - 1), step(i));
        if a * b <= 0.0 { 0.0 } else { 3.0 * (ha + hb) / ((2.0 * hb + ha) / a + (hb + 2.0 * ha) / b) }
    };
    let mut pieces = Vec::with_capacity(n.max(1));
    for i in 0..n.saturating_sub(1) {
        let (h, d) = (step(i), slope(i));
        let (m0, m1) = match interpolation {
            Interpolation::Monotone => (tangent(i), tangent(i + 1)),
            Interpolation::Linear => (d, d),
        };
        let c = [at(i)[1], m0, (3.0 * d - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * d) / (h * h)];
        pieces.push(Piece { start: points[i][0], length: h as f32, c: c.map(|c| c as f32) });
    }
    pieces.push(points.last().map_or(flat([0.0, 0.0]), |&last| flat(last)));
    pieces
}

multiversion! {
    fn kernel(start: f32, length: f32, c: &[f32; 4], image: &[f32], out: &mut [f32]) {
        for (o, x) in out.iter_mut().zip(image) {
            let t = (*x - start).max(0.0).min(length);
            let v = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
            *o = if *x >= start { v } else { *o };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_bands_agree, assert_finite, grid, noise, run, square};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::Plane as P;
    use crate::node::Node;

    fn curve(points: &[[f32; 2]], interpolation: Interpolation) -> Curve {
        Curve { points: points.to_vec(), interpolation }
    }

    /// The curve at `n` equal steps over [-0.5, 1.5].
    fn sampled(node: &Curve, n: usize) -> Vec<f32> {
        let x = Plane::from_fn(n, 1, |i, _| -0.5 + 2.0 * i as f32 / (n - 1) as f32);
        run(node, &grid(n, 1), &[P(&x)]).into_vec()
    }

    #[test]
    fn the_default_is_the_identity_on_0_1_and_flat_outside() {
        let a = noise(9, 9, 1);
        assert!(run(&Curve::default(), &square(9), &[P(&a)]) == a);
        let s = sampled(&Curve::default(), 101);
        assert_eq!((s[0], s[100]), (0.0, 1.0));
    }

    #[test]
    fn both_kinds_go_through_the_points_and_linear_is_halfway_between() {
        let points = [[-0.25, 0.3], [0.25, 1.0], [0.5, 1.0], [1.25, -2.0]];
        let x = Plane::from_vec(5, 1, vec![-0.25, 0.25, 0.5, 1.25, 0.0]);
        for kind in [Interpolation::Monotone, Interpolation::Linear] {
            let out = run(&curve(&points, kind), &grid(5, 1), &[P(&x)]);
            for (o, p) in out.data().iter().zip(points) {
                assert_eq!(*o, p[1]);
            }
            if kind == Interpolation::Linear {
                assert!((out.data()[4] - 0.65).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn monotone_points_give_a_monotone_curve_without_jumps() {
        let steep = [[0.0, 0.0], [0.1, 0.01], [0.12, 0.9], [0.7, 0.91], [1.0, 1.0]];
        let s = sampled(&curve(&steep, Interpolation::Monotone), 4001);
        assert!(s.windows(2).all(|w| w[1] - w[0] >= -1e-6 && w[1] - w[0] < 0.05));
    }

    #[test]
    fn bad_points_are_refused_and_still_give_numbers() {
        for bad in [vec![], vec![[1.0, 0.0], [0.0, 1.0]], vec![[0.0, 0.0], [0.0, 1.0]], vec![[1e30, 1.0]]] {
            let node = Curve { points: bad, ..Curve::default() };
            assert_eq!(Node::check(&node).len(), 1, "{node:?}");
            assert_finite(&node, &[]);
        }
        assert_finite(&Curve::default(), &[]);
        assert_bands_agree(&Curve::default(), &square(9), &[P(&noise(9, 9, 1))]);
    }
}
