//! Gaussian blur.

use std::ops::Range;

use super::separable::{self, Taps, texels};
use crate::base::Domain;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Blur by a Gaussian bell, round in mm, through the seams.
///
/// The kernel is the discrete Gaussian `exp(-t) I_n(t)`, `t = sigma^2` in texels (Lindeberg, "Scale-space for discrete
/// signals", IEEE PAMI 12(3), 1990): its variance is `sigma^2` and two blurs add up at any radius, also below a texel,
/// and radius 0 is the identity. It is cut at 4 sigma + 1 texel and normalised: that moves a texel of a [0, 1] image
/// by at most 7e-5 and shortens sigma by 0.1 %. A bell wider than the tile wraps around it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GaussianBlur {
    /// How far it blurs: the standard deviation, as a fraction of the tile's shorter side; 0.001 softens, 0.05 washes
    /// out. Cost grows with it.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub radius: f32,
}

impl Default for GaussianBlur {
    fn default() -> Self {
        Self { radius: 0.01 }
    }
}

/// Half of the discrete Gaussian, not normalised: entry n is proportional to `I_n(sigma^2)`.
fn bell(sigma: f64) -> Vec<f64> {
    let t = sigma * sigma;
    if !(1e-6..1e12).contains(&t) {
        // To first order in t; what it neglects is below f32's resolution. (Above: refused by the range.)
        return vec![1.0 - t.clamp(0.0, 1e-6), 0.5 * t.clamp(0.0, 1e-6)];
    }
    let radius = (4.0 * sigma).ceil() as usize + 1;
    // Miller's backward recurrence I_{n-1} = I_{n+1} + (2 n / t) I_n from where I_n is below 1e-14 of what is kept.
    let start = (7.0 * sigma).ceil() as usize + 20;
    let mut half = vec![0.0; radius + 1];
    let (mut next, mut here) = (0.0, 1e-300);
    for n in (1..=start).rev() {
        (next, here) = (here, next + 2.0 * n as f64 / t * here);
        if here > 1e200 {
            next *= 1e-300;
            here *= 1e-300;
            half.iter_mut().for_each(|v| *v *= 1e-300);
        }
        if n <= radius + 1 {
            half[n - 1] = here;
        }
    }
    half
}

impl GaussianBlur {
    fn taps(&self, domain: &Domain) -> (Taps, Taps) {
        let (u, v) = texels(domain, self.radius);
        if self.radius == 0.0 {
            return (Taps::symmetric(&[1.0], domain.width), Taps::symmetric(&[1.0], domain.height));
        }
        (Taps::symmetric(&bell(u), domain.width), Taps::symmetric(&bell(v), domain.height))
    }
}

impl Operation for GaussianBlur {
    const SPEC: Spec = Spec {
        name: "gaussian_blur",
        summary: "Blurs by a Gaussian bell.",
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
        0.5 + 0.1 * 2.0 * 8.0 * 2048.0 * self.radius
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
        assert_bands_agree, assert_finite, assert_shifts_along, grid, impulse, max_difference, noise, run,
    };
    use super::*;
    use crate::base::{Plane, num};
    use crate::eval::Input::{Plane as P, Value};

    fn blur(radius: f32) -> GaussianBlur {
        GaussianBlur { radius }
    }

    #[test]
    fn the_second_moment_of_a_blurred_impulse_is_sigma_squared() {
        // Texels of 1 mm: radius * 64 texels in both directions, on a tile of 97 x 64.
        for sigma in [0.05, 0.3, 0.7, 1.0, 2.0, 5.5] {
            let out = run(&blur(sigma / 64.0), &grid(97, 64), &[P(&impulse(97, 64, 48, 32))]);
            let (mut sum, mut uu, mut vv) = (0.0, 0.0, 0.0);
            for y in 0..64 {
                for x in 0..97 {
                    let (w, dx, dy) = (f64::from(out.at(x, y)), x as f64 - 48.0, y as f64 - 32.0);
                    sum += w;
                    uu += w * dx * dx;
                    vv += w * dy * dy;
                }
            }
            let t = f64::from(sigma).powi(2);
            assert!((sum - 1.0).abs() < 1e-5, "{sigma}: {sum}");
            assert!((uu / t - 1.0).abs() < 2e-3 && (vv / t - 1.0).abs() < 2e-3, "{sigma}: {uu} {vv} {t}");
        }
    }

