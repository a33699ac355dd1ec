//! The energy of one material as shading needs it: tables over roughness and thickness.
//!
//! Between their entries cubic polynomials of four neighbours in each direction: few enough that only the entries around
//! one cosine are read.

use std::sync::OnceLock;

use super::super::absorption::cosine_in_layer;
use super::super::bands::{Bands, RGB_NM};
use super::super::cie;
use super::super::film_color::{self, BEST_NM, FilmColor, Method};
use super::super::ggx;
use super::super::quadrature::gauss_legendre;
use super::super::real::Real;
use super::super::thin_film::Film;
use super::{ANGLES, visit_lobe};

/// Cosines in the layer between which absorption is interpolated.
pub(super) const DEPTHS: usize = 4;
/// Cosines of `1 - E`: [`Table::cosine`].
const COSINES: usize = 48;
/// Steps of thickness for one fringe.
const PER_FRINGE: usize = 16;
/// Thicknesses of a table: 20 fringes, 2.4 um at 380 nm for the default film.
const THICKNESSES: usize = 20 * PER_FRINGE + 2;
/// Intervals of roughness.
const ROUGHNESSES: usize = 16;
/// Wavelengths of a dispersive table, nm: Chebyshev's nodes in `1/lambda^2` from 360 to 830 nm, as n is linear in it.
const DISPERSED_NM: [f64; 3] = [370.208, 467.075, 731.032];
/// Cosines to the half vector in a [`Kernel`].
const HALVES: usize = 256;

/// The Lagrange polynomials of four neighbouring nodes, -1, 0, 1, 2, at `t`.
#[inline(always)]
pub(in super::super) fn cubic<F: Real>(t: F) -> [F; 4] {
    let f = F::from_f64;
    let (a, b, c) = (t + F::ONE, t - F::ONE, t - f(2.0));
    let (bc, at) = (b * c, a * t);
    let sixth = f(1.0 / 6.0);
    [-(t * bc) * sixth, a * bc * f(0.5), -(at * c) * f(0.5), at * b * sixth]
}

/// Which reflectances, at what cosine to the half vector, each roughness and angle sees: the same for every film.
struct Kernel {
    /// Cosines `s^2` of even steps of s, by roughness from the first above 0, and angle.
    weights: Vec<[f64; ROUGHNESSES * ANGLES]>,
}

impl Kernel {
    fn shared() -> &'static Self {
        static KERNEL: OnceLock<Kernel> = OnceLock::new();
        KERNEL.get_or_init(|| {
            let mut weights = vec![[0.0; ROUGHNESSES * ANGLES]; HALVES];
            for r in 0..ROUGHNESSES {
                let alpha = ggx::alpha((r + 1) as f64 / ROUGHNESSES as f64);
                for (j, (u, _)) in gauss_legendre(ANGLES).into_iter().enumerate() {
                    visit_lobe(alpha, u, 24, |vh, weight| {
                        let place = vh.safe_sqrt() * (HALVES - 1) as f64;
                        let start = (place as usize).clamp(1, HALVES - 3);
                        for (k, c) in cubic(place - start as f64).into_iter().enumerate() {
                            weights[start - 1 + k][r * ANGLES + j] += c * weight;
                        }
                    });
                }
            }
            Self { weights }
        })
    }

    fn cosines() -> [f64; HALVES] {
        std::array::from_fn(|i| (i as f64 / (HALVES - 1) as f64).powi(2))
    }
}

/// The polynomial through all angles of the rule at the cosines of a table, as a matrix.
///
/// Barycentric form (Berrut & Trefethen 2004, eq. 4.2) with the weights of Gauss's and Legendre's nodes,
/// `(-1)^j sqrt((1 - x^2) w)` (Wang & Xiang 2012, theorem 3.1).
fn between_angles(rule: &[(f64, f64)]) -> [[f64; ANGLES]; COSINES] {
    std::array::from_fn(|k| {
        let cosine = cosine_at(k);
        let parts: [f64; ANGLES] = std::array::from_fn(|j| {
            let (u, w) = rule[j];
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            let apart = cosine - u;
            // At a node its own term is all: that of a tiny distance is.
            sign * (u * (1.0 - u) * w).sqrt() / if apart.abs() > 1e-12 { apart } else { 1e-12 }
        });
        let total: f64 = parts.iter().sum();
        parts.map(|p| p / total)
    })
}

