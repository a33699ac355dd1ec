//! What viewers do: the series of Belcour and Barla, whose transform of the observer is a sum of Gaussians.
//!
//! Source: Belcour & Barla 2017, A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence
//! (ACM TOG 36, 4), sec. 4 and its supplemental code; the short form is that of the glTF extension
//! `KHR_materials_iridescence` (its implementation notes). The observer is that of equal energy, so white comes out as
//! (1.205, 0.948, 0.909): the oscillating part of a colour has a cast, the mean has none.

use std::f64::consts::TAU;

use super::super::cie;
use super::super::fresnel::schlick;
use super::super::real::Real;
use super::super::thin_film::Film;

/// The Gaussians of the fit: which of X, Y, Z; height, centre in 1/m, variance in 1/m^2.
const GAUSSIANS: [(usize, f64, f64, f64); 4] = [
    (0, 5.4856e-13, 1.6810e6, 4.3278e9),
    (1, 4.4201e-13, 1.7953e6, 9.3046e9),
    (2, 5.2481e-13, 2.2084e6, 6.6121e9),
    (0, 9.7470e-14, 2.2399e6, 4.5282e9),
];
/// What the heights are divided by.
const NORM: f64 = 1.0685e-7;

/// One Gaussian as it is evaluated.
#[derive(Clone, Copy, Debug, Default)]
struct Lobe<F> {
    /// Share of it in red, green, blue.
    rgb: [F; 3],
    /// Turns per nm of path difference.
    turns: F,
    /// Falls off as `exp(-(x width)^2)`, 1/nm.
    width: F,
}

/// The fit, for path differences in nm.
#[derive(Clone, Debug)]
pub(super) struct Fit<F> {
    lobes: [Lobe<F>; 4],
}

impl<F: Real> Fit<F> {
    /// The fit as published, or with white made (1, 1, 1).
    pub(super) fn new(white: bool) -> Self {
        let height = |j: usize| GAUSSIANS[j].1 * (TAU * GAUSSIANS[j].3).sqrt() / NORM;
        let rgb = |j: usize| cie::XYZ_TO_SRGB.map(|row| row[GAUSSIANS[j].0] * height(j));
        let sum: [f64; 3] = std::array::from_fn(|c| (0..4).map(|j| rgb(j)[c]).sum());
        let divisor = if white { sum } else { [1.0; 3] };
        let lobe = |j: usize| Lobe {
            rgb: std::array::from_fn(|c| F::from_f64(rgb(j)[c] / divisor[c])),
            turns: F::from_f64(GAUSSIANS[j].2 * 1e-9),
            width: F::from_f64(TAU * 1e-9 * GAUSSIANS[j].3.sqrt()),
        };
        Self { lobes: std::array::from_fn(lobe) }
    }

    /// The transform at a path difference, nm; `reversed` adds half a turn.
    #[inline]
    pub(super) fn at(&self, x: F, reversed: bool) -> [F; 3] {
        let half = F::from_f64(0.5);
        let sign = if reversed { -F::ONE } else { F::ONE };
        self.lobes.iter().fold([F::ZERO; 3], |sum, lobe| {
            let turns = x * lobe.turns;
            let (_, c) = (turns - (turns + half).floor()).sin_cos_half_turns();
            // cos(2 a) = 2 cos(a)^2 - 1.
            let cos = c.squared() + c.squared() - F::ONE;
            let value = sign * cos * (-(x * lobe.width).squared()).exp();
            std::array::from_fn(|i| sum[i] + lobe.rgb[i] * value)
        })
    }
}

/// The colour as glTF viewers compute it: Schlick's approximation, unpolarised, phases of 0 or pi, two orders, clamped
/// at 0 from below; 1 beyond the critical angle of the film. Below 0.03 nm the film's index fades to that outside, and without
/// thickness there is no film.
pub(super) fn gltf<F: Real>(fit: &Fit<F>, film: &Film<F>, cosine: F) -> [F; 3] {
    let [n0, n1, n2] = film.indices();
    let (f, c, d) = (F::from_f64, cosine.saturate(), film.thickness_nm());
    let f0 = |a: F, b: F| ((a - b) / (a + b)).squared();
    if d == F::ZERO {
        return [schlick(f0(n0, n2), c); 3];
    }
    let t = (d * f(1.0 / 0.03)).saturate();
    let n1 = n0 + (n1 - n0) * t * t * (f(3.0) - t - t);
    let square = F::ONE - (n0 / n1).squared() * (F::ONE - c * c);
    if square < F::ZERO {
        return [F::ONE; 3];
    }
    let c1 = square.safe_sqrt();
    let (r12, r23) = (schlick(f0(n0, n1), c), schlick(f0(n1, n2), c1));
    let t121 = F::ONE - r12;
    let r123 = (r12 * r23).max(f(1e-5)).min(f(0.9999));
    let rs = t121.squared() * r23 / (F::ONE - r123);
    // Half turns of the reflections inside the film: at its upper side unless n1 < n0, at its lower one if n2 < n1.
    let reversed = (n1 >= n0) != (n2 < n1);
    let (mut rgb, mut cm) = ([r12 + rs; 3], rs - t121);
    let path = f(2.0) * n1 * d * c1;
    for (order, x) in [(1, path), (2, path + path)] {
        cm = cm * r123.safe_sqrt();
        let s = fit.at(x, reversed && order == 1);
        rgb = std::array::from_fn(|i| rgb[i] + (cm + cm) * s[i]);
    }
    rgb.map(|v| v.max(F::ZERO))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn the_white_of_the_fit_is_that_of_equal_energy() {
        let published = Fit::<f64>::new(false).at(0.0, false);
        for (a, b) in published.into_iter().zip([1.205, 0.948, 0.910]) {
            assert!((a - b).abs() < 1.5e-3, "{published:?}");
        }
        for c in Fit::<f64>::new(true).at(0.0, false) {
            assert!((c - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_fit_is_the_formula_of_its_authors() {
        // Their form: val sqrt(2 pi var) cos(pos phase) exp(-var phase^2), phase = 2 pi x 1e-9, here for Y.
        let (x, fit) = (730.0, Fit::<f64>::new(false));
        let phase = 2.0 * PI * x * 1e-9;
        let of = |j: usize| {
            let (_, val, pos, var) = GAUSSIANS[j];
            val * (2.0 * PI * var).sqrt() * (pos * phase).cos() * (-var * phase * phase).exp() / NORM
        };
        let xyz = [of(0) + of(3), of(1), of(2)];
        let at = fit.at(x, false);
        for (c, row) in cie::XYZ_TO_SRGB.iter().enumerate() {
            let expected: f64 = row.iter().zip(xyz).map(|(m, v)| m * v).sum();
            assert!((at[c] - expected).abs() < 1e-12);
            assert!((fit.at(x, true)[c] + expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_film_of_no_thickness_is_schlick() {
        let film = Film::new(1.0, 1.55, 2.0, 0.0f64).expect("a film");
        let fit = Fit::new(false);
        for c in [0.0, 0.3, 1.0] {
            for v in gltf(&fit, &film, c) {
                assert!((v - schlick(1.0 / 9.0, c)).abs() < 1e-15, "{c}: {v}");
            }
        }
    }
}
