//! The colour of a film: exact, and by the methods that it is compared with.
//!
//! With `q = -a b` and `A = (1 - a^2)(1 - b^2)/(1 - q^2)` of each polarisation the Airy transmittance is a Poisson kernel,
//! `T = A (1 + 2 sum_k q^k cos(2 pi k D/lambda))`, so that under any light
//!
//! ```text
//! R_c = mean over s, p of (1 - A) - 2 A sum_{k >= 1} q^k C_c(k D)
//! ```
//!
//! with one table C of the path difference ([`Transform`]): dielectrics have no other phase. No sampling of wavelengths,
//! so no moire on thick films: beyond the table's end only 1 - A is left, the incoherent mean.
//!
//! | File | Methods |
//! | --- | --- |
//! | `method` | their names |
//! | `series` | the series, with a given number of terms or as many as needed |
//! | [`belcour`] | Belcour and Barla: as viewers do it, and with better terms |
//! | [`table`] | a table of one film by cosine and thickness |

pub mod belcour;
mod method;
mod series;
pub mod table;

pub use method::{BEST_NM, MAX_ORDER, Method, TABLE_SIZE, THESIS_NM};
use series::{Both, Series};

use super::cie::{self, Node};
use super::real::Real;
use super::thin_film::{Film, Incidence};
use super::transform::Transform;
use belcour::Fit;
use table::Table;

/// Range of the uniform wavelengths, nm.
pub const UNIFORM_NM: (f64, f64) = (380.0, 780.0);
/// How many there are where no method is named.
const UNIFORM: usize = 32;
/// Indices of the default film: air, keratin and what is below it in the thesis.
pub const DEFAULT_INDICES: [f64; 3] = [1.0, 1.55, 2.0];

/// Mean reflectance over all phases: what a film of many micrometres shows under any broad light.
///
/// `R_inc = mean over s, p of 1 - (1 - a^2)(1 - b^2)/(1 - a^2 b^2)`. Beyond the critical angle of the film, where there is
/// no phase, 1; for thickness 0 and equal indices the plain interface.
pub fn incoherent<F: Real>(film: &Film<F>, cosine: F) -> F {
    match film.incidence(cosine) {
        Incidence::Gray(power) => (power.s.reflected + power.p.reflected) * F::from_f64(0.5),
        Incidence::Film { y, frustrated: false, of, .. } if y > F::ZERO => {
            ((Series::new(of.s, y).r + Series::new(of.p, y).r) * F::from_f64(0.5)).min(F::ONE)
        }
        Incidence::Film { .. } => F::ONE,
    }
}

/// Colours of films by one method.
#[derive(Clone, Debug)]
pub struct FilmColor<F: 'static> {
    method: Method,
    transform: &'static Transform<F>,
    /// Where there is no series, and for uniform wavelengths.
    nodes: Vec<(F, [F; 3])>,
    /// Where wavelengths differ in more than the phase: dispersion, gratings.
    pub(super) uniform: Vec<(F, [F; 3])>,
    /// Of Belcour's methods.
    fit: Option<Fit<F>>,
    /// Of [`Method::Table`].
    table: Option<Table<F>>,
}

impl<F: Real> FilmColor<F> {
    /// Prepare a method; a table is made for the indices [`DEFAULT_INDICES`].
    pub fn new(method: Method) -> Self {
        Self::with_indices(method, DEFAULT_INDICES.map(F::from_f64))
    }

