//! Threshold: a mask of what lies above a level.

use std::ops::Range;

use super::separable::pad_row;
use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// How the edge of the mask looks.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Edge {
    /// 0 or 1, with steps along slanted edges.
    Hard,
    /// About one texel wide at any resolution, from the slope of the image.
    #[default]
    Antialiased,
    /// A ramp over `softness` of the image's own values.
    Soft,
}

/// 1 where the image is at or above `level`, 0 below.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Threshold {
    /// How the edge of the mask looks.
    pub edge: Edge,
}

const IMAGE: usize = 0;
const LEVEL: usize = 1;
const SOFTNESS: usize = 2;

/// Where squares of differences stay finite.
const LIMIT: f32 = 1e18;

impl Operation for Threshold {
    const SPEC: Spec = Spec {
        name: "threshold",
        summary: "Makes a mask of what is at or above a level.",
        inputs: &[
            InputSpec::image("image", "What is compared."),
            InputSpec::drive("level", 0.5, (-1e6, 1e6), "", "Lets less through the higher it is."),
            InputSpec::drive(
                "softness",
                0.1,
                (0.0, 1e6),
                "",
                "Width of the ramp around `level`, in the image's values; only with `edge = \"soft\"`; 0 is hard.",
            ),
        ],
        outputs: &[OutputSpec::same("mask", "The mask, in [0, 1].")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        match self.edge {
            Edge::Antialiased => Reach::Around { x: 1, y: 1 },
            Edge::Hard | Edge::Soft => Reach::Point,
        }
    }

    fn cost_ns(&self) -> f32 {
        if self.edge == Edge::Antialiased { 2.0 } else { 0.5 }
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let mut over = [vec![], vec![], vec![]];
        let (mut image, mut level) = (vec![], vec![]);
        for y in rows {
            match self.edge {
                Edge::Hard => hard(ins.row(IMAGE, y), ins.row(LEVEL, y), outs.only(y)),
                Edge::Soft => {
                    soft(ins.row(IMAGE, y), ins.row(LEVEL, y), ins.row(SOFTNESS, y), outs.only(y));
                }
                Edge::Antialiased => {
                    for (k, over) in over.iter_mut().enumerate() {
                        let y = y + k as i64 - 1;
                        pad_row(ins.row(IMAGE, y), 1, 1, &mut image);
                        pad_row(ins.row(LEVEL, y), 1, 1, &mut level);
                        over.resize(image.len(), 0.0);
                        excess(&image, &level, over);
                    }
                    antialiased(&over[0], &over[1], &over[2], outs.only(y));
                }
            }
        }
    }
}

multiversion! {
    fn hard(image: &[f32], level: &[f32], out: &mut [f32]) {
        for ((o, x), l) in out.iter_mut().zip(image).zip(level) {
            *o = if *x >= *l { 1.0 } else { 0.0 };
        }
    }
}

multiversion! {
    fn soft(image: &[f32], level: &[f32], softness: &[f32], out: &mut [f32]) {
        for (((o, x), l), s) in out.iter_mut().zip(image).zip(level).zip(softness) {
            let half = 0.5 * s.max(0.0);
            *o = num::linear_step(*l - half, *l + half, *x);
        }
    }
}

multiversion! {
    fn excess(image: &[f32], level: &[f32], out: &mut [f32]) {
        for ((o, x), l) in out.iter_mut().zip(image).zip(level) {
            *o = (*x - *l).max(-LIMIT).min(LIMIT);
        }
    }
}

multiversion! {
    // Rows of image - level, padded by one texel at each end.
    fn antialiased(above: &[f32], here: &[f32], below: &[f32], out: &mut [f32]) {
        let n = out.len();
        let (up, down) = (&above[1..n + 1], &below[1..n + 1]);
        let (left, mid, right) = (&here[..n], &here[1..n + 1], &here[2..n + 2]);
        for i in 0..n {
            let (gx, gy) = (0.5 * (right[i] - left[i]), 0.5 * (down[i] - up[i]));
            let g = (gx * gx + gy * gy).sqrt();
            // Distance to the level line in texels, to first order, is mid / g: its coverage of a texel.
            let covered = num::saturate(0.5 + mid[i] / if g > 0.0 { g } else { 1.0 });
            let hard = if mid[i] >= 0.0 { 1.0 } else { 0.0 };
            out[i] = if g > 0.0 { covered } else { hard };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        assert_bands_agree, assert_finite, assert_shifts_along, grid, noise, run, square,
    };
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Value};

    #[test]
    fn hard_and_soft_without_softness_are_the_comparison() {
        let a = noise(9, 9, 1);
        let hard = run(&Threshold { edge: Edge::Hard }, &square(9), &[P(&a), Value(0.3)]);
        let soft = run(&Threshold { edge: Edge::Soft }, &square(9), &[P(&a), Value(0.3), Value(0.0)]);
        assert_eq!(hard, soft);
        assert!(hard.data().iter().zip(a.data()).all(|(h, x)| *h == f32::from(u8::from(*x >= 0.3))));
    }

    /// A ramp whose level line lies at a known fraction of a texel.
    #[test]
    fn antialiased_coverage_of_a_straight_edge_is_exact() {
        for edge in [3.0f32, 3.25, 3.5, 3.9] {
            let ramp = Plane::from_fn(32, 8, |x, _| 0.07 * (x as f32 + 0.5 - edge));
            let out = run(&Threshold::default(), &grid(32, 8), &[P(&ramp), Value(0.0)]);
            for x in 1..31 {
                let covered = (x as f32 + 1.0 - edge).clamp(0.0, 1.0);
                assert!((out.at(x, 4) - covered).abs() < 1e-4, "{edge} {x}");
            }
        }
    }

    #[test]
    fn antialiased_keeps_hard_masks_constants_and_moves_along() {
        let node = Threshold::default();
        let mask = Plane::from_fn(16, 16, |x, y| f32::from(u8::from((4..9).contains(&x) && y < 7)));
        let out = run(&node, &square(16), &[P(&mask)]);
        assert!(super::super::testing::max_difference(&out, &mask) < 0.3);
        assert_eq!((out.at(6, 3), out.at(4, 3), out.at(12, 3)), (1.0, 1.0, 0.0));
        assert_shifts_along(&node, &grid(13, 11), &noise(13, 11, 3), &[Value(0.4)]);
        assert_bands_agree(&node, &grid(13, 11), &[P(&noise(13, 11, 3)), P(&noise(13, 11, 4))]);
    }

    #[test]
    fn every_edge_is_finite() {
        for edge in [Edge::Hard, Edge::Antialiased, Edge::Soft] {
            for level in [0.0, 1e30, f32::MIN] {
                assert_finite(&Threshold { edge }, &[Value(level), Value(f32::MAX)]);
            }
        }
    }
}
