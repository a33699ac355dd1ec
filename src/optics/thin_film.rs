//! One film between two media, at one wavelength: exact, with every limit.
//!
//! The Airy sum `r = (a + b e^(i phi))/(1 + a b e^(i phi))` of the interfaces' amplitudes a, b and `phi = 2 pi D/lambda`,
//! `D = 2 n1 d cos1`, is multiplied out in admittances `x, y, z` of the three media (see [`super::fresnel`]):
//!
//! ```text
//! r = ((x - z) cos(phi/2) + i (x z - y^2) S) / ((x + z) cos(phi/2) + i (x z + y^2) S),   S = sin(phi/2)/y
//! ```
//!
//! which is the characteristic matrix of one layer (Born & Wolf, Principles of Optics, 1.6.2, eq. 51; Macleod, Thin-Film
//! Optical Filters, ch. 2). It is the Airy formula of the thesis (4.1 to 4.13) with the signed product `q = -a b` and
//! without the extra phases of 4.6 and 4.7. Why this form: every square is a sum of terms that are not negative, so R and
//! T come out in [0, 1] each with its own small relative error; only `y^2` is needed, so beyond the critical angle of the
//! film (`y^2 < 0`: cos and S become cosh and sinh, frustrated total reflection) and exactly at it (`S = 2 pi d/lambda`)
//! nothing divides by zero.

use super::fresnel::{self, Polarised, admittance_squared, usable_cosine};
use super::real::Real;

/// Refractive indices that a [`Film`] takes.
pub const INDEX_RANGE: (f64, f64) = (0.1, 10.0);
/// Greatest thickness that a [`Film`] takes, nm.
pub const MAX_THICKNESS_NM: f64 = 1e9;
/// Wavelengths are limited to this range, nm.
pub const WAVELENGTH_RANGE_NM: (f64, f64) = (1.0, 1e6);

/// Wavelength at which indices are given, nm: the sodium D line.
pub const SODIUM_NM: f64 = 589.3;
/// Greatest Cauchy coefficient, nm^2, of either sign.
pub const MAX_DISPERSION_NM2: f64 = 1e5;

/// A film between two media, all without absorption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film<F> {
    n0: F,
    n1: F,
    n2: F,
    d: F,
}

/// Why there can be no such film.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// A refractive index is out of range, or not a number.
    #[error("{name} = {value} is out of range: a refractive index is {} to {}", INDEX_RANGE.0, INDEX_RANGE.1)]
    Index {
        /// `n0`, `n1` or `n2`.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// A Cauchy coefficient is out of range, or not a number.
    #[error("dispersion = {value} nm^2 is out of range: it is {} to {MAX_DISPERSION_NM2}", -MAX_DISPERSION_NM2)]
    Dispersion {
        /// What was given, nm^2.
        value: f64,
    },
    /// A grating is out of range, or has no numbers.
    #[error("{name} = {value} is out of range for a grating")]
    Grating {
        /// `period_nm`, `height_nm` or `direction_rad`.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// The thickness is out of range, or not a number.
    #[error("thickness = {value} nm is out of range: a film is 0 to {MAX_THICKNESS_NM} nm thick")]
    Thickness {
        /// What was given, nm.
        value: f64,
    },
}

/// Reflected and transmitted part of the power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power<F> {
    /// Reflected, in [0, 1].
    pub reflected: F,
    /// Transmitted, in [0, 1]; their sum is 1 but for rounding.
    pub transmitted: F,
}

/// What one polarisation needs for every wavelength.
#[derive(Clone, Copy, Debug)]
pub(super) struct Admittances<F> {
    /// In n0, n0 > 0 and cosine > 0: positive.
    pub(super) x: F,
    /// Square of that in n1; negative beyond the critical angle.
    pub(super) yy: F,
    /// In n2: not negative.
    pub(super) z: F,
}

/// How a direction meets a film.
#[derive(Clone, Copy, Debug)]
pub(super) enum Incidence<F> {
    /// There is no film to speak of: the same at every wavelength.
    Gray(Polarised<Power<F>>),
    /// There is one; the s-admittance of the film is `y`, imaginary if `frustrated`.
    Film {
        /// Absolute value of the s-admittance of the film.
        y: F,
        /// What its rounding lost, for the phase.
        rest: F,
        /// Whether it is imaginary.
        frustrated: bool,
        /// For each polarisation.
        of: Polarised<Admittances<F>>,
    },
}

