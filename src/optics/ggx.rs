//! Microfacets: the GGX distribution, height-correlated Smith masking, and sampling of visible normals.
//!
//! Directions are in the frame of the surface, z along its normal; `alpha = roughness^2` (Burley 2012; thesis 3.7).

use super::real::Real;

/// `alpha` of a perceptual roughness in [0, 1].
#[inline(always)]
pub fn alpha<F: Real>(roughness: F) -> F {
    roughness.saturate().squared()
}

/// Density of normals per area and solid angle, 1/sr, at the cosine `nh` of normal and half vector.
///
/// `D = alpha^2/(pi (nh^2 (alpha^2 - 1) + 1)^2)` (Trowbridge & Reitz 1975; Walter et al. 2007, eq. 33; thesis 3.6), for
/// alpha > 0; a mirror, alpha 0, has no density: 0 is given.
#[inline(always)]
pub fn density<F: Real>(alpha: F, nh: F) -> F {
    let a2 = alpha.squared();
    let nh = nh.saturate();
    // 1 - nh^2 as a product: the sum cancels for smooth surfaces.
    let t = (F::ONE - nh) * (F::ONE + nh) + nh.squared() * a2;
    if a2 > F::ZERO { a2 / (F::from_f64(std::f64::consts::PI) * t * t) } else { F::ZERO }
}

/// The same density at a unit half vector: its tangential part keeps digits that a cosine near 1 has lost.
#[inline(always)]
pub fn density_at<F: Real>(alpha: F, half: [F; 3]) -> F {
    let a2 = alpha.squared();
    let t = half[0].squared() + half[1].squared() + half[2].squared() * a2;
    if t > F::ZERO { a2 / (F::from_f64(std::f64::consts::PI) * t * t) } else { F::ZERO }
}

/// Visibility `V = G2/(4 nl nv)` of height-correlated Smith masking and shadowing.
///
/// `V = 1/2/(nv sqrt(alpha^2 + (1 - alpha^2) nl^2) + nl sqrt(alpha^2 + (1 - alpha^2) nv^2))` (Heitz 2014, eq. 99). Equation
/// 3.10 of the thesis is this quantity, approximated, under the name G: it must not be divided by 4 nl nv again. 0 where a
/// cosine is not positive.
#[inline(always)]
pub fn visibility<F: Real>(alpha: F, nl: F, nv: F) -> F {
    if !(nl > F::ZERO && nv > F::ZERO) {
        return F::ZERO;
    }
    let a2 = alpha.squared();
    let root = |c: F| (a2 + (F::ONE - a2) * c.squared()).safe_sqrt();
    F::from_f64(0.5) / (nv * root(nl) + nl * root(nv)).max(F::from_f64(1e-30))
}

/// Masking `G1` of one direction, in [0, 1] (Heitz 2014, eq. 43 and 72): `2 c/(c + sqrt(alpha^2 + (1 - alpha^2) c^2))`.
#[inline(always)]
pub fn masking<F: Real>(alpha: F, cosine: F) -> F {
    let (c, a2) = (cosine.saturate(), alpha.squared());
    if c > F::ZERO { (c + c) / (c + (a2 + (F::ONE - a2) * c.squared()).safe_sqrt()) } else { F::ZERO }
}

/// A microfacet normal seen from `view` (unit, z > 0), distributed as the visible ones, by two uniform numbers in [0, 1).
///
/// Source: Dupuy & Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps, listing 3. Density:
/// [`visible_density`]. Alpha 0 gives (0, 0, 1).
#[inline(always)]
pub fn sample_visible<F: Real>(alpha: F, view: [F; 3], random: [F; 2]) -> [F; 3] {
    let v = normalise([view[0] * alpha, view[1] * alpha, view[2]]);
    // A point on the cap above -v.z, added to v.
    let z = (F::ONE - random[0]) * (F::ONE + v[2]) - v[2];
    let radius = ((F::ONE - z) * (F::ONE + z)).safe_sqrt();
    // An angle in (-1/2, 1/2] turns in two halves, for the range of sin and cos.
    let (sin, cos) = (random[1] - F::from_f64(0.5)).sin_cos_half_turns();
    let (sin, cos) = (sin * cos * F::from_f64(2.0), (cos - sin) * (cos + sin));
    let h = [radius * cos + v[0], radius * sin + v[1], z + v[2]];
    normalise([h[0] * alpha, h[1] * alpha, h[2].max(F::ZERO)])
}

