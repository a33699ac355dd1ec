//! How much a rough interface reflects, and how much of what comes from below it keeps inside.
//!
//! `E(u)`: part of the light from a direction at cosine u that the microfacets reflect into the hemisphere. `T(u)` is
//! what gets through: `1 - R(u)` of the smooth film ([`Energy::Flat`](super::layered::Energy)) or `1 - E(u)`
//! ([`Energy::Coupled`](super::layered::Energy)), which loses nothing at any roughness. From below, of diffuse light that
//! crosses an absorbing layer of optical depth tau there and back,
//!
//! ```text
//! rho(tau) = 2 E3(2 tau) - G(tau),   G(tau) = (n0/n2)^2 2 int_0^1 T(u) exp(-2 tau/c2(u)) u du
//! ```
//!
//! returns to the base: all that arrives at the interface (E3 is the exponential integral) less what leaves; by
//! reciprocity this is section 4.4's sum of partial and total reflection, for any n0, n2. `rho(0) = 1 - (n0/n2)^2 J` with
//! `J = 2 int T u du`.
//!
//! [`specular_albedo`] and [`furnace`] are the truth, in f64, by quadrature. [`Table`] is for shading.

use std::sync::OnceLock;

use super::absorption::cosine_in_layer;
use super::bands::RGB_NM;
use super::film_color::{self, FilmColor, Method};
use super::ggx;
use super::quadrature::gauss_legendre;
use super::real::Real;
use super::thin_film::Film;

/// Directions of a table: nodes of the Gauss-Legendre rule in the cosine.
pub(super) const ANGLES: usize = 24;
/// Cosines in the layer between which absorption is interpolated.
pub(super) const DEPTHS: usize = 6;
/// `E` at each angle, `J`, the parts of `G`, and one to make vectors whole.
const COLUMNS: usize = ANGLES + 1 + DEPTHS + 1;
/// Where `J` is.
const LEAVING: usize = ANGLES;
/// Steps of thickness for one fringe.
const PER_FRINGE: usize = 16;
/// Thicknesses of a table: 20 fringes, 2.4 um at 380 nm for the default film.
const THICKNESSES: usize = 20 * PER_FRINGE + 2;
/// Intervals of roughness.
const ROUGHNESSES: usize = 16;
/// Cosines to the half vector in a [`Kernel`].
const HALVES: usize = 256;

/// Visit the microfacets that a view at `cosine` sees: calls `visit(v.h, weight)` so that `sum weight R(v.h)` is `E`.
///
/// `E = int D V R nl dwi`, in slopes `alpha tan(psi)` of the microfacets, which fill psi evenly but for smooth factors
/// (GGX is `cos^4 psi` over slopes), up to where the reflected ray meets the horizon. Gauss-Legendre rules in psi, crowded at
/// that end, and around in two halves, crowded across the view: right to 1e-6 with 24 `points`, to 1e-8 with 48.
fn visit_lobe(alpha: f64, cosine: f64, points: usize, mut visit: impl FnMut(f64, f64)) {
    use std::f64::consts::{FRAC_PI_2, PI};
    let u = cosine.clamp(1e-9, 1.0);
    if alpha == 0.0 {
        return visit(u, 1.0);
    }
    let (along, a2) = (((1.0 - u) * (1.0 + u)).sqrt(), alpha * alpha);
    let rule = gauss_legendre(points);
    for (y, wy) in rule.iter().flat_map(|(y, w)| [(*y, *w), (-*y, *w)]) {
        let phi = FRAC_PI_2 * (1.0 - y * y.abs());
        let b = along * libm::cos(phi);
        // The slope k where u + 2 b k - u k^2, the reflected ray's height, is 0.
        let root = (b * b + u * u).sqrt();
        let end = if b > 0.0 { (b + root) / u } else { u / (root - b) };
        let end = libm::atan2(end, alpha);
        for (x, wx) in &rule {
            let psi = end * x * (2.0 - x);
            let (sin, cos) = (libm::sin(psi), libm::cos(psi));
            let length2 = cos * cos + a2 * sin * sin;
            let facing = u * cos + b * alpha * sin;
            let height = u * cos * cos + 2.0 * b * alpha * sin * cos - u * a2 * sin * sin;
            // pi y dy around, twice for both sides, over 2 pi; 2 end (1 - x) dx along.
            let measure = FRAC_PI_2 * 2.0 * y.abs() * wy / PI * 2.0 * end * (1.0 - x) * wx;
            let seen = 4.0 * height / length2 * ggx::visibility(alpha, height / length2, u);
            visit(facing / length2.sqrt(), measure * 2.0 * sin * facing * seen);
        }
    }
}

