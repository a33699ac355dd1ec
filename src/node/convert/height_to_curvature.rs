//! Mean curvature of a height in mm.

use std::ops::Range;

use super::limit_slope;
use crate::base::{Domain, Rows, num};
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Mean curvature `H = -div(grad h / sqrt(1 + |grad h|^2)) / 2` of the surface, in 1/mm: 0 is flat, positive is
/// convex (a sphere of radius R gives 1 / R, a cylinder 1 / (2 R)). Edges catch wear, creases hold dirt.
///
/// The height is first blurred by a Gaussian, so that grain finer than `radius` does not count.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightToCurvature {
    /// Size of the detail that counts: standard deviation of the blur is half of it. 0.1 shows keels and scale
    /// edges, 1 only whole scales, 0 the texels themselves.
    #[schemars(range(min = 0.0, max = 20.0), extend("x-unit" = "mm"))]
    pub radius: f32,
}

impl Default for HeightToCurvature {
    fn default() -> Self {
        Self { radius: 0.1 }
    }
}

/// Heights beyond this read as this, so that sums and differences of them are finite.
const HIGHEST: f32 = 1e30;

/// The blur ends at so many standard deviations, where its weight is 1 %.
const TAIL: f32 = 3.0;

impl HeightToCurvature {
    /// Texels that the blur reaches to a side.
    fn taps(&self, texel_mm: f32) -> usize {
        (TAIL * 0.5 * self.radius / texel_mm).floor() as usize
    }

    /// Weights of the blur from the centre outward, over one side; with the other side their sum is 1.
    fn weights(&self, texel_mm: f32) -> Vec<f32> {
        let taps = self.taps(texel_mm);
        let sigma = 0.5 * self.radius / texel_mm;
        let raw =
            |i: usize| if i == 0 { 1.0 } else { num::exp(-0.5 * (i as f32 / sigma) * (i as f32 / sigma)) };
        let total: f32 = 1.0 + 2.0 * (1..=taps).map(raw).sum::<f32>();
        (0..=taps).map(|i| raw(i) / total).collect()
    }
}

impl Operation for HeightToCurvature {
    const SPEC: Spec = Spec {
        name: "height_to_curvature",
        category: Category::Convert,
        summary: "Makes mean curvature from a height in mm.",
        inputs: &[InputSpec::plane("height", "mm", "Height of the surface.")],
        outputs: &[OutputSpec::scalar(
            "curvature",
            "1/mm",
            "Mean curvature: positive convex, negative concave.",
        )],
        ..Spec::FILTER
    };

    fn reach(&self, domain: &Domain) -> Reach {
        Reach::Around { x: self.taps(domain.texel_u_mm()) + 1, y: self.taps(domain.texel_v_mm()) + 1 }
    }

    fn cost_ns(&self) -> f32 {
        // The blur grows with the resolution; this is its cost at 40 texels a mm.
        4.0 + 13.0 * self.radius
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let height = ins.scalar(0);
        if height.constant().is_some() {
            rows.for_each(|y| outs.only(y).fill(0.0));
            return;
        }
        let n = outs.width();
        let (du, dv) = (cx.domain.texel_u_mm(), cx.domain.texel_v_mm());
        let (first, blurred) = self.blur(&height, &rows, n, du, dv);
        let at = |y: i64| {
            let start = (y - first) as usize * n;
            &blurred[start..start + n]
        };
        let (per_u, per_v) = (1.0 / du, 1.0 / dv);
        // What flows through the texel's upper, lower and right sides; the lower is the next row's upper.
        let (mut upper, mut lower) = (vec![0.0f32; n], vec![0.0f32; n]);
        let mut right = vec![0.0f32; n];
        flow_v(at(rows.start - 1), at(rows.start), per_u, per_v, &mut upper);
        for y in rows {
            flow_v(at(y), at(y + 1), per_u, per_v, &mut lower);
            flow_u(at(y - 1), at(y), at(y + 1), per_u, per_v, &mut right);
            divergence(&upper, &lower, &right, per_u, per_v, outs.only(y));
            std::mem::swap(&mut upper, &mut lower);
        }
    }
}