/// The cosines of a table: squares of even steps, so that they crowd where light grazes.
fn cosine_at(k: usize) -> f64 {
    (k as f64 / (COSINES - 1) as f64).powi(2)
}

/// `1 - E` and what leaves, over roughness and thickness.
///
/// Rows are by roughness, channel and thickness, in this order. The row before thickness 0 is that after it, as everything
/// is even in the thickness; four rows at the end are the incoherent limit.
#[derive(Clone, Debug)]
pub(in super::super) struct Table<F> {
    /// `1 - E` at each of [`COSINES`]; empty where roughness does not matter.
    through: Vec<F>,
    /// Parts of `(n0/n2)^2 J` by the cosine in the layer; they sum to it.
    leaving: Vec<[F; DEPTHS]>,
    channels: usize,
    /// Whether bands are between channels, in `1/lambda^2`, rather than in one.
    dispersed: bool,
    /// Rows of one roughness and channel.
    thicknesses: usize,
    roughnesses: usize,
    /// `2/c2` of the nodes in the layer.
    depths: [F; DEPTHS],
}

/// Which entries of a table are around a roughness and N thicknesses, and their weights.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Place<F, const N: usize> {
    /// First row of the first roughness, for each band.
    row: [usize; N],
    /// Of four thicknesses at each of four roughnesses, for each band.
    weights: [[[F; 4]; 4]; N],
    /// Of a dispersive table, for each band.
    of_channel: [[F; 3]; N],
}

/// What leaves: `(n0/n2)^2 J`, and its parts by the cosine in the layer.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Leaving<F, const N: usize> {
    pub(in super::super) clear: [F; N],
    parts: [[F; N]; DEPTHS],
}

