//! Blur along a line.

use std::collections::BTreeMap;
use std::ops::Range;

use super::finite;
use super::separable::texels;
use crate::base::Domain;
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Prepared, Reach, Spec};

/// Each texel becomes the mean along a line through it, through the seams: streaks. Length 0 changes nothing.
///
/// The line is sampled bilinearly at two points per texel of its length.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DirectionalBlur {
    /// Direction of the line: 0 around the body (u), 90 along it (v).
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "deg"))]
    pub angle: f32,
    /// How far it blurs: the whole length of the line, as a fraction of the tile's shorter side; 0.02. Cost grows
    /// with it.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "tile"))]
    pub length: f32,
}

impl Default for DirectionalBlur {
    fn default() -> Self {
        Self { angle: 0.0, length: 0.02 }
    }
}

/// One texel that counts: rows and columns away, and its weight.
type Tap = (i64, i64, f32);

impl DirectionalBlur {
    /// The texels under the line, by rows, then columns; their weights sum to 1.
    fn taps(&self, domain: &Domain) -> Vec<Tap> {
        let (u, v) = texels(domain, self.length);
        let angle = f64::from(self.angle).to_radians();
        let (dx, dy) = (u * libm::cos(angle), v * libm::sin(angle));
        let count = ((2.0 * libm::hypot(dx, dy)).ceil() as usize).max(1);
        let mut weights = BTreeMap::<(i64, i64), f64>::new();
        for i in 0..count {
            let t = (i as f64 + 0.5) / count as f64 - 0.5;
            let (x, y) = (t * dx, t * dy);
            let (x0, y0) = (x.floor(), y.floor());
            let (tx, ty) = (x - x0, y - y0);
            for (ix, iy, w) in [
                (0, 0, (1.0 - tx) * (1.0 - ty)),
                (1, 0, tx * (1.0 - ty)),
                (0, 1, (1.0 - tx) * ty),
                (1, 1, tx * ty),
            ] {
                if w > 1e-9 {
                    *weights.entry((y0 as i64 + iy, x0 as i64 + ix)).or_default() += w / count as f64;
                }
            }
        }
        weights.into_iter().map(|((y, x), w)| (y, x, w as f32)).collect()
    }
}

impl Operation for DirectionalBlur {
    const SPEC: Spec = Spec {
        name: "directional_blur",
        summary: "Blurs along one direction.",
        inputs: &[InputSpec::image("image", "What is blurred.")],
        outputs: &[OutputSpec::same("result", "The blurred image; its mean stays.")],
        ..Spec::FILTER
    };

    fn reach(&self, domain: &Domain) -> Reach {
        let most = |side: fn(&Tap) -> i64, n: usize| {
            let far = self.taps(domain).iter().map(|t| side(t).unsigned_abs() as usize).max().unwrap_or(0);
            far.min(n)
        };
        let (x, y) = (most(|t| t.1, domain.width), most(|t| t.0, domain.height));
        if (x, y) == (0, 0) { Reach::Point } else { Reach::Around { x, y } }
    }

    fn cost_ns(&self) -> f32 {
        // 0.2 ns per tap, three taps per texel of the line, at 2048 texels.
        0.5 + 0.2 * 3.0 * 2048.0 * self.length
    }

    fn forwards(&self) -> Option<usize> {
        (self.length == 0.0).then_some(0)
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(self.taps(&cx.domain)))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let taps: &Vec<Tap> = cx.prepared();
        let width = outs.width();
        for y in rows {
            if let Some(value) = ins.constant(0) {
                outs.only(y).fill(value);
                continue;
            }
            let out = outs.only(y);
            out.fill(0.0);
            for &(dy, dx, w) in taps {
                let row = ins.row(0, y + dy);
                // The row turned by dx: its tail, then its head.
                let cut = dx.rem_euclid(width as i64) as usize;
                let (head, tail) = row.split_at(cut);
                let (first, second) = out.split_at_mut(width - cut);
                add(w, tail, first);
                add(w, head, second);
            }
            limit(out);
        }
    }
}

multiversion! {
    fn add(w: f32, row: &[f32], out: &mut [f32]) {
        for (o, r) in out.iter_mut().zip(row) { *o += w * *r; }
    }
}

multiversion! {
    fn limit(out: &mut [f32]) {
        for o in out { *o = finite(*o); }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        assert_bands_agree, assert_finite, assert_shifts_along, grid, impulse, noise, run,
    };
    use super::*;
    use crate::base::num;
    use crate::eval::Input::Plane as P;

    fn blur(angle: f32, length: f32) -> DirectionalBlur {
        DirectionalBlur { angle, length }
    }

    #[test]
    fn an_impulse_becomes_a_line_of_its_length_and_direction() {
        // A line of L texels has the second moment L^2 / 12 along itself, and bilinear sampling adds at most 1/4.
        for angle in [0.0f32, 30.0, 90.0, 135.0] {
            let length = 20.0f32;
            let out = run(&blur(angle, length / 64.0), &grid(80, 64), &[P(&impulse(80, 64, 40, 32))]);
            let (c, s) = (f64::from(angle).to_radians().cos(), f64::from(angle).to_radians().sin());
            let (mut sum, mut along, mut across) = (0.0, 0.0, 0.0);
            for y in 0..64 {
                for x in 0..80 {
                    let (w, dx, dy) = (f64::from(out.at(x, y)), x as f64 - 40.0, y as f64 - 32.0);
                    sum += w;
                    along += w * (c * dx + s * dy).powi(2);
                    across += w * (c * dy - s * dx).powi(2);
                }
            }
            assert!((sum - 1.0).abs() < 1e-5, "{angle}: {sum}");
            assert!((along - 400.0 / 12.0).abs() < 0.5 && across < 0.3, "{angle}: {along} {across}");
        }
    }

    #[test]
    fn length_0_is_the_identity_and_the_mean_stays() {
        let a = noise(31, 17, 1);
        assert!(run(&blur(25.0, 0.0), &grid(31, 17), &[P(&a)]) == a);
        let out = run(&blur(25.0, 0.6), &grid(31, 17), &[P(&a)]);
        assert!((num::mean(out.data()) - num::mean(a.data())).abs() < 1e-6);
    }

    #[test]
    fn bands_agree_the_torus_has_no_seam_and_all_is_finite() {
        for (angle, length) in [(0.0, 0.3), (70.0, 0.2), (-45.0, 1.0)] {
            assert_bands_agree(&blur(angle, length), &grid(31, 17), &[P(&noise(31, 17, 2))]);
            assert_shifts_along(&blur(angle, length), &grid(31, 17), &noise(31, 17, 2), &[]);
            assert_finite(&blur(angle, length), &[]);
        }
    }
}