    /// An independent reference: for sigma of many texels the discrete Gaussian is the sampled one.
    #[test]
    fn a_wide_bell_is_the_sampled_gaussian() {
        let half = bell(20.0);
        for (n, w) in half.iter().enumerate() {
            let e = (-(n as f64).powi(2) / 800.0).exp();
            assert!((w / half[0] - e).abs() < 5e-4, "{n}");
        }
        // And exp(-t) I_0(t), I_1(t) at t = 1, from tables (Abramowitz and Stegun, table 9.8).
        let half = bell(1.0);
        let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
        assert!((half[0] / sum - 0.465_759_6).abs() < 2e-5 && (half[1] / sum - 0.207_910_4).abs() < 1e-5);
    }

    #[test]
    fn what_is_cut_off_is_below_the_stated_error() {
        for sigma in [0.01f64, 0.1, 0.3, 0.5, 0.8, 1.0, 1.5, 3.0, 8.0, 100.0] {
            let half = bell(sigma);
            // The whole sum, from a bell cut much later: scale by the centre.
            let t = sigma * sigma;
            let mut all = 0.0;
            let (mut next, mut here) = (0.0, 1e-200);
            let start = (12.0 * sigma).ceil() as usize + 20;
            for n in (1..=start).rev() {
                all += 2.0 * here;
                (next, here) = (here, next + 2.0 * n as f64 / t * here);
            }
            all = (all + here) / here;
            let kept = (half[0] + 2.0 * half[1..].iter().sum::<f64>()) / half[0];
            assert!((1.0 - kept / all).abs() < 7e-5, "{sigma}: {}", 1.0 - kept / all);
        }
    }

    #[test]
    fn radius_0_is_the_identity_and_tiny_radii_come_near() {
        let a = noise(17, 9, 1);
        assert!(run(&blur(0.0), &grid(17, 9), &[P(&a)]) == a);
        assert!(max_difference(&run(&blur(1e-5), &grid(17, 9), &[P(&a)]), &a) < 1e-6);
    }

    #[test]
    fn a_bell_wider_than_the_tile_gives_the_mean() {
        for (w, h) in [(8, 8), (9, 5), (1, 7)] {
            let a = noise(w, h, 2);
            let out = run(&blur(1.0), &grid(w, h), &[P(&a)]);
            // Up to what is cut off; along a longer side some of the lowest frequency is left.
            let mean = num::mean(a.data()) as f32;
            if w == h {
                assert!(out.data().iter().all(|x| (x - mean).abs() < 1e-4), "{w} {h}");
            }
            assert!((num::mean(out.data()) as f32 - mean).abs() < 1e-6);
        }
    }

    #[test]
    fn blurs_add_up() {
        let a = noise(48, 48, 3);
        let d = grid(48, 48);
        let twice = run(&blur(0.04), &d, &[P(&run(&blur(0.03), &d, &[P(&a)]))]);
        assert!(max_difference(&twice, &run(&blur(0.05), &d, &[P(&a)])) < 2e-4);
    }

    #[test]
    fn constants_stay_bands_agree_and_the_torus_has_no_seam() {
        let flat = Plane::filled(70, 33, 0.7);
        for radius in [0.001, 0.02, 0.3] {
            assert!(max_difference(&run(&blur(radius), &grid(70, 33), &[P(&flat)]), &flat) < 1e-6);
            assert_eq!(run(&blur(radius), &grid(4, 4), &[Value(0.7)]).data(), &[0.7; 16]);
            assert_bands_agree(&blur(radius), &grid(70, 33), &[P(&noise(70, 33, 4))]);
            assert_shifts_along(&blur(radius), &grid(70, 33), &noise(70, 33, 4), &[]);
            assert_finite(&blur(radius), &[]);
        }
    }
}
