//! A plain interface of two dielectrics.
//!
//! Written in admittances: for s-polarised light `x = n0 cos0, y = n1 cos1`, for p-polarised light `x = cos0/n0,
//! y = cos1/n1`. Then both polarisations have the same formulas, with no angle in medium 1 and no cancellation.

use super::real::Real;

/// A value for each polarisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Polarised<T> {
    /// Electric field across the plane of incidence.
    pub s: T,
    /// Electric field in the plane of incidence.
    pub p: T,
}

impl<T: Real> Polarised<T> {
    /// Mean of both: unpolarised light.
    #[inline(always)]
    pub fn mean(self) -> T {
        (self.s + self.p) * T::from_f64(0.5)
    }
}

/// A complex amplitude ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amplitude<F> {
    /// Real part.
    pub re: F,
    /// Imaginary part; 0 but for total reflection. Time goes as `exp(-i omega t)`.
    pub im: F,
}

/// Square of the s-admittance `n cos` in a medium of index `n`, from that in n0, `x = n0 cos0`.
///
/// `(n cos)^2 = n^2 - n0^2 sin0^2 = (n - n0)(n + n0) + (n0 cos0)^2` (Snell's law; Born & Wolf, Principles of Optics,
/// 1.5.1). Negative beyond the critical angle, where the wave is evanescent.
#[inline(always)]
pub(super) fn admittance_squared<F: Real>(n0: F, n: F, x: F) -> F {
    (n - n0) * (n + n0) + x * x
}

/// Cosine as the formulas take it: in [0, 1], and not so small that squares underflow. NaN gives 0.
#[inline(always)]
pub(super) fn usable_cosine<F: Real>(cosine: F) -> F {
    let c = cosine.saturate();
    if c > F::ZERO { c.max(F::LEAST_COSINE) } else { c }
}

/// Amplitude reflection from n0 to n1; `cosine` of the angle in n0, limited to [0, 1].
///
/// `r = (x - y)/(x + y)` with the admittances of this module: `r_s = (n0 c0 - n1 c1)/(n0 c0 + n1 c1)`,
/// `r_p = (n1 c0 - n0 c1)/(n1 c0 + n0 c1)` (Fresnel; Born & Wolf 1.5.2, eq. 21; thesis 4.1, 4.2). At normal incidence
/// r_s = -r_p, as in those books. Beyond the critical angle `y = i eta` and `r = (x - i eta)/(x + i eta)`: modulus 1, a phase only.
pub fn amplitude<F: Real>(n0: F, n1: F, cosine: F) -> Polarised<Amplitude<F>> {
    let x = n0 * usable_cosine(cosine);
    let square = admittance_squared(n0, n1, x);
    let of = |x: F, y: F| {
        if n0 == n1 {
            return Amplitude::default();
        }
        if square >= F::ZERO {
            return Amplitude { re: (x - y) / (x + y), im: F::ZERO };
        }
        let norm = x * x + y * y;
        Amplitude { re: (x - y) * (x + y) / norm, im: -(x * y + x * y) / norm }
    };
    let y = square.abs().safe_sqrt();
    Polarised { s: of(x, y), p: of(x / (n0 * n0), y / (n1 * n1)) }
}

/// Power reflectance from n0 to n1; `cosine` of the angle in n0, limited to [0, 1].
///
/// `R = ((x - y)/(x + y))^2`, and 1 beyond the critical angle (Born & Wolf 1.5.3, eq. 33). Exactly 0 for n0 = n1 and
/// exactly 1 for cosine 0 otherwise.
#[inline(always)]
pub fn reflectance_polarised<F: Real>(n0: F, n1: F, cosine: F) -> Polarised<F> {
    if n0 == n1 {
        return Polarised { s: F::ZERO, p: F::ZERO };
    }
    let x = n0 * usable_cosine(cosine);
    let square = admittance_squared(n0, n1, x);
    if square <= F::ZERO {
        return Polarised { s: F::ONE, p: F::ONE };
    }
    let y = square.safe_sqrt();
    let of = |x: F, y: F| ((x - y) / (x + y)).squared();
    Polarised { s: of(x, y), p: of(x / (n0 * n0), y / (n1 * n1)) }
}

/// Power reflectance for unpolarised light: the mean of s and p.
#[inline(always)]
pub fn reflectance<F: Real>(n0: F, n1: F, cosine: F) -> F {
    reflectance_polarised(n0, n1, cosine).mean()
}

