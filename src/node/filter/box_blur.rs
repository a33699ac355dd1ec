//! Box blur.

use std::ops::Range;

use super::separable::{self, Taps, texels};
use crate::base::Domain;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Each texel becomes the mean of a square around it, through the seams.
///
/// The square is `2 radius` wide; texels that it cuts count by the part that lies inside, so the result grows
/// smoothly with the radius. A square within one texel changes nothing; one wider than the tile wraps around it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BoxBlur {
    /// Half the side of the square, as a fraction of the tile's shorter side; 0.005 softens. Cost grows with it.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub radius: f32,
}

impl Default for BoxBlur {
    fn default() -> Self {
        Self { radius: 0.01 }
    }
}

/// Half of the box: the part of texel n that lies within `radius` texels.
fn square(radius: f64) -> Vec<f64> {
    if radius <= 0.5 {
        return vec![1.0];
    }
    let last = (radius - 0.5).ceil() as usize;
    (0..=last).map(|n| (radius + 0.5 - n as f64).clamp(0.0, 1.0)).collect()
}

impl BoxBlur {
    fn taps(&self, domain: &Domain) -> (Taps, Taps) {
        let (u, v) = texels(domain, self.radius);
        (Taps::symmetric(&square(u), domain.width), Taps::symmetric(&square(v), domain.height))
    }
}

impl Operation for BoxBlur {
    const SPEC: Spec = Spec {
        name: "box_blur",
        summary: "Averages over a square.",
        inputs: &[InputSpec::image("image", "What is blurred.")],
        outputs: &[OutputSpec::same("result", "The blurred image; its mean stays.")],
        ..Spec::FILTER
    };

    fn reach(&self, domain: &Domain) -> Reach {
        let (u, v) = self.taps(domain);
        separable::reach(&u, &v)
    }

    fn cost_ns(&self) -> f32 {
        // 0.1 ns per tap, at 2048 texels.
        0.5 + 0.1 * 2.0 * 2.0 * 2048.0 * self.radius
    }

    fn forwards(&self) -> Option<usize> {
        (self.radius == 0.0).then_some(0)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let (u, v) = self.taps(&cx.domain);
        separable::convolve(rows, ins, outs, &u, &v);
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        assert_bands_agree, assert_finite, assert_shifts_along, grid, impulse, noise, run,
    };
    use super::*;
    use crate::eval::Input::Plane as P;

    fn blur(radius: f32) -> BoxBlur {
        BoxBlur { radius }
    }

    #[test]
    fn an_impulse_becomes_a_flat_square_with_cut_rims() {
        // Radius 2.25 texels of 40: side 4.5, so 3 whole texels and two of 0.75.
        let out = run(&blur(2.25 / 40.0), &grid(40, 40), &[P(&impulse(40, 40, 20, 20))]);
        let area = 4.5f32 * 4.5;
        for (x, y, part) in [(20, 20, 1.0), (21, 19, 1.0), (22, 20, 0.75), (22, 18, 0.5625), (23, 20, 0.0)] {
            assert!((out.at(x, y) - part / area).abs() < 1e-6, "{x} {y}");
        }
    }

    #[test]
    fn half_a_texel_or_less_is_the_identity() {
        let a = noise(20, 30, 1);
        for radius in [0.0, 0.01, 0.024] {
            assert!(run(&blur(radius), &grid(20, 30), &[P(&a)]) == a, "{radius}");
        }
    }

    #[test]
    fn the_whole_tile_gives_the_mean() {
        let a = noise(15, 15, 2);
        let mean = crate::base::num::mean(a.data()) as f32;
        for radius in [0.5, 1.0] {
            let out = run(&blur(radius), &grid(15, 15), &[P(&a)]);
            assert!(out.data().iter().all(|x| (x - mean).abs() < 1e-6), "{radius}");
        }
    }

    #[test]
    fn bands_agree_and_the_torus_has_no_seam() {
        for radius in [0.03, 0.1, 0.6] {
            assert_bands_agree(&blur(radius), &grid(45, 23), &[P(&noise(45, 23, 4))]);
            assert_shifts_along(&blur(radius), &grid(45, 23), &noise(45, 23, 4), &[]);
            assert_finite(&blur(radius), &[]);
        }
    }
}
