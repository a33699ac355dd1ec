//! Signed distance to the outline of a mask.

use std::ops::Range;

use super::edt::{own_bytes, signed_distance};
use crate::base::Domain;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// How far each texel is from the outline of a mask, in mm: negative inside, positive outside, through the seams.
///
/// The outline lies where the mask, interpolated between texels, crosses `level`: straight outlines are met exactly,
/// curved or slanted ones of a mask with edges one texel wide within 0.45 texel (RMS 0.15). A mask without outline is half the tile's diagonal away.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Distance {}

const MASK: usize = 0;
const LEVEL: usize = 1;

/// The `level` input that every node on masks has.
pub(super) const LEVEL_INPUT: InputSpec =
    InputSpec::drive("level", 0.5, (-1e6, 1e6), "", "What is at or above this is inside.");

impl Operation for Distance {
    const SPEC: Spec = Spec {
        name: "distance",
        summary: "Distance to the outline of a mask, negative inside.",
        inputs: &[InputSpec::plane("mask", "", "The mask."), LEVEL_INPUT],
        outputs: &[OutputSpec::scalar("distance", "mm", "Signed distance, negative inside.")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        30.0
    }

    fn own_bytes(&self, domain: &Domain, _: usize) -> u64 {
        own_bytes(domain)
    }

    fn eval(&self, cx: &Cx<'_>, _: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        if let Some(out) = outs.band(0) {
            signed_distance(&cx.domain, ins, MASK, LEVEL, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_finite, grid, max_difference, noise, run};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Unset, Value};

    /// A disc of `radius` around (cx, cy) on the torus, as the coverage of each texel by a first-order edge.
    fn disc(n: usize, cx: f32, cy: f32, radius: f32) -> (Plane, Plane) {
        let wrap = |d: f32| (d + n as f32 * 1.5).rem_euclid(n as f32) - n as f32 * 0.5;
        let exact = Plane::from_fn(n, n, |x, y| wrap(x as f32 - cx).hypot(wrap(y as f32 - cy)) - radius);
        (Plane::from_fn(n, n, |x, y| (0.5 - exact.at(x as i64, y as i64)).clamp(0.0, 1.0)), exact)
    }

    #[test]
    fn an_antialiased_disc_over_the_seam_is_met_within_a_fraction_of_a_texel() {
        for (cx, cy, r) in [(3.3, 2.1, 17.4), (20.0, 20.5, 9.0), (0.2, 40.7, 23.0)] {
            let (mask, exact) = disc(61, cx, cy, r);
            let out = run(&Distance::default(), &grid(61, 61), &[P(&mask)]);
            let error = max_difference(&out, &exact);
            let squares = out.data().iter().zip(exact.data()).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
            let rms = (squares / 3721.0).sqrt();
            assert!(error < 0.45 && rms < 0.15, "{cx} {cy} {r}: {error} {rms}");
        }
        // The control: a radius off by half a texel is told apart.
        let (mask, _) = disc(61, 20.0, 20.5, 9.0);
        let (_, exact) = disc(61, 20.0, 20.5, 9.5);
        assert!(max_difference(&run(&Distance::default(), &grid(61, 61), &[P(&mask)]), &exact) > 0.4);
    }

    #[test]
    fn a_straight_edge_between_texels_is_met_exactly_and_in_mm() {
        let d = Domain { width: 40, height: 12, girth_mm: 80.0, length_mm: 36.0 };
        for edge in [10.0f32, 10.3, 10.5] {
            // A band from `edge` to `edge` + 16 texels of 2 mm, as a ramp mask.
            let wrap = |d: f32| (d + 60.0).rem_euclid(40.0) - 20.0;
            let exact = |x: usize| (wrap(x as f32 - edge - 8.0).abs() - 8.0) * 2.0;
            let mask = Plane::from_fn(40, 12, |x, _| 0.5 - 0.1 * exact(x));
            let out = run(&Distance::default(), &d, &[P(&mask)]);
            for x in 0..40 {
                assert!((out.at(x, 5) - exact(x as usize)).abs() < 1e-4, "{edge} {x}: {}", out.at(x, 5));
            }
        }
    }

    #[test]
    fn random_masks_agree_with_brute_force_within_a_texel() {
        // Edges of a hard mask lie half-way between unlike neighbours.
        for (w, h) in [(19, 13), (31, 31)] {
            let mask = Plane::from_fn(w, h, |x, y| {
                f32::from(u8::from(noise(w, h, 9).at(x as i64, y as i64) < 0.06))
            });
            let out = run(&Distance::default(), &grid(w, h), &[P(&mask)]);
            for y in 0..h as i64 {
                for x in 0..w as i64 {
                    let mut best = f32::INFINITY;
                    for dy in -(h as i64) / 2..=h as i64 / 2 {
                        for dx in -(w as i64) / 2..=w as i64 / 2 {
                            if mask.at(x + dx, y + dy) != mask.at(x, y) {
                                best = best.min((dx as f32).hypot(dy as f32) - 0.5);
                            }
                        }
                    }
                    let (d, inside) = (out.at(x, y), mask.at(x, y) == 1.0);
                    assert!((d < 0.0) == inside && (d.abs() - best).abs() < 0.75, "{x} {y}: {d} {best}");
                }
            }
        }
    }

    #[test]
    fn moving_the_mask_moves_the_distance() {
        let (mask, _) = disc(41, 8.3, 30.1, 9.7);
        let of = |m: &Plane| run(&Distance::default(), &grid(41, 41), &[P(m)]);
        assert!(max_difference(&of(&mask.shifted(17, -9)), &of(&mask).shifted(17, -9)) < 1e-4);
    }

    #[test]
    fn without_an_outline_it_is_half_the_diagonal() {
        let d = Domain { width: 4, height: 3, girth_mm: 8.0, length_mm: 6.0 };
        assert_eq!(run(&Distance::default(), &d, &[Value(1.0)]).data(), &[-5.0; 12]);
        assert_eq!(run(&Distance::default(), &d, &[Value(0.0)]).data(), &[5.0; 12]);
        assert_finite(&Distance::default(), &[Unset]);
        assert_finite(&Distance::default(), &[Value(f32::MIN)]);
    }
}