    /// Prepare a method; a table is made for films of these indices n0, n1, n2. Other methods do not look at them.
    pub fn with_indices(method: Method, indices: [F; 3]) -> Self {
        let narrow = |n: &Node| (F::from_f64(n.wavelength_nm), n.rgb.map(F::from_f64));
        let nodes: Vec<_> = match method {
            Method::Three(wavelengths) => {
                let rgb = |c: usize| std::array::from_fn(|i| if i == c { F::ONE } else { F::ZERO });
                (0..3).map(|c| (F::from_f64(wavelengths[c]), rgb(c))).collect()
            }
            Method::Uniform(count) => {
                cie::uniform_nodes(usize::from(count), UNIFORM_NM).iter().map(narrow).collect()
            }
            Method::Adaptive(_) | Method::Table(..) => {
                cie::uniform_nodes(470, (cie::FIRST_NM, cie::LAST_NM)).iter().map(narrow).collect()
            }
            // Beyond the critical angle of the film nothing oscillates, and few wavelengths do.
            _ => cie::uniform_nodes(16, UNIFORM_NM).iter().map(narrow).collect(),
        };
        let fit = match method {
            Method::BelcourGltf | Method::Belcour => Some(Fit::new(false)),
            Method::BelcourWhite => Some(Fit::new(true)),
            _ => None,
        };
        let table = match method {
            Method::Table(cosines, thicknesses) => Some(Table::new(indices, cosines, thicknesses)),
            _ => None,
        };
        let uniform = cie::uniform_nodes(UNIFORM, UNIFORM_NM).iter().map(narrow).collect();
        Self { method, transform: F::transform(), nodes, uniform, fit, table }
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Reflected colour of unpolarised D65 light, linear sRGB, white = (1, 1, 1), not clamped (but for
    /// [`Method::BelcourGltf`]); `cosine` of the angle in n0, limited to [0, 1], NaN is 0. No input gives NaN. A film that a
    /// table is not of is computed by [`Method::REFERENCE`].
    pub fn color(&self, film: &Film<F>, cosine: F) -> [F; 3] {
        match (self.method, &self.fit, &self.table) {
            (Method::BelcourGltf, Some(fit), _) => return belcour::gltf(fit, film, cosine),
            (_, _, Some(table)) => {
                if let Some(rgb) = table.at(film, cosine) {
                    return rgb;
                }
            }
            _ => {}
        }
        let d = film.thickness_nm();
        let incidence = film.incidence(cosine);
        let both = match incidence {
            Incidence::Gray(power) => return [(power.s.reflected + power.p.reflected) * F::from_f64(0.5); 3],
            Incidence::Film { y, frustrated: false, of, .. } if y > F::ZERO => {
                Both { s: Series::new(of.s, y), p: Series::new(of.p, y), path: F::from_f64(2.0) * d * y }
            }
            Incidence::Film { .. } => return self.sum(&incidence, d),
        };
        let long = |left: f64| match both.order(left) {
            Some(order) => both.long(self.transform, order),
            None => self.sum(&incidence, d),
        };
        match (self.method, &self.fit) {
            (Method::Series(order), _) => both.short(self.transform, order),
            (Method::Uniform(_) | Method::Three(_), _) => self.sum(&incidence, d),
            (_, Some(fit)) => both.sum(3, |x| fit.at(x, false)),
            (Method::Adaptive(left), _) => long(left),
            _ => long(1e-7),
        }
    }

    /// Sum over wavelengths.
    fn sum(&self, incidence: &Incidence<F>, d: F) -> [F; 3] {
        let half = F::from_f64(0.5);
        self.nodes.iter().fold([F::ZERO; 3], |sum, (wavelength, weight)| {
            let power = incidence.power(d, *wavelength);
            let r = (power.s.reflected + power.p.reflected) * half;
            std::array::from_fn(|c| sum[c] + weight[c] * r)
        })
    }
}

/// Colour of a film on a spot of varying thickness: the series with `order` terms, filtered over the footprint.
///
/// `paths_nm` are the least and the greatest path difference in the footprint ([`Film::path_difference_nm`]);
/// `C(k D)` becomes its mean over them, which cures the moire of thickness maps (thesis fig. 5.9). Beyond the critical angle of the film the footprint is not looked at.
pub fn filtered<F: Real>(
    colors: &FilmColor<F>,
    film: &Film<F>,
    cosine: F,
    paths_nm: (F, F),
    order: u16,
) -> [F; 3] {
    match film.incidence(cosine) {
        Incidence::Film { y, frustrated: false, of, .. } if y > F::ZERO => {
            let (s, p) = (Series::new(of.s, y), Series::new(of.p, y));
            let mut rgb = [(s.r + p.r) * F::from_f64(0.5); 3];
            let (mut ts, mut tp, mut k) = (s.a, p.a, F::ZERO);
            for _ in 0..order {
                (ts, tp, k) = (ts * s.q, tp * p.q, k + F::ONE);
                let c = colors.transform.mean(k * paths_nm.0, k * paths_nm.1);
                rgb = std::array::from_fn(|i| rgb[i] - (ts + tp) * c[i]);
            }
            rgb
        }
        _ => colors.color(film, cosine),
    }
}