impl HeightToCurvature {
    /// The blurred height of `rows` and one row more to each side; returns the first row's number with it.
    fn blur(&self, height: &Rows<'_>, rows: &Range<i64>, n: usize, du: f32, dv: f32) -> (i64, Vec<f32>) {
        let (wu, wv) = (self.weights(du), self.weights(dv));
        let (side, margin) = (wu.len() - 1, wv.len() as i64 - 1);
        let first = rows.start - 1;
        let count = (rows.end - rows.start) + 2;

        // Along u, each row once, out of a copy with its ends wrapped on.
        let mut padded = vec![0.0f32; n + 2 * side];
        let mut across = vec![0.0f32; (count + 2 * margin) as usize * n];
        for (i, out) in across.chunks_exact_mut(n).enumerate() {
            let row = height.row(first - margin + i as i64);
            // Column x of the copy is column x - side of the row; k copies of n keep the difference positive.
            let start = side.div_ceil(n) * n - side;
            for (x, p) in padded.iter_mut().enumerate() {
                *p = row[(start + x) % n].max(-HIGHEST).min(HIGHEST);
            }
            scaled(&padded[side..side + n], wu[0], out);
            for (k, &w) in wu.iter().enumerate().skip(1) {
                add_pair(&padded[side - k..][..n], &padded[side + k..][..n], w, out);
            }
        }

        // Along v.
        let mut blurred = vec![0.0f32; count as usize * n];
        for (i, out) in blurred.chunks_exact_mut(n).enumerate() {
            let row = |k: i64| &across[(i as i64 + margin + k) as usize * n..][..n];
            scaled(row(0), wv[0], out);
            for (k, &w) in wv.iter().enumerate().skip(1) {
                add_pair(row(-(k as i64)), row(k as i64), w, out);
            }
        }
        (first, blurred)
    }
}

multiversion! {
    fn scaled(a: &[f32], weight: f32, out: &mut [f32]) {
        for (o, a) in out.iter_mut().zip(a) {
            *o = a * weight;
        }
    }
}

multiversion! {
    fn add_pair(a: &[f32], b: &[f32], weight: f32, out: &mut [f32]) {
        for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
            *o += (a + b) * weight;
        }
    }
}

/// The component of the unit normal's lean across a texel side: `slope / sqrt(1 + slope^2 + cross^2)`.
#[inline(always)]
fn lean(slope: f32, cross: f32) -> f32 {
    let (slope, cross) = (limit_slope(slope), limit_slope(cross));
    slope / (1.0 + slope * slope + cross * cross).sqrt()
}

multiversion! {
    /// Lean along v through the side between a row and the next.
    fn flow_v(above: &[f32], below: &[f32], per_u: f32, per_v: f32, out: &mut [f32]) {
        let n = out.len();
        let (above, below) = (&above[..n], &below[..n]);
        for x in 1..n.saturating_sub(1) {
            let cross = (above[x + 1] - above[x - 1] + below[x + 1] - below[x - 1]) * (0.25 * per_u);
            out[x] = lean((below[x] - above[x]) * per_v, cross);
        }
        for x in [0, n - 1] {
            let (l, r) = ((x + n - 1) % n, (x + 1) % n);
            let cross = (above[r] - above[l] + below[r] - below[l]) * (0.25 * per_u);
            out[x] = lean((below[x] - above[x]) * per_v, cross);
        }
    }
}

multiversion! {
    /// Lean along u through the right side of each texel.
    fn flow_u(up: &[f32], here: &[f32], down: &[f32], per_u: f32, per_v: f32, out: &mut [f32]) {
        let n = out.len();
        let (up, here, down) = (&up[..n], &here[..n], &down[..n]);
        for x in 0..n - 1 {
            let cross = (down[x] - up[x] + down[x + 1] - up[x + 1]) * (0.25 * per_v);
            out[x] = lean((here[x + 1] - here[x]) * per_u, cross);
        }
        let x = n - 1;
        let cross = (down[x] - up[x] + down[0] - up[0]) * (0.25 * per_v);
        out[x] = lean((here[0] - here[x]) * per_u, cross);
    }
}

