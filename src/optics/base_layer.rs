//! The base below the layers: how much of the light that enters is sent back, over the angle it came from.
//!
//! A [`Base`] is a curve `w(c)` of the cosine `c = n.l` in [-1, 1] in place of Lambert's `max(c, 0)`, with the same integral
//! over the sphere, pi: no form makes light. All but Lambert's light the far side, too, and are not reciprocal, so they are
//! options for fast viewers and never the default.

use super::real::Real;

/// What the base is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Base {
    /// Matt: `w = max(c, 0)`.
    #[default]
    Lambert,
    /// Squared half-Lambert, tinted where light grazes and behind: thin skin.
    HalfLambert {
        /// Factor for red, green, blue where the tint is full, in [0, 1]: the colour of blood; (1, 1, 1) is no tint.
        blood: [f32; 3],
        /// Where it begins.
        tint: Tint,
    },
    /// Light that spreads in the flesh below a surface of some curvature, and comes through flesh that is thin: d'Eon's six
    /// Gaussians of human skin.
    Curved {
        /// Curvature, 1 over the radius, 1/mm, >= 0; 0 is flat, which is Lambert's.
        curvature_per_mm: f32,
        /// Thickness of the flesh as measured, mm, >= 0: light of the far side comes through. From 30 mm on, or NaN, it is
        /// a solid body, through which none does; 0 is nothing, through which all does.
        thickness_mm: f32,
    },
}

/// Where the blood tint of [`Base::HalfLambert`] begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tint {
    /// With the first degree, full at 90 degrees: what the shader of the earlier work computes.
    #[default]
    FromNormal,
    /// At 90 degrees, full at 180: what its text says.
    FromHorizon,
}

/// Variances of the Gaussians, mm^2 (d'Eon, Luebke & Enderton 2007, Efficient Rendering of Human Skin, fig. 5).
const VARIANCES_MM2: [f64; 6] = [0.0064, 0.0484, 0.187, 0.567, 1.99, 7.41];
/// Their weights in red, green, blue; each channel sums to 1.
const WEIGHTS: [[f64; 6]; 3] = [
    [0.233, 0.1, 0.118, 0.113, 0.358, 0.078],
    [0.455, 0.336, 0.198, 0.007, 0.004, 0.0],
    [0.649, 0.344, 0.0, 0.007, 0.0, 0.0],
];

/// Thickness that lets nothing through, mm: `e^(-30^2/(4 7.41))` is 6e-14.
const SOLID_MM: f32 = 30.0;

impl Base {
    /// Whether light from below the horizon counts.
    pub fn wraps(&self) -> bool {
        *self != Self::Lambert
    }

    /// Whether light of the far side comes through.
    pub fn lets_through(&self) -> bool {
        matches!(self, Self::Curved { thickness_mm, .. } if *thickness_mm < SOLID_MM)
    }

    /// `w(c)` for red, green, blue; >= 0: the sum of both [`Base::sides`]. Integral over the sphere: pi (Lambert's; for
    /// [`Base::Curved`] to 0.2 %).
    pub fn weight<F: Real>(&self, cosine: F) -> [F; 3] {
        let [near, far] = self.sides(cosine);
        std::array::from_fn(|i| near[i] + far[i])
    }

    /// `w(c)` in two: of light that enters on this side, at a cosine of `(1 + c)/2` where the base wraps, and of light that
    /// enters on the far side, at `(1 - c)/2`, and comes through.
    ///
    /// Half-Lambert: `((1 + c)/2)^2 (1 - (1 - b) x)` with `x = clamp(1 - c)`, times `24/(17 + 15 b)`, or `x = clamp(-c)`,
    /// times `24/(31 + b)`; without tint both are `3/4 ((1 + c)/2)^2`.
    ///
    /// Curved: the clamped cosine after diffusion on a sphere, `sum_j wt_j (1 - t_j) Z(c, s2_j)`, `s2_j = v_j curvature^2`,
    /// and what is taken out of it for the far side, `sum_j wt_j t_j Z(-c, s2_j)`, `t_j = e^(-thickness^2/(4 v_j))`. Z(c) and
    /// Z(-c) have one integral, so that of the sum does not depend on the thickness.
    pub fn sides<F: Real>(&self, cosine: F) -> [[F; 3]; 2] {
        let f = F::from_f64;
        let c = cosine.max(-F::ONE).min(F::ONE);
        let none = [F::ZERO; 3];
        match *self {
            Self::Lambert => [[c.max(F::ZERO); 3], none],
            Self::HalfLambert { blood, tint } => {
                let near = blood.map(|b| {
                    let b = f(f64::from(b)).saturate();
                    let (x, scale) = match tint {
                        Tint::FromNormal => (F::ONE - c, f(24.0) / (f(17.0) + f(15.0) * b)),
                        Tint::FromHorizon => (-c, f(24.0) / (f(31.0) + b)),
                    };
                    ((F::ONE + c) * f(0.5)).squared() * (F::ONE - (F::ONE - b) * x.saturate()) * scale
                });
                [near, none]
            }
            Self::Curved { curvature_per_mm, thickness_mm } => {
                let squared = f(f64::from(curvature_per_mm).max(0.0).min(1e6)).squared();
                let mixed = |each: [F; 6]| {
                    WEIGHTS.map(|weights| (0..6).fold(F::ZERO, |sum, j| sum + f(weights[j]) * each[j]))
                };
                let spread = |c: F| VARIANCES_MM2.map(|v| spread(c, f(v) * squared));
                if !self.lets_through() {
                    return [mixed(spread(c)), none];
                }
                let depth = f(f64::from(thickness_mm).max(0.0)).squared();
                let through = VARIANCES_MM2.map(|v| (depth * f(0.25 / v)).decay());
                let (near, far) = (spread(c), spread(-c));
                [
                    mixed(std::array::from_fn(|j| (F::ONE - through[j]) * near[j])),
                    mixed(std::array::from_fn(|j| through[j] * far[j])),
                ]
            }
        }
    }
}