impl<F: Real> Film<F> {
    /// A film of index `n1` and thickness `thickness_nm` between `n0`, where the light comes from, and `n2`.
    pub fn new(n0: F, n1: F, n2: F, thickness_nm: F) -> Result<Self, FilmError> {
        for (name, n) in [("n0", n0), ("n1", n1), ("n2", n2)] {
            let value = n.to_f64();
            // f32 rounds the ends of the range.
            if !(INDEX_RANGE.0 - 1e-6..=INDEX_RANGE.1 + 1e-6).contains(&value) {
                return Err(FilmError::Index { name, value });
            }
        }
        let value = thickness_nm.to_f64();
        if !(0.0..=MAX_THICKNESS_NM).contains(&value) {
            return Err(FilmError::Thickness { value });
        }
        Ok(Self { n0, n1, n2, d: thickness_nm })
    }

    /// The same film with another thickness, nm, limited to 0 to [`MAX_THICKNESS_NM`]; NaN is 0.
    #[inline(always)]
    pub fn with_thickness(self, thickness_nm: F) -> Self {
        Self { d: thickness_nm.max(F::ZERO).min(F::from_f64(MAX_THICKNESS_NM)), ..self }
    }

    /// The same film at a wavelength, nm, if its indices are those at [`SODIUM_NM`] and film and layer are dispersive.
    ///
    /// `n(lambda) = n + B (1/lambda^2 - 1/589.3^2)` (Cauchy), B in nm^2, for n1 and n2; limited to [`INDEX_RANGE`]. Keratin of
    /// feathers has B = 5890 (Leertouwer, Wilts & Stavenga 2011, Opt. Express 19, 24061).
    #[inline(always)]
    pub fn dispersed(self, dispersion_nm2: [F; 2], wavelength_nm: F) -> Self {
        let f = F::from_f64;
        let (lo, hi) = WAVELENGTH_RANGE_NM;
        let inverse = F::ONE / wavelength_nm.max(f(lo)).min(f(hi));
        let apart = inverse.squared() - f(1.0 / (SODIUM_NM * SODIUM_NM));
        let at = |n: F, b: F| (n + b * apart).max(f(INDEX_RANGE.0)).min(f(INDEX_RANGE.1));
        Self { n1: at(self.n1, dispersion_nm2[0]), n2: at(self.n2, dispersion_nm2[1]), ..self }
    }

    /// Indices n0, n1, n2.
    #[inline(always)]
    pub fn indices(&self) -> [F; 3] {
        [self.n0, self.n1, self.n2]
    }

    /// Thickness, nm.
    #[inline(always)]
    pub fn thickness_nm(&self) -> F {
        self.d
    }

    /// Optical path difference `D = 2 n1 d cos1`, nm, of two successive reflections; `cosine` of the angle in n0.
    ///
    /// Source: Born & Wolf 7.6.1, eq. 6; thesis 4.14 with 4.15 righted (`sin1 = sin0 n0/n1`). 0 beyond the critical angle.
    pub fn path_difference_nm(&self, cosine: F) -> F {
        let x = self.n0 * usable_cosine(cosine);
        F::from_f64(2.0) * self.d * admittance_squared(self.n0, self.n1, x).safe_sqrt()
    }

    /// Power of unpolarised light of `wavelength_nm` (limited to [`WAVELENGTH_RANGE_NM`]); `cosine` of the angle in n0
    /// (limited to [0, 1], NaN is 0). Mean of s and p. Total: no input gives NaN.
    pub fn power(&self, cosine: F, wavelength_nm: F) -> Power<F> {
        let power = self.power_polarised(cosine, wavelength_nm);
        let half = F::from_f64(0.5);
        Power {
            reflected: (power.s.reflected + power.p.reflected) * half,
            transmitted: (power.s.transmitted + power.p.transmitted) * half,
        }
    }

    /// Power for each polarisation.
    ///
    /// `R = |r|^2` of the module's formula and `T = 4 x z/|denominator|^2`, which is 1 - R (thesis 4.12) computed
    /// directly. Thickness 0, n0 = n1 and n1 = n2 are the plain interface n0, n2 exactly; cosine 0 and total reflection at
    /// n1, n2 (`n0 sin0 >= n2`) give R = 1 exactly.
    pub fn power_polarised(&self, cosine: F, wavelength_nm: F) -> Polarised<Power<F>> {
        self.incidence(cosine).power(self.d, wavelength_nm)
    }

