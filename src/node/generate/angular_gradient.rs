//! A gradient around a centre.

use std::ops::Range;

use super::profile::{Profile, shade};
use super::shape;
use crate::base::num;
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A gradient around a centre, like the hand of a clock.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AngularGradient {
    /// Place of the centre around the body; 0.5 is the middle of the back.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_u: f32,
    /// Place of the centre along the body.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub center_v: f32,
    /// Periods in a whole turn.
    #[schemars(range(min = 1, max = 4096))]
    pub periods: u32,
    /// How it runs in one period.
    pub profile: Profile,
    /// How its rays meet those of the next tile.
    pub rays: Rays,
}

/// How the rays of an angular gradient meet those of the next tile.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Rays {
    /// Straight; across the seam opposite the centre they meet those of the next centre, without a jump where
    /// `periods` is even, the profile runs back and `rotation` is 0.
    #[default]
    Straight,
    /// Bent, so that they go on into the next tile at any setting; three more centres appear, half a tile away.
    Bent,
}

impl Default for AngularGradient {
    fn default() -> Self {
        Self { center_u: 0.5, center_v: 0.5, periods: 2, profile: Profile::Mirrored, rays: Rays::Straight }
    }
}

const ROTATION: usize = 0;
const DU: usize = 1;

impl Operation for AngularGradient {
    const SPEC: Spec = Spec {
        name: "angular_gradient",
        summary: "A gradient around a centre.",
        inputs: &[
            InputSpec::drive(
                "rotation",
                0.0,
                (-360.0, 360.0),
                "deg",
                "Turns it; at 0 it starts in the direction of u and runs towards v.",
            ),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("value", "", "The gradient, 0 to 1.")],
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        4.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let n = domain.width;
        let (mut u, mut v) = (vec![0.0; n], vec![0.0; n]);
        let sides = [domain.girth_mm, domain.length_mm];
        let bent = self.rays == Rays::Bent;
        for row in rows {
            shape::place(ins.row(DU, row), 0.0, 1.0 / n as f32, self.center_u, 1.0, &mut u);
            shape::place(ins.row(DU + 1, row), domain.v(row), 0.0, self.center_v, 1.0, &mut v);
            let periods = self.periods as f32;
            let rotation = ins.row(ROTATION, row);
            kernel(&u, &v, rotation, sides, bent, periods, self.profile.code(), outs.only(row));
        }
    }
}

multiversion! {
    /// u and v relative to the nearest centre.
    fn kernel(
        u: &[f32],
        v: &[f32],
        rotation: &[f32],
        sides: [f32; 2],
        bent: bool,
        periods: f32,
        profile: u32,
        out: &mut [f32],
    ) {
        for (((out, u), v), rotation) in out.iter_mut().zip(u).zip(v).zip(rotation) {
            // A sine is the distance near the centre, and periodic.
            let (x, y) = if bent { (num::sin_turns(*u), num::sin_turns(*v)) } else { (*u, *v) };
            let turns = num::atan2_turns(y * sides[1], x * sides[0]);
            *out = shade((turns - num::wrap_half(rotation * (1.0 / 360.0))) * periods, profile);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(node: &AngularGradient, domain: &Domain, rotation: f32) -> Plane {
        run_node(node, domain, 1, &[Input::Value(rotation)], &Assets::new(), 0)[0].clone()
    }

    #[test]
    fn angles_are_those_of_millimetres() {
        let domain = Domain { width: 64, height: 128, girth_mm: 50.0, length_mm: 100.0 };
        let node = AngularGradient { periods: 1, profile: Profile::Ramp, ..AngularGradient::default() };
        let out = run(&node, &domain, 0.0);
        // A diagonal in mm, to the lower right of the centre (32, 64).
        assert!((out.at(42, 74) - 0.125).abs() < 1e-5);
        assert!((out.at(21, 53) - 0.625).abs() < 1e-5);
        assert!((run(&node, &domain, 45.0).at(52, 64) - (1.0 - 0.125)).abs() < 0.02);
    }

    #[test]
    fn bent_rays_and_even_mirrored_ones_cross_the_seams() {
        let domain = Domain::square(128);
        let jump = |node: &AngularGradient| {
            let p = run(node, &domain, 0.0);
            (0..128i64)
                .flat_map(|i| [(p.at(0, i) - p.at(-1, i)).abs(), (p.at(i, 0) - p.at(i, -1)).abs()])
                .fold(0.0, f32::max)
        };
        assert!(jump(&AngularGradient::default()) < 0.1);
        assert!(jump(&AngularGradient { periods: 3, ..AngularGradient::default() }) > 0.5);
    }
}