/// The clamped cosine, spread on the unit sphere by the heat kernel of variance `s2`.
///
/// Nearly flat (`s2 < 0.05`): `e^(-s2) (c Phi(c/s) + s phi(c/s))`, the normal distribution and its density. Else Legendre
/// polynomials, `sum_l a_l e^(-l (l + 1) s2/2) P_l(c)` with those of the clamped cosine. Right to 0.0043; never negative.
fn spread<F: Real>(c: F, s2: F) -> F {
    let f = F::from_f64;
    if s2 <= F::ZERO {
        return c.max(F::ZERO);
    }
    if s2 < f(0.05) {
        let s = s2.safe_sqrt();
        let x = c / s;
        let density = f(0.398_942_280_401_432_7) * (x.squared() * f(0.5)).decay();
        return (s2.decay() * (c * normal_distribution(x) + s * density)).max(F::ZERO);
    }
    const A: [f64; 7] = [0.25, 0.5, 0.3125, 0.0, -0.093_75, 0.0, 0.050_781_25];
    let (mut sum, mut before, mut now) = (f(A[0]), F::ONE, c);
    for (l, a) in A.iter().enumerate().skip(1) {
        let order = l as f64;
        sum += f(*a) * (s2 * f(order * (order + 1.0) * 0.5)).decay() * now;
        (before, now) = (now, (f(2.0 * order + 1.0) * c * now - f(order) * before) * f(1.0 / (order + 1.0)));
    }
    sum.max(F::ZERO)
}