    /// Everything that does not depend on the wavelength.
    #[inline(always)]
    pub(super) fn incidence(&self, cosine: F) -> Incidence<F> {
        let Self { n0, n1, n2, d } = *self;
        if d == F::ZERO || n0 == n1 || n1 == n2 {
            let r = fresnel::reflectance_polarised(n0, n2, cosine);
            let t = fresnel::transmittance_polarised(n0, n2, cosine);
            return Incidence::Gray(Polarised {
                s: Power { reflected: r.s, transmitted: t.s },
                p: Power { reflected: r.p, transmitted: t.p },
            });
        }
        let x = n0 * usable_cosine(cosine);
        let zz = if n0 == n2 { x * x } else { admittance_squared(n0, n2, x) };
        // A film of another index hides even n2 = n0 at grazing incidence.
        if x == F::ZERO || zz <= F::ZERO {
            let total = Power { reflected: F::ONE, transmitted: F::ZERO };
            return Incidence::Gray(Polarised { s: total, p: total });
        }
        let z = if n0 == n2 { x } else { zz.safe_sqrt() };
        let yy = admittance_squared(n0, n1, x);
        // Times n1^2 for p: a common factor of x, y and z changes nothing but S, and with this one y_p = y_s, so that one
        // S serves both polarisations.
        let y = yy.abs().safe_sqrt();
        let (p0, p2) = ((n1 / n0).squared(), (n1 / n2).squared());
        Incidence::Film {
            y,
            rest: if yy > F::ZERO { F::root_rest(n0, n1, usable_cosine(cosine), y) } else { F::ZERO },
            frustrated: yy < F::ZERO,
            of: Polarised { s: Admittances { x, yy, z }, p: Admittances { x: x * p0, yy, z: z * p2 } },
        }
    }
}

impl<F: Real> Incidence<F> {
    /// Part of unpolarised light that is reflected, or transmitted, at each of N wavelengths, nm, with their inverses.
    ///
    /// The formula of [`Film::power_polarised`], with what does not depend on the wavelength taken out of the loop, so
    /// that four or eight wavelengths in f32 are one vector each.
    #[inline(always)]
    pub(super) fn unpolarised<const N: usize, const REFLECTED: bool>(
        &self,
        d: F,
        wavelengths_nm: &[F; N],
        inverse: &[F; N],
    ) -> [F; N] {
        let half = F::from_f64(0.5);
        let of = |power: Polarised<Power<F>>| match REFLECTED {
            true => (power.s.reflected + power.p.reflected) * half,
            false => (power.s.transmitted + power.p.transmitted) * half,
        };
        let (y, rest, of) = match *self {
            Self::Gray(power) => return [of(power); N],
            Self::Film { y, rest, frustrated: false, of } if y > F::ZERO => (y, rest, of),
            Self::Film { .. } => return self.frustrated::<N, REFLECTED>(d, wavelengths_nm),
        };
        let over = F::ONE / y;
        // Coefficients of cos^2 and sin^2 in the numerator and the denominator.
        let coefficients = |Admittances { x, yy, z }: Admittances<F>| {
            let xz = x * z;
            let four = F::from_f64(4.0) * xz;
            let (p, q) = ((x - z).squared(), ((xz - yy) * over).squared());
            let (num_p, num_q) = if REFLECTED { (p, q) } else { (four, four) };
            (num_p, num_q, (x + z).squared(), ((xz + yy) * over).squared())
        };
        let (s, p) = (coefficients(of.s), coefficients(of.p));
        let mut out = [F::ZERO; N];
        for i in 0..N {
            let ss = F::phase_sine_squared(d, y, rest, wavelengths_nm[i], inverse[i]).min(F::ONE);
            let cc = F::ONE - ss;
            let rs = (s.0 * cc + s.1 * ss) / (s.2 * cc + s.3 * ss);
            let rp = (p.0 * cc + p.1 * ss) / (p.2 * cc + p.3 * ss);
            out[i] = ((rs + rp) * half).min(F::ONE);
        }
        out
    }

