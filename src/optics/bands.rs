//! The bands that a BRDF is computed in: red, green and blue, or N wavelengths.

use super::film_color::{BEST_NM, FilmColor};
use super::real::Real;
use super::spectrum::{self, Wavelengths};
use super::thin_film::{Film, WAVELENGTH_RANGE_NM};

/// What the film does to each of N bands.
pub trait Bands<F: Real, const N: usize> {
    /// Whether the bands are red, green and blue; wavelengths otherwise.
    const RGB: bool;

    /// Reflected part of unpolarised light, in [0, 1]; `cosine` of the angle in n0, limited to [0, 1].
    fn reflectance(&self, film: &Film<F>, cosine: F) -> [F; N];

    /// What is not reflected, in [0, 1].
    #[inline(always)]
    fn transmittance(&self, film: &Film<F>, cosine: F) -> [F; N] {
        self.reflectance(film, cosine).map(|r| F::ONE - r)
    }

    /// A quantity that is given for red, green and blue, in each band; linear in it.
    fn upsample(&self, rgb: [F; 3]) -> [F; N];

    /// Thickness in fringes at normal incidence, `2 n1 d/lambda`, for each band: the axis of the tables.
    fn fringes(&self, film: &Film<F>) -> [F; N];

    /// A wavelength that stands for each band, nm.
    fn wavelengths_nm(&self) -> [F; N];

    /// The wavelengths that [`Bands::each`] asks for, nm, by their number; `None` beyond the last.
    fn node_nm(&self, number: usize) -> Option<F>;

    /// What a quantity of the wavelength, nm, is in each band: for colours a sum over 32 even wavelengths, which can be a
    /// little negative.
    fn each(&self, at: impl FnMut(F) -> F) -> [F; N];
}

/// Wavelength that stands for all in [`Bands::fringes`] of colours, nm.
pub(super) const RGB_NM: f64 = 400.0;

/// Colours by any method. Channels out of gamut (-0.04 to 1.04) are limited to [0, 1] here and nowhere else, so that what
/// is reflected and what is transmitted are never negative and sum to 1.
impl<F: Real> Bands<F, 3> for FilmColor<F> {
    const RGB: bool = true;

    #[inline(always)]
    fn reflectance(&self, film: &Film<F>, cosine: F) -> [F; 3] {
        self.color(film, cosine).map(F::saturate)
    }

    #[inline(always)]
    fn upsample(&self, rgb: [F; 3]) -> [F; 3] {
        rgb
    }

    #[inline(always)]
    fn fringes(&self, film: &Film<F>) -> [F; 3] {
        [fringes(film, F::from_f64(1.0 / RGB_NM)); 3]
    }

    fn wavelengths_nm(&self) -> [F; 3] {
        BEST_NM.map(F::from_f64)
    }

    fn node_nm(&self, number: usize) -> Option<F> {
        self.uniform.get(number).map(|(l, _)| *l)
    }

    fn each(&self, mut at: impl FnMut(F) -> F) -> [F; 3] {
        self.uniform.iter().fold([F::ZERO; 3], |sum, (l, weights)| {
            let value = at(*l);
            std::array::from_fn(|c| sum[c] + weights[c] * value)
        })
    }
}

#[inline(always)]
fn fringes<F: Real>(film: &Film<F>, inverse: F) -> F {
    let path = film.indices()[1] * film.thickness_nm();
    (path + path) * inverse
}

/// N wavelengths, each with the exact Airy formula; four or eight in f32 are one vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectral<F, const N: usize> {
    wavelengths_nm: [F; N],
    inverse: [F; N],
    /// Spectra of red, green and blue.
    basis: [[F; 3]; N],
}

impl<F: Real, const N: usize> Spectral<F, N> {
    /// Wavelengths, nm, limited to 1 to 1e6; NaN is 1.
    #[inline(always)]
    pub fn new(wavelengths_nm: [F; N]) -> Self {
        let (lo, hi) = WAVELENGTH_RANGE_NM;
        let wavelengths_nm = wavelengths_nm.map(|l| l.max(F::from_f64(lo)).min(F::from_f64(hi)));
        let basis = |l: F| spectrum::basis(l.to_f64() as f32).map(|b| F::from_f64(f64::from(b)));
        Self { wavelengths_nm, inverse: wavelengths_nm.map(|l| F::ONE / l), basis: wavelengths_nm.map(basis) }
    }

    /// The wavelengths, nm.
    pub fn wavelengths_nm(&self) -> [F; N] {
        self.wavelengths_nm
    }
}

impl<const N: usize> From<&Wavelengths<N>> for Spectral<f32, N> {
    /// Those of a path.
    #[inline(always)]
    fn from(drawn: &Wavelengths<N>) -> Self {
        Self { wavelengths_nm: drawn.nm, inverse: drawn.nm.map(|l| 1.0 / l), basis: drawn.basis }
    }
}

impl<F: Real, const N: usize> Bands<F, N> for Spectral<F, N> {
    const RGB: bool = false;

    #[inline(always)]
    fn reflectance(&self, film: &Film<F>, cosine: F) -> [F; N] {
        let incidence = film.incidence(cosine);
        incidence.unpolarised::<N, true>(film.thickness_nm(), &self.wavelengths_nm, &self.inverse)
    }

    #[inline(always)]
    fn transmittance(&self, film: &Film<F>, cosine: F) -> [F; N] {
        let incidence = film.incidence(cosine);
        incidence.unpolarised::<N, false>(film.thickness_nm(), &self.wavelengths_nm, &self.inverse)
    }

    #[inline(always)]
    fn upsample(&self, rgb: [F; 3]) -> [F; N] {
        self.basis.map(|b| b[0] * rgb[0] + b[1] * rgb[1] + b[2] * rgb[2])
    }

    #[inline(always)]
    fn fringes(&self, film: &Film<F>) -> [F; N] {
        self.inverse.map(|inverse| fringes(film, inverse))
    }

    #[inline(always)]
    fn wavelengths_nm(&self) -> [F; N] {
        self.wavelengths_nm
    }

    #[inline(always)]
    fn node_nm(&self, number: usize) -> Option<F> {
        self.wavelengths_nm.get(number).copied()
    }

    #[inline(always)]
    fn each(&self, at: impl FnMut(F) -> F) -> [F; N] {
        self.wavelengths_nm.map(at)
    }
}
