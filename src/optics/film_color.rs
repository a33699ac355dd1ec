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

use std::fmt;
use std::str::FromStr;

use super::cie::{self, Node};
use super::real::Real;
use super::thin_film::{Admittances, Film, Incidence};
use super::transform::{self, END_NM, FAR_END_NM, GREATEST, Transform};

/// Wavelengths of red, green and blue of the thesis, nm.
pub const THESIS_NM: [f64; 3] = [650.0, 510.0, 475.0];
/// The best three wavelengths that were tried in their place, nm.
pub const BEST_NM: [f64; 3] = [612.0, 549.0, 465.0];
/// Range of the uniform wavelengths, nm.
pub const UNIFORM_NM: (f64, f64) = (380.0, 780.0);
/// Most terms of a series.
pub const MAX_ORDER: u16 = 4096;

/// How a colour is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The series until less than this is left, for each channel: the truth.
    Adaptive(f64),
    /// The series with so many terms; 3 is right for films on a denser base, and the default of shading.
    Series(u16),
    /// Reflectance at so many uniform wavelengths, weighted.
    Uniform(u16),
    /// Reflectance at three wavelengths, nm, taken as red, green and blue.
    Three([f64; 3]),
}

impl Method {
    /// The truth: less than 1e-7 is left out.
    pub const REFERENCE: Self = Self::Adaptive(1e-7);
    /// The names that [`FromStr`] reads.
    pub const NAMES: &str = "reference, series-K, uniform-N, three, three-best";
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Adaptive(left) if *self == Self::REFERENCE => write!(f, "reference ({left:e})"),
            Self::Adaptive(left) => write!(f, "adaptive {left:e}"),
            Self::Series(order) => write!(f, "series-{order}"),
            Self::Uniform(count) => write!(f, "uniform-{count}"),
            Self::Three([r, g, b]) => write!(f, "three wavelengths {r}/{g}/{b} nm"),
        }
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("there is no method `{text}`; methods: {}", Self::NAMES);
        let (name, number) = match text.rsplit_once('-') {
            Some((name, digits)) if digits.bytes().all(|b| b.is_ascii_digit()) => {
                let number: u16 = digits.parse().map_err(|_| bad())?;
                if !(1..=MAX_ORDER).contains(&number) {
                    return Err(format!("`{text}`: the number is 1 to {MAX_ORDER}"));
                }
                (name, Some(number))
            }
            _ => (text, None),
        };
        match (name, number) {
            ("reference", None) => Ok(Self::REFERENCE),
            ("series", number) => Ok(Self::Series(number.unwrap_or(3))),
            ("uniform", number) => Ok(Self::Uniform(number.unwrap_or(16))),
            ("three", None) => Ok(Self::Three(THESIS_NM)),
            ("three-best", None) => Ok(Self::Three(BEST_NM)),
            _ => Err(bad()),
        }
    }
}

/// A series of one polarisation.
#[derive(Clone, Copy, Debug)]
struct Series<F> {
    /// Mean transmittance over all phases, `A`.
    a: F,
    /// Mean reflectance over all phases, `1 - A`.
    r: F,
    /// Ratio of successive terms, `q = -r01 r12`.
    q: F,
}

impl<F: Real> Series<F> {
    /// Without cancellation, in admittances (y > 0): `A = 4 x y z/((x + z)(x z + y^2))` and
    /// `1 - A = (x (y - z)^2 + z (x - y)^2)/((x + z)(x z + y^2))`.
    ///
    /// Source: `A = (1 - a^2)(1 - b^2)/(1 - q^2)` with `a = (x - y)/(x + y)`, `b = (y - z)/(y + z)`, multiplied out.
    #[inline(always)]
    fn new(Admittances { x, yy, z }: Admittances<F>, y: F) -> Self {
        let den = (x + z) * (x * z + yy);
        Self {
            a: F::from_f64(4.0) * x * y * z / den,
            r: (x * (y - z).squared() + z * (x - y).squared()) / den,
            q: -((x - y) / (x + y) * ((y - z) / (y + z))),
        }
    }
}

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
    table: &'static Transform<F>,
    /// Where there is no series, and for uniform wavelengths.
    nodes: Vec<(F, [F; 3])>,
}