    /// The same beyond the critical angle of the film: rare, and kept out of the way.
    #[cold]
    #[inline(never)]
    fn frustrated<const N: usize, const REFLECTED: bool>(&self, d: F, wavelengths_nm: &[F; N]) -> [F; N] {
        wavelengths_nm.map(|l| {
            let power = self.power(d, l);
            let of = |p: Power<F>| if REFLECTED { p.reflected } else { p.transmitted };
            (of(power.s) + of(power.p)) * F::from_f64(0.5)
        })
    }

    /// Power at one wavelength, nm, of a film of thickness `d`, nm.
    #[inline]
    pub(super) fn power(&self, d: F, wavelength_nm: F) -> Polarised<Power<F>> {
        let (y, rest, frustrated, of) = match *self {
            Self::Gray(power) => return power,
            Self::Film { y, rest, frustrated, of } => (y, rest, frustrated, of),
        };
        let (lo, hi) = WAVELENGTH_RANGE_NM;
        let lambda = wavelength_nm.max(F::from_f64(lo)).min(F::from_f64(hi));
        // 2 pi d/lambda: the limit of S where y is 0.
        let k = F::from_f64(std::f64::consts::TAU) * d / lambda;
        // cc is cos^2 or, over cosh^2, 1; s is S, likewise over cosh; tt is what 4 x z is multiplied by.
        let (cc, s, tt) = if frustrated {
            let kappa = k * y;
            let t = kappa.tanh();
            // sech^2 without the cancellation of 1 - tanh^2.
            let e = (-(kappa + kappa)).exp();
            let sech2 = F::from_f64(4.0) * e / (F::ONE + e).squared();
            (F::ONE, if y > F::ZERO { t / y } else { k }, sech2)
        } else {
            // Reduced in turns, where it is exact, before the cosine: a film of millimetres has thousands of them.
            let (sin, cos) = F::reduced_turns(d, y, rest, lambda).sin_cos_half_turns();
            (cos.squared(), if y > F::ZERO { sin / y } else { k }, F::ONE)
        };
        let ss = s.squared();
        let power = |Admittances { x, yy, z }: Admittances<F>| {
            let xz = x * z;
            let num = (x - z).squared() * cc + (xz - yy).squared() * ss;
            let den = (x + z).squared() * cc + (xz + yy).squared() * ss;
            Power {
                reflected: (num / den).min(F::ONE),
                transmitted: (F::from_f64(4.0) * xz * tt / den).min(F::ONE),
            }
        };
        Polarised { s: power(of.s), p: power(of.p) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn r(n: [f64; 3], d: f64, cosine: f64) -> f64 {
        Film::new(n[0], n[1], n[2], d).expect("a film").power(cosine, 550.0).reflected
    }

    const SNAKE: [f64; 3] = [1.0, 1.55, 2.0];

    #[test]
    fn extreme_cases_have_their_known_values() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        for (c, expected) in [(1.0, 0.111111), (0.5, 0.161377), (0.1, 0.592433)] {
            near(r(SNAKE, 0.0, c), expected);
        }
        for n in [[1.0, 1.0, 1.5], [1.0, 1.5, 1.5]] {
            near(r(n, 321.0, 0.6), 0.064525);
        }
        assert!(r([1.4; 3], 300.0, 0.3) < 1e-15);
        // Quarter wave, half wave, and an antireflection film.
        near(r([1.0, 1.5, 1.0], 550.0 / 6.0, 1.0), 0.147929);
        near(r([1.0, 1.5, 1.0], 550.0 / 3.0, 1.0), 0.0);
        let root = 2f64.sqrt();
        assert!(r([1.0, root, 2.0], 550.0 / 4.0 / root, 1.0) < 1e-15);
        for (c, expected) in [(1e-2, 0.945640), (1e-3, 0.994404), (1e-6, 0.999994)] {
            near(r(SNAKE, 400.0, c), expected);
        }
        assert_eq!(r(SNAKE, 400.0, 0.0), 1.0);
        assert!(((1.0 - r(SNAKE, 400.0, 1e-9)) / 1e-9 - 5.6146).abs() < 1e-4);
        // Frustrated total reflection.
        let deg45 = 0.5f64.sqrt();
        let frustrated = [
            (0.0, 0.0),
            (10.0, 0.003141),
            (50.0, 0.072970),
            (100.0, 0.240498),
            (300.0, 0.792268),
            (1000.0, 0.999205),
            (1e5, 1.0),
        ];
        for (d, expected) in frustrated {
            near(r([1.5, 1.0, 1.5], d, deg45), expected);
        }
        let critical = (1.0 - 1.0 / 2.25f64).sqrt();
        for (d, expected) in [(0.0, 0.0), (50.0, 0.056134), (300.0, 0.603097), (1000.0, 0.932822)] {
            near(r([1.5, 1.0, 1.5], d, critical), expected);
        }
        assert_eq!(r([2.0, 2.2, 1.0], 400.0, 0.3), 1.0);
    }

    #[test]
    fn the_limit_at_the_critical_angle_is_met_from_both_sides() {
        let at = |c: f64| r([1.5, 1.0, 1.5], 300.0, c);
        let critical = (1.0 - 1.0 / 2.25f64).sqrt();
        for step in [1e-3, 1e-6, 1e-9, 1e-12, 0.0] {
            assert!((at(critical - step) - at(critical)).abs() <= 20.0 * step + 1e-14, "{step}");
            assert!((at(critical + step) - at(critical)).abs() <= 20.0 * step + 1e-14, "{step}");
        }
    }

    #[test]
    fn thickness_0_and_equal_indices_are_the_plain_interface_exactly() {
        for i in 0..=1000u16 {
            let c = f32::from(i) / 1000.0;
            for (n0, n2) in [(1.0f32, 2.0f32), (1.0, 1.0), (1.5, 1.0), (1.33, 1.33)] {
                let plain = fresnel::reflectance(n0, n2, c);
                for (n1, d) in [(1.55, 0.0), (n0, 400.0), (n2, 400.0)] {
                    let film = Film::new(n0, n1, n2, d).expect("a film");
                    assert_eq!(film.power(c, 480.0).reflected, plain);
                    let c = f64::from(c);
                    let film = Film::new(f64::from(n0), f64::from(n1), f64::from(n2), f64::from(d));
                    let power = film.expect("a film").power(c, 480.0).reflected;
                    assert_eq!(power, fresnel::reflectance(f64::from(n0), f64::from(n2), c));
                }
            }
        }
    }

    #[test]
    fn a_vanishing_film_tends_to_the_plain_interface() {
        for c in [1e-6, 0.01, 0.3, 1.0] {
            let plain = fresnel::reflectance(1.0, 2.0, c);
            assert!((r(SNAKE, 1e-9, c) - plain).abs() < 1e-11);
        }
    }

    #[test]
    fn the_sum_of_many_internal_reflections_is_the_same() {
        // Born & Wolf 7.6.1: amplitudes of the beams added one by one, a = r01, b = r12, r10 = -a.
        for i in 1..50 {
            let c = f64::from(i) / 50.0;
            let film = Film::new(1.0, 1.55, 2.0, 700.0).expect("a film");
            let c1 = (1.0 - (1.0 - c * c) / 1.55f64.powi(2)).sqrt();
            let (a, b) = (fresnel::amplitude(1.0, 1.55, c), fresnel::amplitude(1.55, 2.0, c1));
            let power = film.power_polarised(c, 500.0);
            for (a, b, power) in [(a.s.re, b.s.re, power.s), (a.p.re, b.p.re, power.p)] {
                let phi = std::f64::consts::TAU * film.path_difference_nm(c) / 500.0;
                let (mut re, mut im) = (a, 0.0);
                for m in 1..200 {
                    let beam = (1.0 - a * a) * b * (-a * b).powi(m - 1);
                    re += beam * (phi * f64::from(m)).cos();
                    im += beam * (phi * f64::from(m)).sin();
                }
                assert!((re * re + im * im - power.reflected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_film_that_cannot_be_is_refused() {
        assert!(matches!(Film::new(1.0, f64::NAN, 2.0, 1.0), Err(FilmError::Index { name: "n1", .. })));
        assert!(matches!(Film::new(0.0f32, 1.0, 2.0, 1.0), Err(FilmError::Index { name: "n0", .. })));
        for d in [-1.0, f64::NAN, f64::INFINITY, 2e9] {
            assert!(matches!(Film::new(1.0, 1.5, 2.0, d), Err(FilmError::Thickness { .. })));
        }
    }
}