/// Power transmittance from n0 to n1 for each polarisation.
///
/// `T = 4 x y/(x + y)^2` (Born & Wolf 1.5.3, eq. 34): not 1 - R, which would cancel near grazing.
#[inline(always)]
pub fn transmittance_polarised<F: Real>(n0: F, n1: F, cosine: F) -> Polarised<F> {
    if n0 == n1 {
        return Polarised { s: F::ONE, p: F::ONE };
    }
    let x = n0 * usable_cosine(cosine);
    let y = admittance_squared(n0, n1, x).safe_sqrt();
    // At most 1 whatever the rounding.
    let of = |x: F, y: F| {
        if y > F::ZERO { (F::from_f64(4.0) * x * y / (x + y).squared()).min(F::ONE) } else { F::ZERO }
    };
    Polarised { s: of(x, y), p: of(x / (n0 * n0), y / (n1 * n1)) }
}

/// Power transmittance for unpolarised light.
#[inline(always)]
pub fn transmittance<F: Real>(n0: F, n1: F, cosine: F) -> F {
    transmittance_polarised(n0, n1, cosine).mean()
}

/// Schlick's approximation `F0 + (1 - F0)(1 - cos)^5` (Schlick 1994; thesis 3.8), for comparison only: it is off by up
/// to 0.060, 0.033, 0.035 and 0.044 for n = 1.33, 1.55, 1.8 and 2.0.
#[inline]
pub fn schlick<F: Real>(f0: F, cosine: F) -> F {
    let m = F::ONE - cosine.saturate();
    f0 + (F::ONE - f0) * m * m.squared().squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_brewster_and_grazing_are_the_known_values() {
        assert!((reflectance(1.0, 1.5, 1.0f64) - 0.04).abs() < 1e-15);
        // Brewster: tan = n1/n0.
        let brewster = 1.0 / (1.0f64 + 1.5 * 1.5).sqrt();
        assert!(reflectance_polarised(1.0, 1.5, brewster).p < 1e-30);
        for (n0, n1) in [(1.0, 1.5), (1.5, 1.0)] {
            assert_eq!(reflectance(n0, n1, 0.0f64), 1.0);
            assert_eq!(reflectance(n0 as f32, n1 as f32, 0.0), 1.0);
        }
        assert_eq!(reflectance(1.3f32, 1.3, 0.0), 0.0);
    }

    #[test]
    fn amplitudes_are_those_of_the_textbook_formulas_with_sines() {
        for i in 1..100 {
            let (n0, n1, c) = (1.0, 1.7, f64::from(i) / 100.0);
            let c1 = (1.0 - (1.0 - c * c) * (n0 / n1) * (n0 / n1)).sqrt();
            let r = amplitude(n0, n1, c);
            assert!((r.s.re - (n0 * c - n1 * c1) / (n0 * c + n1 * c1)).abs() < 1e-15);
            assert!((r.p.re - (n1 * c - n0 * c1) / (n1 * c + n0 * c1)).abs() < 1e-15);
        }
    }

    #[test]
    fn total_reflection_is_a_pure_phase_that_grows_from_the_critical_angle() {
        let critical = (1.0 - 1.0 / 2.25f64).sqrt();
        let mut before = (0.0, 0.0);
        for i in 1..=50 {
            let r = amplitude(1.5, 1.0, critical * (1.0 - f64::from(i) / 50.0));
            for a in [r.s, r.p] {
                assert!((a.re * a.re + a.im * a.im - 1.0).abs() < 1e-14);
            }
            // Born & Wolf 1.5.4: tan(phase/2) = sqrt(sin^2 - n^2)/cos for s.
            let phase = (-r.s.im.atan2(r.s.re), -r.p.im.atan2(r.p.re));
            assert!(phase.0 > before.0 && phase.1 > before.1, "{i}");
            before = phase;
            assert_eq!(reflectance(1.5, 1.0, critical * (1.0 - f64::from(i) / 50.0)), 1.0);
        }
    }

    #[test]
    fn what_is_not_reflected_is_transmitted_both_ways() {
        for i in 1..1000 {
            let (n0, n1, c) = (1.0, 1.6, f64::from(i) / 1000.0);
            assert!((reflectance(n0, n1, c) + transmittance(n0, n1, c) - 1.0).abs() < 2e-15);
            let c1 = (1.0 - (1.0 - c * c) / (n1 * n1)).sqrt();
            assert!((reflectance(n0, n1, c) - reflectance(n1, n0, c1)).abs() < 1e-11);
        }
    }

    #[test]
    fn schlick_is_off_by_the_stated_amount() {
        for (n, error) in [(1.33f64, 0.060), (1.55, 0.033), (1.8, 0.035), (2.0, 0.044)] {
            let f0 = ((n - 1.0) / (n + 1.0)).powi(2);
            let worst = (0..=9000)
                .map(|i| (f64::from(i) / 100.0).to_radians().cos())
                .map(|c| (schlick(f0, c) - reflectance(1.0, n, c)).abs())
                .fold(0.0, f64::max);
            assert!((worst - error).abs() < 6e-4, "{n}: {worst}");
        }
    }
}