impl<F: Real> FilmColor<F> {
    /// Prepare a method.
    pub fn new(method: Method) -> Self {
        let narrow = |n: &Node| (F::from_f64(n.wavelength_nm), n.rgb.map(F::from_f64));
        let nodes: Vec<_> = match method {
            Method::Three(wavelengths) => {
                let rgb = |c: usize| std::array::from_fn(|i| if i == c { F::ONE } else { F::ZERO });
                (0..3).map(|c| (F::from_f64(wavelengths[c]), rgb(c))).collect()
            }
            Method::Uniform(count) => {
                cie::uniform_nodes(usize::from(count), UNIFORM_NM).iter().map(narrow).collect()
            }
            // Beyond the critical angle of the film nothing oscillates, and few wavelengths do.
            Method::Series(_) => cie::uniform_nodes(16, UNIFORM_NM).iter().map(narrow).collect(),
            Method::Adaptive(_) => {
                cie::uniform_nodes(470, (cie::FIRST_NM, cie::LAST_NM)).iter().map(narrow).collect()
            }
        };
        Self { method, table: F::transform(), nodes }
    }

    /// Reflected colour of unpolarised D65 light, linear sRGB, white = (1, 1, 1), not clamped; `cosine` of the angle in n0,
    /// limited to [0, 1], NaN is 0. No input gives NaN.
    pub fn color(&self, film: &Film<F>, cosine: F) -> [F; 3] {
        let d = film.thickness_nm();
        let incidence = film.incidence(cosine);
        match incidence {
            Incidence::Gray(power) => [(power.s.reflected + power.p.reflected) * F::from_f64(0.5); 3],
            Incidence::Film { y, frustrated: false, of, .. } if y > F::ZERO => {
                let (s, p) = (Series::new(of.s, y), Series::new(of.p, y));
                let path = F::from_f64(2.0) * d * y;
                match self.method {
                    Method::Series(order) => self.series(s, p, path, order, END_NM),
                    Method::Adaptive(left) => match order(s, p, path, left) {
                        Some(order) => self.series(s, p, path, order, FAR_END_NM),
                        None => self.sum(&incidence, d),
                    },
                    Method::Uniform(_) | Method::Three(_) => self.sum(&incidence, d),
                }
            }
            Incidence::Film { .. } => self.sum(&incidence, d),
        }
    }

    /// The series with `order` terms, of path differences up to `end`, nm.
    fn series(&self, s: Series<F>, p: Series<F>, path: F, order: u16, end: f64) -> [F; 3] {
        // Terms of both polarisations share the transform.
        let mut rgb = [(s.r + p.r) * F::from_f64(0.5); 3];
        let (mut ts, mut tp) = (s.a, p.a);
        let mut x = F::ZERO;
        for k in 1..=order {
            (ts, tp, x) = (ts * s.q, tp * p.q, x + path);
            let c = match x.to_f64() {
                x if x >= end => break,
                // The first terms only: later ones are of strong films, and cancel.
                x if x >= END_NM && k <= 8 => transform::exact(x).map(F::from_f64),
                x if x >= END_NM => break,
                _ => self.table.at(x),
            };
            // Minus twice the mean of both polarisations.
            let term = ts + tp;
            rgb = std::array::from_fn(|i| rgb[i] - term * c[i]);
        }
        rgb
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

/// Terms after which at most `left` remains: `2 A |q|^(K+1)/(1 - |q|) max|C|` for each polarisation, or all that the
/// transform's table has; `None` where these are too many, and the film so thin that summing wavelengths is better.
fn order<F: Real>(s: Series<F>, p: Series<F>, path: F, left: f64) -> Option<u16> {
    let terms = |series: Series<F>| {
        let (a, q) = (series.a.to_f64(), series.q.to_f64().abs());
        let rest = left * (1.0 - q) / (2.0 * a * GREATEST);
        if rest >= 1.0 || q == 0.0 {
            return 0.0;
        }
        // 1 - q may vanish in rounding: as many as there can be.
        if q >= 1.0 { f64::INFINITY } else { (libm::log(rest) / libm::log(q)).ceil().max(0.0) }
    };
    let needed = terms(s).max(terms(p)).min((END_NM / path.to_f64()).ceil());
    // A film of less than half a wave has no fringes: 1 nm steps of the wavelength are then right to 1e-9.
    if needed > 64.0 && path.to_f64() < 150.0 || needed > f64::from(MAX_ORDER) {
        return None;
    }
    Some(needed as u16)
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
                let c = colors.table.mean(k * paths_nm.0, k * paths_nm.1);
                rgb = std::array::from_fn(|i| rgb[i] - (ts + tp) * c[i]);
            }
            rgb
        }
        _ => colors.color(film, cosine),
    }
}