impl<F: Real> Table<F> {
    /// The table of a film, for colours or wavelengths; `rough` if roughness matters. `dispersion_nm2` as in
    /// [`Film::dispersed`].
    pub(in super::super) fn new(
        film: &Film<f64>,
        dispersion_nm2: Option<[f64; 2]>,
        rgb: bool,
        rough: bool,
    ) -> Self {
        // What each channel is like, and where.
        let at = |l: f64| (dispersion_nm2.map_or(*film, |b| film.dispersed(b, l)), l);
        let films: Vec<(Film<f64>, f64)> = match (rgb, dispersion_nm2) {
            (true, _) => BEST_NM.map(at).to_vec(),
            (false, Some(_)) => DISPERSED_NM.map(at).to_vec(),
            (false, None) => vec![at(550.0)],
        };
        let channels = films.len();
        let rule = gauss_legendre(ANGLES);
        // Chebyshev's nodes between the least and the greatest cosine in the layer, and what each angle gives to each.
        let layer = |film: &Film<f64>, u: f64| cosine_in_layer(film.indices()[0], film.indices()[2], u);
        let least = films.iter().map(|(film, _)| layer(film, 0.0)).fold(1.0, f64::min);
        let depth = |m: usize| {
            let x = libm::cos(std::f64::consts::PI * (m as f64 + 0.5) / DEPTHS as f64);
            least + (1.0 - least) * 0.5 * (1.0 + x)
        };
        let depths: [f64; DEPTHS] = std::array::from_fn(depth);
        let lagrange = |m: usize, c: f64| {
            let others = depths.iter().enumerate().filter(|(k, _)| *k != m);
            others.map(|(_, d)| (c - d) / (depths[m] - d)).product::<f64>()
        };
        let shares = films.iter().map(|(film, _)| {
            let [n0, _, n2] = film.indices();
            let share = |(u, w): &(f64, f64), m: usize| {
                (n0 / n2) * (n0 / n2) * 2.0 * u * w * lagrange(m, layer(film, *u))
            };
            rule.iter().map(|node| std::array::from_fn(|m| share(node, m))).collect()
        });
        let shares: Vec<Vec<[f64; DEPTHS]>> = shares.collect();
        let between = between_angles(&rule);

        let method = if dispersion_nm2.is_some() { Method::Series(3) } else { Method::Adaptive(1e-5) };
        let colors = rgb.then(|| FilmColor::<f64>::new(method));
        let reflectance = |thickness: Option<usize>, cosine: f64| -> Vec<f64> {
            let fringes = thickness.unwrap_or(1) as f64 / PER_FRINGE as f64;
            let thick =
                |film: &Film<f64>, l: f64| film.with_thickness(fringes * l / (2.0 * film.indices()[1]));
            if let (Some(colors), Some(_)) = (&colors, thickness) {
                let film = thick(film, RGB_NM);
                let rgb = match dispersion_nm2 {
                    None => colors.color(&film, cosine),
                    Some(b) => colors.each(|l| film.dispersed(b, l).power(cosine, l).reflected),
                };
                return rgb.map(f64::saturate).to_vec();
            }
            let at = |(film, l): &(Film<f64>, f64)| {
                let film = thick(film, *l);
                let whole = |_| film.power(cosine, *l).reflected;
                thickness.map_or_else(|| film_color::incoherent(&film, cosine), whole)
            };
            films.iter().map(at).collect()
        };
        let interferes = films.iter().any(|(film, _)| {
            let [n0, n1, n2] = film.indices();
            n0 != n1 && n1 != n2
        });
        let waves = if interferes { THICKNESSES } else { 0 };
        // One before, and four at the end.
        let thicknesses = waves + 5;
        let roughnesses = if rough { ROUGHNESSES + 1 } else { 1 };
        let rows = roughnesses * channels * thicknesses;
        let mut leaving = vec![[F::ZERO; DEPTHS]; rows];
        let mut through = vec![F::ZERO; if rough { rows * COSINES } else { 0 }];
        for x in 0..=waves {
            let thickness = (x < waves).then_some(x);
            // Where it goes, twice for the first step, and four times at the end.
            let places = match thickness {
                Some(1) => vec![0, 2],
                Some(x) => vec![x + 1],
                None => (thicknesses - 4..thicknesses).collect(),
            };
            let smooth: Vec<Vec<f64>> = rule.iter().map(|(u, _)| reflectance(thickness, *u)).collect();
            let halves =
                if rough { Kernel::cosines().map(|c| reflectance(thickness, c)).to_vec() } else { vec![] };
            for c in 0..channels {
                let mut sums = [0.0; ROUGHNESSES * ANGLES];
                if rough {
                    for (weights, r) in Kernel::shared().weights.iter().zip(&halves) {
                        sums.iter_mut().zip(weights).for_each(|(sum, w)| *sum += w * r[c]);
                    }
                }
                for r in 0..roughnesses {
                    let reflected: [f64; ANGLES] = std::array::from_fn(|j| match r {
                        0 => smooth[j][c],
                        _ => sums[(r - 1) * ANGLES + j],
                    });
                    let parts = std::array::from_fn(|m| {
                        let each = shares[c].iter().zip(reflected).map(|(share, e)| share[m] * (1.0 - e));
                        F::from_f64(each.sum())
                    });
                    let first = (r * channels + c) * thicknesses;
                    places.iter().for_each(|x| leaving[first + x] = parts);
                    if rough {
                        let at: [F; COSINES] = std::array::from_fn(|k| {
                            let e: f64 = between[k].iter().zip(reflected).map(|(w, e)| w * e).sum();
                            F::from_f64(1.0 - e)
                        });
                        for x in &places {
                            through[(first + x) * COSINES..][..COSINES].copy_from_slice(&at);
                        }
                    }
                }
            }
        }
        let depths = depths.map(|c| F::from_f64(2.0 / c));
        let dispersed = !rgb && dispersion_nm2.is_some();
        Self { through, leaving, channels, dispersed, thicknesses, roughnesses, depths }
    }

