//! A straight gradient.

use std::ops::Range;

use super::profile::{Profile, shade};
use super::shape;
use crate::base::num;
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A straight gradient, a whole number of periods in each direction, so that it tiles at any slope.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinearGradient {
    /// Periods around the body; 0 for a gradient along it.
    #[schemars(range(min = -4096, max = 4096))]
    pub periods_u: i32,
    /// Periods along the body; 0 for a gradient around it.
    #[schemars(range(min = -4096, max = 4096))]
    pub periods_v: i32,
    /// How it runs in one period; all but `ramp` are continuous over the seam.
    pub profile: Profile,
}

impl Default for LinearGradient {
    fn default() -> Self {
        Self { periods_u: 0, periods_v: 1, profile: Profile::Mirrored }
    }
}

const OFFSET: usize = 0;
const DU: usize = 1;

impl Operation for LinearGradient {
    const SPEC: Spec = Spec {
        name: "linear_gradient",
        summary: "A straight gradient that tiles at any slope.",
        inputs: &[
            InputSpec::drive("offset", 0.0, (-1.0, 1.0), "period", "Moves it; 1 is a whole period."),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("value", "", "The gradient, 0 to 1.")],
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        1.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let n = cx.domain.width;
        let periods = [self.periods_u as f32, self.periods_v as f32];
        let (mut u, mut v) = (vec![0.0; n], vec![0.0; n]);
        for row in rows {
            shape::place(ins.row(DU, row), 0.0, 1.0 / n as f32, 0.5, 1.0, &mut u);
            shape::place(ins.row(DU + 1, row), cx.domain.v(row), 0.0, 0.5, 1.0, &mut v);
            kernel(&u, &v, ins.row(OFFSET, row), periods, self.profile.code(), outs.only(row));
        }
    }
}

multiversion! {
    /// u and v come as distance to the tile's middle.
    fn kernel(u: &[f32], v: &[f32], offset: &[f32], periods: [f32; 2], profile: u32, out: &mut [f32]) {
        for (((out, u), v), offset) in out.iter_mut().zip(u).zip(v).zip(offset) {
            let phase = (u + 0.5) * periods[0] + (v + 0.5) * periods[1] - num::wrap_half(*offset);
            *out = shade(phase, profile);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    #[test]
    fn a_ramp_is_v_and_a_wave_is_its_cosine() {
        let domain = Domain::square(32);
        let run = |profile| {
            let node = LinearGradient { profile, ..LinearGradient::default() };
            run_node(&node, &domain, 1, &[Input::Unset], &Assets::new(), 7)[0].clone()
        };
        let (ramp, mirrored, wave) = (run(Profile::Ramp), run(Profile::Mirrored), run(Profile::Wave));
        for y in 0..32 {
            let v = domain.v(y);
            assert!((ramp.at(3, y) - v).abs() < 1e-6);
            assert!((mirrored.at(3, y) - (1.0 - (2.0 * v - 1.0).abs())).abs() < 1e-6);
            let cosine = 0.5 - 0.5 * (f64::from(v) * std::f64::consts::TAU).cos();
            assert!((f64::from(wave.at(3, y)) - cosine).abs() < 1e-6);
        }
    }
}