/// `E`: the part of light at `cosine` that microfacets of `alpha` reflect, each with `reflectance(cosine to it)`.
///
/// By quadrature; right to 1e-8 but near grazing thick films.
pub fn specular_albedo(alpha: f64, cosine: f64, reflectance: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    visit_lobe(alpha, cosine, 48, |vh, weight| sum += weight * reflectance(vh));
    sum
}

/// What a furnace shows: a surface under light that is 1 from everywhere, at one wavelength, seen from one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Furnace {
    /// Reflected by the rough film.
    pub specular: f64,
    /// From the base, transmittance flat.
    pub diffuse_flat: f64,
    /// From the base, transmittance coupled to roughness.
    pub diffuse_coupled: f64,
    /// Internal reflection `rho(tau)` with the flat transmittance.
    pub internal_flat: f64,
    /// Internal reflection with the coupled transmittance.
    pub internal_coupled: f64,
}

/// The furnace of one film by quadrature in f64: no table, right to about 1e-6.
///
/// `kd` in [0, 1] is the albedo of the base itself, `tau` >= 0 the optical depth of the layer along the normal, `cosine`
/// that of the view.
pub fn furnace(
    film: &Film<f64>,
    wavelength_nm: f64,
    roughness: f64,
    kd: f64,
    tau: f64,
    cosine: f64,
) -> Furnace {
    let [n0, _, n2] = film.indices();
    let (eta, alpha) = ((n0 / n2) * (n0 / n2), ggx::alpha(roughness));
    let kd = kd.saturate();
    let reflect = |c: f64| film.power(c, wavelength_nm).reflected;
    let flat = |c: f64| film.power(c, wavelength_nm).transmitted;
    // What few points lack at single angles is lost in the integral.
    let coupled = |c: f64| {
        let mut sum = 0.0;
        visit_lobe(alpha, c, 24, |vh, weight| sum += weight * reflect(vh));
        1.0 - sum
    };
    let specular = specular_albedo(alpha, cosine, reflect);
    let way = |c: f64| tau.max(0.0) / cosine_in_layer(n0, n2, c);
    let diffuse = |t: &dyn Fn(f64) -> f64, out: f64| {
        // J, G and what comes in to leave to this view.
        let (mut leaving, mut entering) = (0.0, 0.0);
        for (u, w) in angles(film) {
            let (t, way_in) = (t(u) * 2.0 * u * w, way(u));
            leaving += t * libm::exp(-2.0 * way_in);
            entering += t * libm::exp(-way_in - way(cosine));
        }
        let rho = (2.0 * exponential_integral_3(2.0 * tau.max(0.0)) - eta * leaving).saturate();
        (eta * out * kd / (1.0 - kd * rho).max(1e-300) * entering, rho)
    };
    let ((diffuse_flat, internal_flat), (diffuse_coupled, internal_coupled)) =
        (diffuse(&flat, flat(cosine)), diffuse(&coupled, 1.0 - specular));
    Furnace { specular, diffuse_flat, diffuse_coupled, internal_flat, internal_coupled }
}

/// Nodes over all cosines, in parts that end at critical angles, where reflectance has a kink.
fn angles(film: &Film<f64>) -> impl Iterator<Item = (f64, f64)> {
    let [n0, n1, n2] = film.indices();
    let critical = |n: f64| (1.0 - (n / n0).powi(2)).safe_sqrt();
    let (a, b) = (critical(n1), critical(n2));
    let ends = [0.0, a.min(b), a.max(b), 1.0];
    ends.map(|e| e)
        .windows(2)
        .map(|e| (e[0], e[1] - e[0]))
        .filter(|(_, width)| *width > 0.0)
        .flat_map(|(start, width)| {
            gauss_legendre(ANGLES).into_iter().map(move |(x, w)| (start + width * x, width * w))
        })
        .collect::<Vec<_>>()
        .into_iter()
}