    /// Where a roughness and thicknesses, in fringes, are; `wavelengths_nm` only matter to a dispersive table.
    #[inline(always)]
    pub(in super::super) fn place<const N: usize>(
        &self,
        roughness: F,
        fringes: [F; N],
        wavelengths_nm: [F; N],
    ) -> Place<F, N> {
        let (first, of_roughness) = if self.roughnesses == 1 {
            (0, [F::ONE, F::ZERO, F::ZERO, F::ZERO])
        } else {
            let place = roughness.saturate() * F::from_f64(ROUGHNESSES as f64);
            let start = place.whole().clamp(1, ROUGHNESSES - 2);
            (start - 1, cubic(place - F::from_f64(start as f64)))
        };
        let (mut row, mut weights) = ([0; N], [[[F::ZERO; 4]; 4]; N]);
        for i in 0..N {
            let place = (fringes[i] * F::from_f64(PER_FRINGE as f64)).max(F::ZERO);
            let (last, x) = (self.thicknesses - 4, place.whole());
            // The last four that interfere end before `last`.
            let coherent = x + 4 <= last;
            let x = if coherent { x } else { last };
            let t = if coherent { place - F::from_f64(x as f64) } else { F::ZERO };
            let channel = if self.dispersed { 0 } else { i % self.channels };
            row[i] = (first * self.channels + channel) * self.thicknesses + x;
            let of_thickness = cubic(t);
            for r in 0..4 {
                for x in 0..4 {
                    weights[i][r][x] = of_roughness[r] * of_thickness[x];
                }
            }
        }
        let of_channel = if self.dispersed { wavelengths_nm.map(of_channel) } else { [[F::ZERO; 3]; N] };
        Place { row, weights, of_channel }
    }

    /// Sum of what is read from each row around a place, for one band.
    #[inline(always)]
    fn sum<const N: usize, const K: usize>(
        &self,
        place: &Place<F, N>,
        band: usize,
        read: impl Fn(usize) -> [F; K],
    ) -> [F; K] {
        if self.dispersed { self.mixed(place, band, &read) } else { self.around(place, band, 0, &read) }
    }

    /// The same of one channel.
    #[inline(always)]
    fn around<const N: usize, const K: usize>(
        &self,
        place: &Place<F, N>,
        band: usize,
        channel: usize,
        read: &impl Fn(usize) -> [F; K],
    ) -> [F; K] {
        let mut sums = [F::ZERO; K];
        let (first, step) = (place.row[band] + channel * self.thicknesses, self.channels * self.thicknesses);
        for r in 0..if self.roughnesses == 1 { 1 } else { 4 } {
            for x in 0..4 {
                let weight = place.weights[band][r][x];
                let values = read(first + r * step + x);
                for k in 0..K {
                    sums[k] += weight * values[k];
                }
            }
        }
        sums
    }

    /// The same between the channels of a dispersive table.
    #[cold]
    #[inline(never)]
    fn mixed<const N: usize, const K: usize>(
        &self,
        place: &Place<F, N>,
        band: usize,
        read: &impl Fn(usize) -> [F; K],
    ) -> [F; K] {
        let mut sums = [F::ZERO; K];
        for c in 0..3 {
            let values = self.around(place, band, c, read);
            for k in 0..K {
                sums[k] += place.of_channel[band][c] * values[k];
            }
        }
        sums
    }

    /// What leaves at a place.
    #[inline(always)]
    pub(in super::super) fn leaving<const N: usize>(&self, place: &Place<F, N>) -> Leaving<F, N> {
        let mut out = Leaving { clear: [F::ZERO; N], parts: [[F::ZERO; N]; DEPTHS] };
        for i in 0..N {
            let sums = self.sum(place, i, |row| self.leaving[row]);
            for m in 0..DEPTHS {
                out.parts[m][i] = sums[m];
                out.clear[i] += sums[m];
            }
        }
        out
    }

    /// `1 - E` at a place and cosine, in [0, 1].
    #[inline(always)]
    pub(in super::super) fn transmittance<const N: usize>(&self, place: &Place<F, N>, cosine: F) -> [F; N] {
        let at = cosine.saturate().safe_sqrt() * F::from_f64((COSINES - 1) as f64);
        let start = at.whole().clamp(1, COSINES - 3);
        let of_cosine = cubic(at - F::from_f64(start as f64));
        let mut out = [F::ZERO; N];
        for i in 0..N {
            let sums: [F; 4] = self.sum(place, i, |row| {
                let values = &self.through[row * COSINES + start - 1..][..4];
                [values[0], values[1], values[2], values[3]]
            });
            let sum = (sums[0] * of_cosine[0] + sums[1] * of_cosine[1])
                + (sums[2] * of_cosine[2] + sums[3] * of_cosine[3]);
            out[i] = sum.saturate();
        }
        out
    }