/// The normal distribution function (Abramowitz & Stegun 26.2.17, error below 7.5e-8).
fn normal_distribution<F: Real>(x: F) -> F {
    let f = F::from_f64;
    let z = x.abs();
    let t = F::ONE / (F::ONE + f(0.231_641_9) * z);
    let poly = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530]
        .iter()
        .fold(F::ZERO, |sum, c| sum * t + f(*c))
        * t;
    let tail = f(0.398_942_280_401_432_7) * (z.squared() * f(0.5)).decay() * poly;
    if x > F::ZERO { F::ONE - tail } else { tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::quadrature::gauss_legendre;

    /// `2 int_-1^1 w dc`, which is 1 for Lambert's: energy over pi, in parts that end where forms have a kink.
    fn energy(base: Base) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (x, w) in gauss_legendre(200) {
            for c in [x, -x] {
                let weight = base.weight(c);
                (0..3).for_each(|i| sum[i] += 2.0 * w * weight[i]);
            }
        }
        sum
    }

    #[test]
    fn no_base_makes_light() {
        let blood = [0.6, 0.0, 1.0];
        let exact = [
            Base::Lambert,
            Base::HalfLambert { blood, tint: Tint::FromNormal },
            Base::HalfLambert { blood, tint: Tint::FromHorizon },
        ];
        for base in exact {
            for e in energy(base) {
                assert!((e - 1.0).abs() < 1e-7, "{base:?} {e}");
            }
        }
        for curvature_per_mm in [0.0, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 10.0, 1e9] {
            for e in energy(solid(curvature_per_mm)) {
                assert!((e - 1.0).abs() < 2e-3, "{curvature_per_mm} {e}");
            }
            // What comes through is taken out: not a bit of energy depends on the thickness.
            for thickness_mm in [0.0, 0.05, 0.3, 1.0, 2.5, 10.0, 1e9, f32::INFINITY] {
                let thin = energy(Base::Curved { curvature_per_mm, thickness_mm });
                for (e, solid) in thin.into_iter().zip(energy(solid(curvature_per_mm))) {
                    assert!((e - solid).abs() < 1e-12, "{curvature_per_mm} {thickness_mm} {e} {solid}");
                }
            }
        }
    }

    fn solid(curvature_per_mm: f32) -> Base {
        Base::Curved { curvature_per_mm, thickness_mm: f32::INFINITY }
    }

    #[test]
    fn light_comes_through_thin_flesh_and_red_the_farthest() {
        // Flat and lit from straight behind, what comes through is the sum of Gaussians itself.
        for thickness_mm in [0.0f32, 0.1, 0.5, 1.0, 3.0] {
            let w = Base::Curved { curvature_per_mm: 0.0, thickness_mm }.weight(-1.0);
            for (w, weights) in w.into_iter().zip(WEIGHTS) {
                let x = f64::from(thickness_mm);
                let exact: f64 =
                    weights.iter().zip(VARIANCES_MM2).map(|(k, v)| k * libm::exp(-x * x / (4.0 * v))).sum();
                assert!((w - exact).abs() < 1e-12, "{thickness_mm} {w} {exact}");
            }
            assert!(thickness_mm == 0.0 || (w[0] > w[1] && w[1] > w[2]), "{thickness_mm} {w:?}");
        }
        for i in -10..=10 {
            let c = f64::from(i) / 10.0;
            // Nothing in between: the far side's light, all of it. A body: none of it.
            let none = Base::Curved { curvature_per_mm: 0.2, thickness_mm: 0.0 }.weight(c);
            assert_eq!(none, solid(0.2).weight(-c));
            let thick = Base::Curved { curvature_per_mm: 0.2, thickness_mm: 29.9 }.weight(c);
            assert!(thick.into_iter().zip(solid(0.2).weight(c)).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        // The comparison is no tautology: thin flesh is not a body.
        let thin = Base::Curved { curvature_per_mm: 0.2, thickness_mm: 1.0 };
        assert!(thin.weight(-0.8)[0] > 2.0 * solid(0.2).weight(-0.8)[0]);
    }

    #[test]
    fn tints_have_their_closed_forms() {
        let scale = |blood: f32, tint: Tint| {
            let raw = |c: f64| {
                let x = if tint == Tint::FromNormal { 1.0 - c } else { -c };
                ((1.0 + c) / 2.0).powi(2) * (1.0 - (1.0 - f64::from(blood)) * x.clamp(0.0, 1.0))
            };
            Base::HalfLambert { blood: [blood; 3], tint }.weight(0.3)[0] / raw(0.3)
        };
        for (blood, tint, expected) in [
            (0.6, Tint::FromNormal, 0.923077),
            (0.0, Tint::FromNormal, 1.411765),
            (0.6, Tint::FromHorizon, 0.759494),
            (0.0, Tint::FromHorizon, 0.774194),
            (1.0, Tint::FromNormal, 0.75),
            (1.0, Tint::FromHorizon, 0.75),
        ] {
            assert!((scale(blood, tint) - expected).abs() < 1e-6, "{blood} {tint:?}");
        }
    }

    #[test]
    fn flat_is_lambert_and_a_small_ball_is_even() {
        for i in -10..=10 {
            let c = f64::from(i) / 10.0;
            for w in solid(0.0).weight(c) {
                assert!((w - c.max(0.0)).abs() < 1e-15, "{c} {w}");
            }
            for w in solid(1e3).weight(c) {
                assert!((w - 0.25).abs() < 1e-9, "{c} {w}");
            }
        }
    }

    #[test]
    fn the_two_forms_of_spreading_meet() {
        // Against many more Legendre polynomials: a_l = int_0^1 c P_l dc (2 l + 1)/2.
        let legendre = |l: usize, c: f64| {
            (1..=l).fold((0.0, 1.0), |(before, now), k| {
                let k = k as f64;
                (now, ((2.0 * k - 1.0) * c * now - (k - 1.0) * before) / k)
            })
        };
        for s2 in [0.01, 0.03, 0.049, 0.051, 0.1, 0.4] {
            for i in -10..=10 {
                let c = f64::from(i) / 10.0;
                let exact: f64 = (0..60)
                    .map(|l| {
                        let order = l as f64;
                        let a: f64 = gauss_legendre(40).iter().map(|(x, w)| w * x * legendre(l, *x).1).sum();
                        a * (order + 0.5) * libm::exp(-order * (order + 1.0) * s2 / 2.0) * legendre(l, c).1
                    })
                    .sum();
                assert!((spread(c, s2) - exact).abs() < 0.0045, "{s2} {c}: {} {exact}", spread(c, s2));
            }
        }
    }

    #[test]
    fn the_normal_distribution_has_its_known_values() {
        for (x, p) in [(0.0, 0.5), (1.0, 0.841344746), (-1.0, 0.158655254), (3.0, 0.998650102)] {
            assert!((normal_distribution(x) - p).abs() < 1e-7);
        }
    }

    #[test]
    fn weights_are_never_negative() {
        for i in 0..=2000i16 {
            let c = f32::from(i) / 1000.0 - 1.0;
            for curvature_per_mm in [0.0, 0.1, 0.3, 0.5, 1.0, 2.0, f32::INFINITY, f32::NAN] {
                for thickness_mm in [0.0, 0.4, 3.0, f32::INFINITY, f32::NAN] {
                    for w in (Base::Curved { curvature_per_mm, thickness_mm }).weight(c) {
                        assert!((0.0..=1.1).contains(&w), "{c} {curvature_per_mm} {thickness_mm} {w}");
                    }
                }
            }
        }
    }
}