/// The exponential integral `E3(y) = int_1^inf e^(-y t)/t^3 dt` for y >= 0; E3(0) = 1/2.
///
/// `E3 = (e^-y (1 - y) + y^2 E1)/2` (Abramowitz & Stegun 5.1.14) with E1 by 5.1.53 below 1 and 5.1.56 from 1 on: error
/// below 2e-7 y^2.
#[inline]
pub(super) fn fast_exponential_integral_3<F: Real>(y: F) -> F {
    let f = F::from_f64;
    let horner = |c: &[f64]| c.iter().fold(F::ZERO, |sum, c| sum * y + f(*c));
    let decay = y.decay();
    if y <= F::ZERO {
        return f(0.5);
    }
    let y2_e1 = if y < F::ONE {
        let poly = horner(&[0.00107857, -0.00976004, 0.05519968, -0.24991055, 0.99999193, -0.57721566]);
        (poly - y.ln()) * y * y
    } else {
        let above = horner(&[1.0, 8.5733287401, 18.0590169730, 8.6347608925, 0.2677737343]);
        let below = horner(&[1.0, 9.5733223454, 25.6329561486, 21.0996530827, 3.9584969228]);
        // At 87 there is nothing left, and further on the quotient would be infinity by infinity.
        if y < f(87.0) { decay * y * (above / below) } else { F::ZERO }
    };
    ((decay * (F::ONE - y) + y2_e1) * f(0.5)).max(F::ZERO)
}

/// The same in f64 to 1e-14: series below 2 (5.1.11), continued fraction from 2 on (5.1.22).
fn exponential_integral_3(y: f64) -> f64 {
    if y <= 0.0 {
        return 0.5;
    }
    if y > 700.0 {
        return 0.0;
    }
    let e = libm::exp(-y);
    if y < 2.0 {
        let (mut sum, mut term) = (-0.577_215_664_901_532_86 - libm::log(y), 1.0);
        for k in 1..40 {
            term *= -y / f64::from(k);
            sum -= term / f64::from(k);
        }
        return 0.5 * (e * (1.0 - y) + y * y * sum);
    }
    // E3 = e^-y/(y + 3/(1 + 1/(y + 4/(1 + 2/(y + ...))))), from the inside.
    let tail = (1..200).rev().fold(y, |tail, k| {
        let k = f64::from(k);
        y + (2.0 + k) / (1.0 + k / tail)
    });
    e / tail
}

/// The Lagrange polynomials of four neighbouring nodes, -1, 0, 1, 2, at `t`.
#[inline(always)]
fn cubic<F: Real>(t: F) -> [F; 4] {
    let f = F::from_f64;
    let (a, b, c) = (t + F::ONE, t - F::ONE, t - f(2.0));
    let sixth = f(1.0 / 6.0);
    [-(t * b * c) * sixth, a * b * c * f(0.5), -(a * t * c) * f(0.5), a * t * b * sixth]
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

/// What shading needs of one material, over roughness and thickness: `E` at 24 angles, `J`, and the parts of `G`.
#[derive(Clone, Debug)]
pub(super) struct Table<F> {
    rows: Vec<[F; COLUMNS]>,
    channels: usize,
    /// Thicknesses with interference; the row after them is the incoherent limit.
    thicknesses: usize,
    roughnesses: usize,
    /// Barycentric weights and cosines of the angles.
    angles: [(F, F); ANGLES],
    /// `-2/c2` of the nodes in the layer.
    depths: [F; DEPTHS],
}

/// A row of the table between its entries, for N bands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<F, const N: usize>([[F; N]; ANGLES]);

/// What leaves: `(n0/n2)^2 J`, and the parts of `G`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaving<F, const N: usize> {
    pub(super) clear: [F; N],
    parts: [[F; N]; DEPTHS],
}