    /// `(n0/n2)^2 2 int T(u) exp(-tau/c2(u)) u du`: what crosses film and layer once, for each band.
    pub(in super::super) fn crossing<const N: usize>(&self, leaving: &Leaving<F, N>, tau: [F; N]) -> [F; N] {
        let half = F::from_f64(0.5);
        std::array::from_fn(|i| {
            let part = |m: usize| leaving.parts[m][i] * (tau[i] * self.depths[m] * half).decay();
            (0..DEPTHS).fold(F::ZERO, |sum, m| sum + part(m)).max(F::ZERO)
        })
    }

    /// `1 - rho(tau)`: what does not return to the base, for each band.
    #[inline(always)]
    pub(in super::super) fn lost<const N: usize>(&self, leaving: &Leaving<F, N>, tau: [F; N]) -> [F; N] {
        let (mut g, mut out) = ([F::ZERO; N], [F::ZERO; N]);
        for m in 0..DEPTHS {
            for i in 0..N {
                g[i] += leaving.parts[m][i] * (tau[i] * self.depths[m]).decay();
            }
        }
        for i in 0..N {
            let two = F::from_f64(2.0);
            let lost = (F::ONE - two * fast_exponential_integral_3(two * tau[i]) + g[i]).max(F::ZERO);
            out[i] = if tau[i] > F::ZERO { lost } else { leaving.clear[i] };
        }
        out
    }
}

/// The Lagrange polynomials of [`DISPERSED_NM`] in `1/lambda^2`, limited to 360 to 830 nm.
#[cold]
#[inline(never)]
fn of_channel<F: Real>(wavelength_nm: F) -> [F; 3] {
    let l = wavelength_nm.to_f64().clamp(cie::FIRST_NM, cie::LAST_NM);
    let (s, nodes) = (1.0 / (l * l), DISPERSED_NM.map(|l| 1.0 / (l * l)));
    std::array::from_fn(|m| {
        let others = nodes.iter().enumerate().filter(|(k, _)| *k != m);
        F::from_f64(others.map(|(_, n)| (s - n) / (nodes[m] - n)).product())
    })
}

/// The exponential integral `E3(y) = int_1^inf e^(-y t)/t^3 dt` for y >= 0; E3(0) = 1/2.
///
/// `E3 = (e^-y (1 - y) + y^2 E1)/2` (Abramowitz & Stegun 5.1.14) with E1 by 5.1.53 below 1 and 5.1.56 from 1 on: error
/// below 2e-7 y^2. Both are computed and one taken, so that loops over bands vectorise.
#[inline(always)]
pub(super) fn fast_exponential_integral_3<F: Real>(y: F) -> F {
    let f = F::from_f64;
    let horner = |c: [f64; 5], x: F| (((f(c[0]) * x + f(c[1])) * x + f(c[2])) * x + f(c[3])) * x + f(c[4]);
    let decay = y.decay();
    let low = y.max(f(1e-30)).min(F::ONE);
    let poly =
        horner([0.00107857, -0.00976004, 0.05519968, -0.24991055, 0.99999193], low) * low - f(0.57721566);
    let near = (poly - low.ln()) * y * y;
    // At 87 there is nothing left, and further on the quotient would be infinity by infinity.
    let high = y.max(F::ONE).min(f(87.0));
    let above = horner([1.0, 8.5733287401, 18.0590169730, 8.6347608925, 0.2677737343], high);
    let below = horner([1.0, 9.5733223454, 25.6329561486, 21.0996530827, 3.9584969228], high);
    let far = decay * high * (above / below);
    let y2_e1 = if y < F::ONE { near } else { far };
    let e3 = ((decay * (F::ONE - y.min(f(1e3))) + y2_e1) * f(0.5)).max(F::ZERO);
    if y > F::ZERO { e3 } else { f(0.5) }
}