multiversion! {
    /// Minus half of what flows out of each texel.
    fn divergence(upper: &[f32], lower: &[f32], right: &[f32], per_u: f32, per_v: f32, out: &mut [f32]) {
        let n = out.len();
        let (upper, lower, right) = (&upper[..n], &lower[..n], &right[..n]);
        out[0] = -0.5 * ((right[0] - right[n - 1]) * per_u + (lower[0] - upper[0]) * per_v);
        for x in 1..n {
            out[x] = -0.5 * ((right[x] - right[x - 1]) * per_u + (lower[x] - upper[x]) * per_v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Plane;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(radius: f32, domain: &Domain, height: &Plane) -> Plane {
        let node = HeightToCurvature { radius };
        run_node(&node, domain, 0, &[Input::Plane(height)], &Assets::new(), 7).remove(0)
    }

    /// 20 x 10 mm; texels of 0.1 x 0.125 mm.
    const DOMAIN: Domain = Domain { width: 200, height: 80, girth_mm: 20.0, length_mm: 10.0 };

    /// Millimetres of a texel from the middle of `DOMAIN`.
    fn mm(x: usize, y: usize) -> (f64, f64) {
        (0.1 * (x as f64 - 100.0), 0.125 * (y as f64 - 40.0))
    }

    #[test]
    fn a_sphere_has_the_curvature_of_its_radius_also_on_its_flank() {
        for r in [6.0, 15.0] {
            let height = Plane::from_fn(200, 80, |x, y| {
                let (u, v) = mm(x, y);
                (r * r - u * u - v * v).max(0.0).sqrt() as f32
            });
            for radius in [0.0, 0.4] {
                let c = run(radius, &DOMAIN, &height);
                for (x, y) in [(100, 40), (130, 40), (100, 60), (80, 30)] {
                    let got = f64::from(c.at(x, y));
                    assert!((got * r - 1.0).abs() < 0.01, "R {r} radius {radius} at {x} {y}: {got}");
                }
            }
            let bowl = Plane::from_fn(200, 80, |x, y| -height.at(x as i64, y as i64));
            assert!((f64::from(run(0.2, &DOMAIN, &bowl).at(100, 40)) * r + 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_cylinder_has_half_and_a_plane_none() {
        let height = Plane::from_fn(200, 80, |x, _| (225.0 - mm(x, 0).0.powi(2)).sqrt() as f32);
        assert!((run(0.2, &DOMAIN, &height).at(110, 3) * 30.0 - 1.0).abs() < 0.01);
        let tilted = Plane::from_fn(200, 80, |x, _| 0.0625 * x as f32);
        assert!(run(0.2, &DOMAIN, &tilted).at(100, 3).abs() < 1e-4);
        assert!(run(3.0, &DOMAIN, &Plane::filled(200, 80, 1.0)).data().iter().all(|&v| v.abs() < 1e-4));
    }

    /// A Gaussian of standard deviation s leaves exp(-(2 pi s / period)^2 / 2) of a wave.
    #[test]
    fn grain_finer_than_the_radius_fades_by_the_gaussian_law() {
        let wave = Plane::from_fn(200, 80, |x, _| 1e-3 * (std::f32::consts::TAU * x as f32 / 20.0).sin());
        let peak = |radius: f32| num::min_max(run(radius, &DOMAIN, &wave).data()).1;
        let s = 0.5 * 0.8;
        let expected = (-0.5 * (std::f32::consts::TAU * s / 2.0).powi(2)).exp();
        assert!(
            (peak(0.8) / peak(0.0) / expected - 1.0).abs() < 0.05,
            "{} {expected}",
            peak(0.8) / peak(0.0)
        );
    }

    #[test]
    fn wild_heights_and_radii_stay_finite() {
        for scale in [1e-40, 1.0, 1e30, f32::MAX] {
            let height = Plane::from_fn(9, 5, |x, y| if (x * 7 + y * 5) % 9 < 4 { scale } else { -scale });
            for radius in [0.0, 0.1, 20.0] {
                let domain = Domain { width: 9, height: 5, girth_mm: 9.0, length_mm: 5.0 };
                assert!(
                    run(radius, &domain, &height).data().iter().all(|v| v.is_finite()),
                    "{scale} {radius}"
                );
            }
        }
        assert_eq!(run(20.0, &Domain::square(1), &Plane::filled(1, 1, 2.0)).at(0, 0), 0.0);
    }

    #[test]
    fn a_shift_of_the_height_shifts_the_curvature() {
        let height = Plane::from_fn(31, 17, |x, y| ((x * x + 5 * y * x + y) % 13) as f32);
        let domain = Domain { width: 31, height: 17, girth_mm: 6.2, length_mm: 3.4 };
        for radius in [0.0, 0.5, 8.0] {
            let c = run(radius, &domain, &height);
            assert_eq!(c.shifted(11, -6), run(radius, &domain, &height.shifted(11, -6)));
        }
    }
}