impl<F: Real> Table<F> {
    /// The table of a film, for colours or wavelengths; `rough` if roughness matters.
    pub(super) fn new(film: &Film<f64>, rgb: bool, rough: bool) -> Self {
        let [n0, n1, n2] = film.indices();
        let eta = (n0 / n2) * (n0 / n2);
        let rule = gauss_legendre(ANGLES);
        // Chebyshev's nodes between the least and the greatest cosine in the layer, and what each angle gives to each.
        let least = cosine_in_layer(n0, n2, 0.0);
        let depth = |m: usize| {
            let x = libm::cos(std::f64::consts::PI * (m as f64 + 0.5) / DEPTHS as f64);
            least + (1.0 - least) * 0.5 * (1.0 + x)
        };
        let depths: [f64; DEPTHS] = std::array::from_fn(depth);
        let lagrange = |m: usize, c: f64| {
            (0..DEPTHS)
                .filter(|k| *k != m)
                .map(|k| (c - depths[k]) / (depths[m] - depths[k]))
                .product::<f64>()
        };
        let row = |reflected: [f64; ANGLES]| {
            let mut row = [0.0; COLUMNS];
            row[..ANGLES].copy_from_slice(&reflected);
            for ((u, w), e) in rule.iter().zip(reflected) {
                let part = eta * 2.0 * u * w * (1.0 - e);
                row[LEAVING] += part;
                let c2 = cosine_in_layer(n0, n2, *u);
                for m in 0..DEPTHS {
                    row[LEAVING + 1 + m] += part * lagrange(m, c2);
                }
            }
            row.map(F::from_f64)
        };
        let colors = rgb.then(|| FilmColor::<f64>::new(Method::Adaptive(1e-5)));
        let lambda = if rgb { RGB_NM } else { 550.0 };
        let reflectance = |thickness: Option<usize>, cosine: f64| -> [f64; 3] {
            let fringes = thickness.unwrap_or(1) as f64 / PER_FRINGE as f64;
            let film = film.with_thickness(fringes * lambda / (2.0 * n1));
            match (thickness, &colors) {
                (None, _) => [film_color::incoherent(&film, cosine); 3],
                (_, None) => [film.power(cosine, lambda).reflected; 3],
                (_, Some(colors)) => colors.color(&film, cosine).map(f64::saturate),
            }
        };
        let interferes = n0 != n1 && n1 != n2;
        let channels = if rgb { 3 } else { 1 };
        let thicknesses = if interferes { THICKNESSES } else { 1 };
        let roughnesses = if rough { ROUGHNESSES + 1 } else { 1 };
        let mut rows = vec![[F::ZERO; COLUMNS]; roughnesses * channels * (thicknesses + 1)];
        for x in 0..=thicknesses {
            let thickness = (x < thicknesses).then_some(x);
            let at = |r: usize, c: usize| (r * channels + c) * (thicknesses + 1) + x;
            let smooth: Vec<[f64; 3]> = rule.iter().map(|(u, _)| reflectance(thickness, *u)).collect();
            for c in 0..channels {
                rows[at(0, c)] = row(std::array::from_fn(|j| smooth[j][c]));
            }
            if !rough {
                continue;
            }
            let halves = Kernel::cosines().map(|c| reflectance(thickness, c));
            for c in 0..channels {
                let mut sums = [0.0; ROUGHNESSES * ANGLES];
                for (weights, r) in Kernel::shared().weights.iter().zip(&halves) {
                    for (sum, w) in sums.iter_mut().zip(weights) {
                        *sum += w * r[c];
                    }
                }
                for r in 0..ROUGHNESSES {
                    rows[at(r + 1, c)] = row(std::array::from_fn(|j| sums[r * ANGLES + j]));
                }
            }
        }
        // The nodes of Gauss and Legendre: (-1)^j sqrt((1 - x^2) w) (Wang & Xiang 2012, theorem 3.1).
        let angles = std::array::from_fn(|j| {
            let (u, w) = rule[j];
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            (F::from_f64(sign * (u * (1.0 - u) * w).sqrt()), F::from_f64(u))
        });
        Self {
            rows,
            channels,
            thicknesses,
            roughnesses,
            angles,
            depths: depths.map(|c| F::from_f64(2.0 / c)),
        }
    }

    /// The entries around a roughness, and their weights; one without roughness.
    #[inline(always)]
    fn around(&self, roughness: F) -> (usize, [F; 4]) {
        if self.roughnesses == 1 {
            return (0, [F::ONE, F::ZERO, F::ZERO, F::ZERO]);
        }
        let place = roughness.saturate() * F::from_f64(ROUGHNESSES as f64);
        let start = (place.to_f64() as usize).clamp(1, ROUGHNESSES - 2);
        (start - 1, cubic(place - F::from_f64(start as f64)))
    }