/// Density of [`sample_visible`], 1/sr of half vectors: `G1(v) max(0, v.h) D(h)/v.z` (Heitz 2018, eq. 3).
///
/// Divide by `4 v.h` for the density of the reflected direction.
pub fn visible_density<F: Real>(alpha: F, view: [F; 3], half: [F; 3]) -> F {
    let vh = view[0] * half[0] + view[1] * half[1] + view[2] * half[2];
    if !(view[2] > F::ZERO && vh > F::ZERO && half[2] > F::ZERO) {
        return F::ZERO;
    }
    masking(alpha, view[2]) * vh * density(alpha, half[2]) / view[2]
}

#[inline(always)]
fn normalise<F: Real>(v: [F; 3]) -> [F; 3] {
    let length = (v[0].squared() + v[1].squared() + v[2].squared()).safe_sqrt();
    if length > F::ZERO { v.map(|x| x / length) } else { [F::ZERO, F::ZERO, F::ONE] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Midpoints of a grid over the hemisphere, with solid angles.
    fn hemisphere() -> impl Iterator<Item = ([f64; 3], f64)> {
        let (rings, sectors) = (2000, 200);
        (0..rings).flat_map(move |i| {
            // Fine near the pole, where smooth surfaces have their peak: z = 1 - u^3.
            let edge = |i: i32| 1.0 - (f64::from(i) / f64::from(rings)).powi(3);
            let (z, dz) = ((edge(i) + edge(i + 1)) * 0.5, edge(i) - edge(i + 1));
            (0..sectors).map(move |j| {
                let phi = TAU * (f64::from(j) + 0.5) / f64::from(sectors);
                let r = (1.0 - z * z).sqrt();
                ([r * phi.cos(), r * phi.sin(), z], dz * TAU / f64::from(sectors))
            })
        })
    }

    #[test]
    fn projected_area_of_the_normals_is_1() {
        for a in [0.01, 0.1, 0.5, 1.0] {
            let area: f64 = hemisphere().map(|(h, w)| w * h[2] * density(a, h[2])).sum();
            assert!((area - 1.0).abs() < 1e-3, "{a} {area}");
        }
        assert!((density(1.0, 0.3) - 1.0 / PI).abs() < 1e-15);
    }

    #[test]
    fn visible_normals_project_to_the_view() {
        // Heitz 2014, eq. 6: int G1 max(0, v.h) D = v.z, so the density integrates to 1.
        for (a, mu) in [(0.1, 0.9), (0.3, 0.5), (1.0, 0.2)] {
            let view = [(1.0f64 - mu * mu).sqrt(), 0.0, mu];
            let sum: f64 = hemisphere().map(|(h, w)| w * visible_density(a, view, h)).sum();
            assert!((sum - 1.0).abs() < 2e-3, "{a} {mu} {sum}");
        }
    }

    #[test]
    fn samples_have_the_stated_density() {
        // Mean of functions over a regular grid of random numbers against their integral.
        let functions: [fn([f64; 3]) -> f64; 4] =
            [|h| h[2], |h| h[0], |h| h[0] * h[0], |h| f64::from(h[2] < 0.8)];
        for (a, mu) in [(0.2, 0.9), (0.5, 0.4), (1.0, 0.3)] {
            let view = [(1.0f64 - mu * mu).sqrt(), 0.0, mu];
            for f in functions {
                let n = 400;
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
                let sampled: f64 =
                    (0..n * n).map(|i| f(sample_visible(a, view, [at(i / n), at(i % n)]))).sum::<f64>()
                        / f64::from(n * n);
                let exact: f64 = hemisphere().map(|(h, w)| w * visible_density(a, view, h) * f(h)).sum();
                assert!((sampled - exact).abs() < 4e-3, "{a} {mu}: {sampled} {exact}");
            }
        }
    }

    #[test]
    fn visibility_is_reciprocal_and_the_uncorrelated_limit_holds() {
        for (l, v) in [(0.9, 0.2), (0.5, 0.5), (1.0, 1e-6)] {
            assert_eq!(visibility(0.3f64, l, v), visibility(0.3, v, l));
            // A mirror masks nothing: V = 1/(4 nl nv).
            assert!((visibility(0.0, l, v) * 4.0 * l * v - 1.0).abs() < 1e-12);
            // Height-correlated: 1/G2 = 1/G1(l) + 1/G1(v) - 1.
            let g2 = visibility(0.3, l, v) * 4.0 * l * v;
            let separate = 1.0 / masking(0.3, l) + 1.0 / masking(0.3, v) - 1.0;
            assert!((g2 * separate - 1.0).abs() < 1e-12);
        }
        assert_eq!(visibility(0.3, 0.0, 1.0f32), 0.0);
        assert_eq!(sample_visible(0.0f32, [0.6, 0.0, 0.8], [0.3, 0.7]), [0.0, 0.0, 1.0]);
    }
}
