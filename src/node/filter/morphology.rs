//! Growing and shrinking a mask by a disc.

use std::ops::Range;

use rayon::prelude::*;

use super::distance::LEVEL_INPUT;
use super::edt::{LengthUnit, own_bytes, signed_distance};
use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Grows a mask by a disc: everything within `radius` of it, anti-aliased, through the seams. At radius 0 it is the
/// mask with an edge one texel wide.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dilate {
    /// What `radius` is measured in.
    pub unit: LengthUnit,
}

/// Shrinks a mask by a disc: what is farther than `radius` inside its outline, anti-aliased, through the seams. At
/// radius 0 it is the mask with an edge one texel wide.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Erode {
    /// What `radius` is measured in.
    pub unit: LengthUnit,
}

const MASK: usize = 0;
const LEVEL: usize = 1;
const RADIUS: usize = 2;

const INPUTS: [InputSpec; 3] = [
    InputSpec::plane("mask", "", "The mask."),
    LEVEL_INPUT,
    InputSpec::drive(
        "radius",
        0.005,
        (0.0, 1000.0),
        "tile or mm",
        "How far the outline moves, in tile fractions or mm by `unit`; 0.001 to 0.05 tile.",
    ),
];

impl Operation for Dilate {
    const SPEC: Spec = Spec {
        name: "dilate",
        summary: "Grows a mask evenly.",
        inputs: &INPUTS,
        outputs: &[OutputSpec::scalar("mask", "", "The grown mask, in [0, 1].")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        31.0
    }

    fn own_bytes(&self, domain: &Domain, _: usize) -> u64 {
        own_bytes(domain)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        moved(cx, rows, ins, outs, self.unit.mm(&cx.domain));
    }
}

impl Operation for Erode {
    const SPEC: Spec = Spec {
        name: "erode",
        summary: "Shrinks a mask evenly.",
        outputs: &[OutputSpec::scalar("mask", "", "The shrunk mask, in [0, 1].")],
        ..Dilate::SPEC
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        31.0
    }

    fn own_bytes(&self, domain: &Domain, _: usize) -> u64 {
        own_bytes(domain)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        moved(cx, rows, ins, outs, -self.unit.mm(&cx.domain));
    }
}

/// The mask with its outline moved outwards by `radius * unit` mm.
fn moved(cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>, unit: f32) {
    let width = outs.width();
    let Some(out) = outs.band(0) else { return };
    signed_distance(&cx.domain, ins, MASK, LEVEL, out);
    let per_texel = 1.0 / cx.domain.texel_mm();
    let radii = ins.scalar(RADIUS);
    out.par_chunks_mut(width).enumerate().for_each(|(i, out)| {
        kernel(radii.row(rows.start + i as i64), unit, per_texel, out);
    });
}

multiversion! {
    // `out` holds the signed distance in mm.
    fn kernel(radius: &[f32], unit: f32, per_texel: f32, out: &mut [f32]) {
        for (o, r) in out.iter_mut().zip(radius) {
            let r = (r.max(0.0) * unit).max(-1e30).min(1e30);
            *o = num::saturate(0.5 - (*o - r) * per_texel);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_finite, grid, max_difference, run};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Unset, Value};
    use crate::node::Node;

    /// A hard square of 12 texels of 1 mm that lies over both seams.
    fn square() -> Plane {
        Plane::from_fn(40, 40, |x, y| f32::from(u8::from((x + 6) % 40 < 12 && (y + 6) % 40 < 12)))
    }

    fn grown(node: &dyn Node, mask: &Plane, radius: f32) -> Plane {
        run(node, &grid(40, 40), &[P(mask), Unset, Value(radius)])
    }

    fn area(p: &Plane) -> f32 {
        p.data().iter().sum()
    }

    #[test]
    fn a_grown_square_has_round_corners_and_a_shrunk_one_sharp() {
        let (dilate, erode) = (Dilate { unit: LengthUnit::Mm }, Erode { unit: LengthUnit::Mm });
        for r in [1.0f32, 2.5, 4.0] {
            // Steiner's formula, and a smaller square.
            let steiner = 144.0 + 48.0 * r + std::f32::consts::PI * r * r;
            let out = area(&grown(&dilate, &square(), r));
            assert!((out / steiner - 1.0).abs() < 0.02, "{r}: {out} {steiner}");
            let out = area(&grown(&erode, &square(), r));
            assert!((out / (12.0 - 2.0 * r).powi(2) - 1.0).abs() < 0.06, "{r}: {out}");
        }
    }

    #[test]
    fn radius_0_keeps_the_mask_but_for_its_corners() {
        for node in [&Dilate::default() as &dyn Node, &Erode::default()] {
            let out = grown(node, &square(), 0.0);
            assert!(max_difference(&out, &square()) < 0.3);
            assert!((area(&out) - 144.0).abs() < 2.0);
        }
    }

    #[test]
    fn all_and_nothing_are_the_ends() {
        assert!(grown(&Dilate::default(), &square(), 2.0).data().iter().all(|&v| v == 1.0));
        assert!(grown(&Erode::default(), &square(), 2.0).data().iter().all(|&v| v == 0.0));
        for radius in [0.0, 1e30, -1.0] {
            assert_finite(&Dilate::default(), &[Unset, Value(radius)]);
            assert_finite(&Erode::default(), &[Value(1e30), Value(radius)]);
        }
    }
}