    /// Columns from `first` on for one band, summed over the entries around.
    #[inline(always)]
    fn columns<const C: usize>(&self, first: usize, roughness: F, channel: usize, fringes: F) -> [F; C] {
        let mut out = [F::ZERO; C];
        let (r0, of_r) = self.around(roughness);
        let place = (fringes * F::from_f64(PER_FRINGE as f64)).max(F::ZERO);
        // A number beyond the range of usize is its greatest.
        let x0 = place.to_f64() as usize;
        let (places, of_x) = if self.thicknesses < 4 || x0.saturating_add(2) >= self.thicknesses {
            // Beyond the table: the incoherent limit, once.
            ([self.thicknesses; 4], [F::ONE, F::ZERO, F::ZERO, F::ZERO])
        } else {
            // Even in the thickness, so that the entry before 0 is that after it.
            ([x0.abs_diff(1), x0, x0 + 1, x0 + 2], cubic(place - F::from_f64(x0 as f64)))
        };
        for (r, wr) in of_r.into_iter().enumerate().filter(|(_, w)| *w != F::ZERO) {
            let base = ((r0 + r) * self.channels + channel) * (self.thicknesses + 1);
            for (x, wx) in places.into_iter().zip(of_x) {
                if wx == F::ZERO {
                    continue;
                }
                let (w, row) = (wr * wx, &self.rows[base + x]);
                for i in 0..C {
                    out[i] += w * row[first + i];
                }
            }
        }
        out
    }

    /// What leaves at a roughness and thickness.
    #[inline]
    pub(super) fn leaving<const N: usize>(
        &self,
        roughness: F,
        fringes: [F; N],
        absorbing: bool,
    ) -> Leaving<F, N> {
        let mut out = Leaving { clear: [F::ZERO; N], parts: [[F::ZERO; N]; DEPTHS] };
        for i in 0..N {
            let channel = i % self.channels;
            if absorbing {
                let all = self.columns::<{ 1 + DEPTHS }>(LEAVING, roughness, channel, fringes[i]);
                out.clear[i] = all[0];
                (0..DEPTHS).for_each(|m| out.parts[m][i] = all[1 + m]);
            } else {
                out.clear[i] = self.columns::<1>(LEAVING, roughness, channel, fringes[i])[0];
            }
        }
        out
    }

    /// `E` at all angles at a roughness and thickness.
    #[inline]
    pub(super) fn row<const N: usize>(&self, roughness: F, fringes: [F; N]) -> Row<F, N> {
        let mut out = [[F::ZERO; N]; ANGLES];
        for i in 0..N {
            let e = self.columns::<ANGLES>(0, roughness, i % self.channels, fringes[i]);
            (0..ANGLES).for_each(|j| out[j][i] = e[j]);
        }
        Row(out)
    }

    /// `1 - E` at a cosine, in [0, 1]: the polynomial through all angles (barycentric form, Berrut & Trefethen 2004).
    #[inline]
    pub(super) fn transmittance<const N: usize>(&self, row: &Row<F, N>, cosine: F) -> [F; N] {
        let (mut sums, mut total) = ([F::ZERO; N], F::ZERO);
        for ((weight, u), e) in self.angles.iter().zip(&row.0) {
            let apart = cosine - *u;
            // At a node its own term is all: that of a tiny distance is.
            let apart = if apart.abs() > F::from_f64(1e-12) { apart } else { F::from_f64(1e-12) };
            let w = *weight / apart;
            total += w;
            for i in 0..N {
                sums[i] += w * e[i];
            }
        }
        sums.map(|sum| (F::ONE - sum / total).saturate())
    }

    /// `1 - rho(tau)`: what does not return to the base, for each band.
    #[inline]
    pub(super) fn lost<const N: usize>(&self, leaving: &Leaving<F, N>, tau: [F; N]) -> [F; N] {
        let mut out = [F::ZERO; N];
        for i in 0..N {
            let two = F::from_f64(2.0);
            let mut g = F::ZERO;
            for m in 0..DEPTHS {
                g += leaving.parts[m][i] * (tau[i] * self.depths[m]).decay();
            }
            out[i] = if tau[i] > F::ZERO {
                (F::ONE - two * fast_exponential_integral_3(two * tau[i]) + g).max(F::ZERO)
            } else {
                leaving.clear[i]
            };
        }
        out
    }
}

#[cfg(test)]
mod tests;
