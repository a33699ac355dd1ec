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
//! [`specular_albedo`] and [`furnace`] are the truth, in f64, by quadrature. `Table` is for shading.

use super::absorption::cosine_in_layer;
use super::ggx;
use super::quadrature::gauss_legendre;
use super::real::Real;
use super::thin_film::Film;

/// Directions of a table: nodes of the Gauss-Legendre rule in the cosine.
pub(super) const ANGLES: usize = 24;
/// Visit the microfacets that a view at `cosine` sees: calls `visit(v.h, weight)` so that `sum weight R(v.h)` is `E`.
///
/// `E = int D V R nl dwi`, in slopes `alpha tan(psi)` of the microfacets, which fill psi evenly but for smooth factors
/// (GGX is `cos^4 psi` over slopes), up to where the reflected ray meets the horizon. Gauss-Legendre rules in psi, crowded at
/// that end, and around in two halves, crowded across the view: right to 1e-6 with 24 `points`, to 1e-8 with 48.
pub fn visit_lobe(alpha: f64, cosine: f64, points: usize, mut visit: impl FnMut(f64, f64)) {
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

/// The exponential integral `E3(y) = int_1^inf e^(-y t)/t^3 dt` for y >= 0, to 1e-14: E3(0) = 1/2, series below 2 (5.1.11), continued fraction from 2 on (5.1.22).
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

mod table;
pub(super) use table::{Place, Table, cubic};

#[cfg(test)]
mod tests;
