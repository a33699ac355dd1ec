//! Warps: an image looked up elsewhere.

use std::ops::Range;

use super::finite;
use super::sample::{Points, Sampler};
use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// The image is looked up at (u + du, v + dv): with noise it is bent, with `du`, `dv` of a scale lattice each scale
/// takes the one value at its centre.
///
/// `du` is a fraction of the girth and `dv` of the length, as everywhere; look-up is bilinear, through the seams.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Warp {}

/// The image is looked up along one direction, as far as a map says.
///
/// Distances are fractions of the tile's shorter side, so they are the same in mm in every direction.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DirectionalWarp {}

const IMAGE: usize = 0;

/// `Warp`'s inputs.
const DU: usize = 1;
const DV: usize = 2;
const INTENSITY: usize = 3;

/// `DirectionalWarp`'s inputs.
const MAP: usize = 1;
const AMOUNT: usize = 2;
const ANGLE: usize = 3;

impl Operation for Warp {
    const SPEC: Spec = Spec {
        name: "warp",
        summary: "Looks an image up elsewhere: bends it, or takes one value per scale.",
        inputs: &[
            InputSpec::image("image", "What is looked up."),
            InputSpec::drive("du", 0.0, (-1.0, 1.0), "tile", "How far around the body it looks."),
            InputSpec::drive("dv", 0.0, (-1.0, 1.0), "tile", "How far tail-ward it looks."),
            InputSpec::drive(
                "intensity",
                1.0,
                (-100.0, 100.0),
                "",
                "Scales `du` and `dv`: 0 changes nothing, 1 takes them as they are.",
            ),
        ],
        outputs: &[OutputSpec::same("result", "The warped image.")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Anywhere
    }

    fn cost_ns(&self) -> f32 {
        5.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let sampler = Sampler::new(ins.scalar(IMAGE), cx.domain.height);
        let mut points = Points::default();
        let (mut du, mut dv) = (vec![0.0; outs.width()], vec![0.0; outs.width()]);
        for y in rows {
            scale(ins.row(DU, y), ins.row(INTENSITY, y), &mut du);
            scale(ins.row(DV, y), ins.row(INTENSITY, y), &mut dv);
            sampler.moved(y as usize, &du, &dv, &mut points, outs.only(y));
        }
    }
}

impl Operation for DirectionalWarp {
    const SPEC: Spec = Spec {
        name: "directional_warp",
        summary: "Pushes an image along a direction by a map.",
        inputs: &[
            InputSpec::image("image", "What is pushed."),
            InputSpec::plane("map", "", "How far each texel is pushed, times `amount`; 0 leaves it."),
            InputSpec::drive(
                "amount",
                0.02,
                (-10.0, 10.0),
                "tile",
                "Push where the map is 1, against `angle` if negative; 0.005 to 0.05.",
            ),
            InputSpec::drive(
                "angle",
                0.0,
                (-3600.0, 3600.0),
                "deg",
                "Direction of the push: 0 around the body (+u), 90 tail-ward (+v).",
            ),
        ],
        outputs: &[OutputSpec::same("result", "The warped image.")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Anywhere
    }

    fn cost_ns(&self) -> f32 {
        7.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let sampler = Sampler::new(ins.scalar(IMAGE), cx.domain.height);
        let mut points = Points::default();
        let (mut du, mut dv) = (vec![0.0; outs.width()], vec![0.0; outs.width()]);
        // The image moves by +push, so it is looked up at -push.
        let shorter = cx.domain.shorter_mm();
        let (per_u, per_v) = (-shorter / cx.domain.girth_mm, -shorter / cx.domain.length_mm);
        for y in rows {
            push(ins.row(MAP, y), ins.row(AMOUNT, y), ins.row(ANGLE, y), per_u, per_v, &mut du, &mut dv);
            sampler.moved(y as usize, &du, &dv, &mut points, outs.only(y));
        }
    }
}

multiversion! {
    fn scale(shift: &[f32], intensity: &[f32], out: &mut [f32]) {
        for ((o, s), i) in out.iter_mut().zip(shift).zip(intensity) { *o = *s * *i; }
    }
}

multiversion! {
    fn push(
        map: &[f32], amount: &[f32], angle: &[f32], per_u: f32, per_v: f32, du: &mut [f32], dv: &mut [f32],
    ) {
        for ((((u, v), m), a), angle) in du.iter_mut().zip(dv).zip(map).zip(amount).zip(angle) {
            let turns = if angle.abs() <= 1e6 { *angle * (1.0 / 360.0) } else { 0.0 };
            let far = finite(*m * *a);
            *u = far * num::cos_turns(turns) * per_u;
            *v = far * num::sin_turns(turns) * per_v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        assert_bands_agree, assert_finite, assert_shifts_along, grid, max_difference, noise, run,
    };
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Unset, Value};

    #[test]
    fn no_shift_is_the_identity_and_whole_texels_are_exact() {
        let a = noise(16, 8, 1);
        let of = |du, dv, i| run(&Warp::default(), &grid(16, 8), &[P(&a), Value(du), Value(dv), Value(i)]);
        assert!(of(0.0, 0.0, 1.0) == a && of(0.7, 0.3, 0.0) == a);
        for (dx, dy) in [(3, 0), (-5, 2), (16, -8), (15, 7)] {
            assert!(of(dx as f32 / 16.0, dy as f32 / 8.0, 1.0) == a.shifted(-dx, -dy), "{dx} {dy}");
        }
        let half = of(0.5 / 16.0, 0.0, 1.0);
        assert!((half.at(15, 0) - 0.5 * (a.at(15, 0) + a.at(0, 0))).abs() < 1e-6);
    }

    /// What the scale lattice does: every texel points at the centre of its 4x4 block.
    #[test]
    fn offsets_to_block_centres_make_blocks_of_one_value() {
        let a = noise(16, 16, 2);
        let to_centre = |i: usize| (1.5 - (i % 4) as f32) / 16.0;
        let du = Plane::from_fn(16, 16, |x, _| to_centre(x));
        let dv = Plane::from_fn(16, 16, |_, y| to_centre(y));
        let out = run(&Warp::default(), &grid(16, 16), &[P(&a), P(&du), P(&dv)]);
        for y in 0..16 {
            for x in 0..16 {
                assert!((out.at(x, y) - out.at(x / 4 * 4, y / 4 * 4)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_directional_warp_pushes_along_its_angle_in_mm() {
        // 20 mm x 10 mm of 1 mm: amount 0.3 of the shorter side is 3 texels.
        let a = noise(20, 10, 3);
        for (angle, dx, dy) in [(0.0, 3, 0), (90.0, 0, 3), (180.0, -3, 0), (270.0, 0, -3), (-90.0, 0, -3)] {
            let ins = [P(&a), Value(1.0), Value(0.3), Value(angle)];
            let out = run(&DirectionalWarp::default(), &grid(20, 10), &ins);
            assert!(max_difference(&out, &a.shifted(dx, dy)) < 1e-4, "{angle}");
        }
        let still = run(&DirectionalWarp::default(), &grid(20, 10), &[P(&a), Value(0.0), Value(0.3)]);
        assert!(still == a);
    }

    #[test]
    fn bands_agree_the_torus_has_no_seam_and_all_is_finite() {
        let (a, b) = (noise(13, 11, 4), noise(13, 11, 5));
        assert_bands_agree(&Warp::default(), &grid(13, 11), &[P(&a), P(&b), P(&a), Value(0.3)]);
        assert_bands_agree(&DirectionalWarp::default(), &grid(13, 11), &[P(&a), P(&b)]);
        assert_shifts_along(&Warp::default(), &grid(13, 11), &a, &[Value(0.33), Value(-2.7)]);
        for v in [0.3, 1e30, f32::MIN, -1e-40] {
            assert_finite(&Warp::default(), &[Value(v), Value(v), Value(v)]);
            assert_finite(&Warp::default(), &[Unset, Value(v), Unset]);
            assert_finite(&DirectionalWarp::default(), &[Value(v), Value(v), Value(v)]);
        }
    }
}
