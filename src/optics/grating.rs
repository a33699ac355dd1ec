//! Ridges on the skin, finer than the eye resolves: a diffraction grating.
//!
//! A sinusoidal height field of period P and amplitude h across the unit tangent g sends light into orders m: a direction w
//! goes to `w_m` with the tangential part `m (lambda/P) g - w` (grating equation; Born & Wolf, Principles of Optics, 8.6.1).
//! In scalar theory the power of an order is `J_m(2 pi h (n.w + n.w_m)/lambda)^2`, as Bessel's J_m are the Fourier series of a
//! sinusoidal phase (Stam 1999, Diffraction Shaders). Orders that cannot leave the surface have their power given to those
//! that can: the symmetric matrix of all directions that exchange light is scaled so that rows and columns sum to 1. That is
//! the share `e_m(w) = e_m(w_m)`. On microfacets
//!
//! ```text
//! f = R sum_m min(e_m(wi), e_m(wo)) G2 D(h_m) (h_m.wi) (h_m.wo)/(nl nv |v_m|^2),   v_m = wi + wo - m (lambda/P) g
//! ```
//!
//! with `h_m` along `v_m`: the reflected ray of Walter et al. 2007, eq. 20, for a surface that also adds `m (lambda/P) g`. Order
//! 0 is the plain lobe, as there the product of cosines is `|v|^2/4`. All is the same with wi and wo swapped, and no light
//! is made: each lobe sends on at most 1, and shares sum to 1.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use super::energy::cubic;
use super::ggx;
use super::layered::dot;
use super::real::Real;
use super::thin_film::FilmError;

/// Periods that a [`Grating`] takes, nm.
pub const PERIOD_RANGE_NM: (f64, f64) = (100.0, 2400.0);
/// Greatest height that a [`Grating`] takes, nm.
pub const MAX_HEIGHT_NM: f64 = 500.0;
/// Orders are -ORDERS to ORDERS: enough for two periods of the longest over the shortest wavelength.
const ORDERS: usize = 13;
/// Shortest wavelength, nm.
const LEAST_NM: f64 = 360.0;
/// Rounds of scaling the powers of orders.
const ROUNDS: usize = 12;
/// Share of the samples that all orders get alike.
const EVEN: f64 = 0.1;

/// Parallel ridges of a sinusoidal profile.
///
/// Periods of scales (oberhautchen) are 250 nm in uropeltids (Gans & Baic 1977); for other iridescent snakes none was found:
/// 700 to 1200 nm with heights of 20 to 120 nm show rainbows (an assumption).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grating {
    /// Distance of ridges, nm, in [`PERIOD_RANGE_NM`].
    pub period_nm: f32,
    /// Amplitude of the height, half of peak to valley, nm, 0 to [`MAX_HEIGHT_NM`]; 0 is no grating.
    pub height_nm: f32,
    /// Angle of g, which is across the ridges, from the tangent x towards y, rad.
    pub direction_rad: f32,
}

/// A grating made ready.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridges<F> {
    period_nm: F,
    height_nm: F,
    across: [F; 2],
}

impl<F: Real> Ridges<F> {
    /// `None` if they have no height.
    pub(crate) fn new(grating: &Grating) -> Result<Option<Self>, FilmError> {
        let Grating { period_nm, height_nm, direction_rad } = *grating;
        let [period, height, direction] = [period_nm, height_nm, direction_rad].map(f64::from);
        let checks = [
            ("period_nm", period, PERIOD_RANGE_NM),
            ("height_nm", height, (0.0, MAX_HEIGHT_NM)),
            ("direction_rad", direction, (-100.0, 100.0)),
        ];
        for (name, value, (lo, hi)) in checks {
            if !(lo..=hi).contains(&value) {
                return Err(FilmError::Grating { name, value });
            }
        }
        let across = [libm::cos(direction), libm::sin(direction)].map(F::from_f64);
        let (period_nm, height_nm) = (F::from_f64(period), F::from_f64(height));
        Ok((height > 0.0).then_some(Self { period_nm, height_nm, across }))
    }

    /// Orders that can be, and by how much each shifts q.
    fn shifts(&self, wavelength_nm: F) -> (i32, F) {
        let shift = wavelength_nm.max(F::from_f64(LEAST_NM)) / self.period_nm;
        let most = (F::from_f64(2.0) / shift).whole().min(ORDERS);
        (most as i32, shift)
    }

    /// `w - m (lambda/P) g`.
    fn moved(&self, w: [F; 3], m: i32, shift: F) -> [F; 3] {
        let by = F::from_f64(f64::from(m)) * shift;
        [w[0] - by * self.across[0], w[1] - by * self.across[1], w[2]]
    }

    /// Shares of the orders of light from or to `w`, from the least order on; their sum is at most 1.
    fn shares(&self, wavelength_nm: F, w: [F; 3]) -> [F; 2 * ORDERS + 1] {
        let (most, shift) = self.shifts(wavelength_nm);
        // All directions that exchange light with w, through any number of orders: order and height of each.
        let (mut all, mut count, mut own) = ([(0, F::ZERO); ORDERS + 1], 0, 0);
        for m in -most..=most {
            let [x, y, z] = self.moved(w, m, shift);
            let left = F::ONE - x.squared() - y.squared();
            if count <= ORDERS && (m == 0 || left > F::ZERO) {
                own = if m == 0 { count } else { own };
                all[count] = (m, if m == 0 { z } else { left.safe_sqrt() });
                count += 1;
            }
        }
        let all = &all[..count];
        let exchange = self.exchange(wavelength_nm, all);
        let mut shares = [F::ZERO; 2 * ORDERS + 1];
        for (j, b) in all.iter().enumerate() {
            shares[(b.0 + most) as usize] = exchange.share(own, j);
        }
        shares
    }

    /// What directions of these orders and heights, at most [`ORDERS`] + 1, send each other.
    fn exchange(&self, wavelength_nm: F, all: &[(i32, F)]) -> Exchange<F> {
        let per_height = F::from_f64(TAU) * self.height_nm / wavelength_nm.max(F::from_f64(LEAST_NM));
        let mut power = [[F::ZERO; ORDERS + 1]; ORDERS + 1];
        for (i, a) in all.iter().enumerate() {
            for (j, b) in all.iter().enumerate().take(i + 1) {
                let order = (a.0 - b.0).unsigned_abs() as usize;
                power[i][j] = bessel_square(order.min(ORDERS), per_height * (a.1 + b.1));
                power[j][i] = power[i][j];
            }
        }
        // Scale rows and columns alike until each sums to 1 (Knight, Ruiz & Ucar 2014, a symmetry preserving algorithm).
        let mut found = Exchange { power, scale: [F::ONE; ORDERS + 1], count: all.len() };
        for _ in 0..ROUNDS {
            let before = found;
            for i in 0..all.len() {
                found.scale[i] = before.scale[i] / before.row(i).safe_sqrt();
            }
        }
        found
    }

    /// The lobe of a perfect mirror with these ridges, 1/sr, and the density of [`Ridges::sample`], 1/sr.
    pub(super) fn lobe(&self, wavelength_nm: F, alpha: F, wi: [F; 3], wo: [F; 3]) -> (F, F) {
        let (most, shift) = self.shifts(wavelength_nm);
        let (there, back) = (self.shares(wavelength_nm, wi), self.shares(wavelength_nm, wo));
        let visibility = ggx::visibility(alpha, wi[2], wo[2]) * F::from_f64(4.0);
        let masking = ggx::masking(alpha, wo[2]) / wo[2];
        let (mut lobe, mut density) = (F::ZERO, F::ZERO);
        for (k, m) in (-most..=most).enumerate() {
            let moved = self.moved(wo, m, shift);
            let v: [F; 3] = std::array::from_fn(|k| wi[k] + moved[k]);
            let over = F::ONE / dot(v, v).safe_sqrt();
            let half = v.map(|x| x * over);
            let (hi, ho) = (dot(half, wi), dot(half, wo));
            let cosines = match m {
                0 => F::from_f64(0.25),
                _ if hi > F::ZERO && ho > F::ZERO => (hi * over) * (ho * over),
                _ => F::ZERO,
            };
            let facets = ggx::density_at(alpha, half) * cosines;
            lobe += there[k].min(back[k]) * visibility * facets;
            density += chance(back[k], most) * masking * facets;
        }
        (lobe, density)
    }

    /// A direction of light by three uniform numbers in [0, 1): order, then visible normal; `None` where the light ends.
    pub(super) fn sample(&self, wavelength_nm: F, alpha: F, wo: [F; 3], random: [F; 3]) -> Option<[F; 3]> {
        let (most, shift) = self.shifts(wavelength_nm);
        let shares = self.shares(wavelength_nm, wo);
        let mut left = random[0];
        let pick = |(share, _): &(F, i32)| {
            left = left - chance(*share, most);
            left < F::ZERO
        };
        // Rounding may leave a little: the last order gets it.
        let m = shares.into_iter().zip(-most..=most).find(pick).map_or(most, |(_, m)| m);
        let half = ggx::sample_visible(alpha, wo, [random[1], random[2]]);
        if m == 0 {
            let twice = dot(wo, half) * F::from_f64(2.0);
            let wi: [F; 3] = std::array::from_fn(|k| twice * half[k] - wo[k]);
            return (wi[2] > F::ZERO).then_some(wi);
        }
        // wi = s h - w is of length 1; the greater s is that with h.wi > 0.
        let moved = self.moved(wo, m, shift);
        let b = dot(half, moved);
        let root = b.squared() - dot(moved, moved) + F::ONE;
        if root.partial_cmp(&F::ZERO) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let s = b + root.safe_sqrt();
        let wi: [F; 3] = std::array::from_fn(|k| s * half[k] - moved[k]);
        let length = dot(wi, wi).safe_sqrt();
        (s > F::ZERO && wi[2] > F::ZERO && length > F::ZERO).then(|| wi.map(|x| x / length))
    }
}

/// Directions that send light to each other: powers, and what scales rows and columns so that they sum to 1.
#[derive(Clone, Copy, Debug)]
struct Exchange<F> {
    power: [[F; ORDERS + 1]; ORDERS + 1],
    scale: [F; ORDERS + 1],
    count: usize,
}

impl<F: Real> Exchange<F> {
    /// What a direction sends to all.
    fn row(&self, i: usize) -> F {
        let sum = (0..self.count).fold(F::ZERO, |sum, j| sum + self.power[i][j] * self.scale[j]);
        sum.max(F::from_f64(1e-12)) * self.scale[i]
    }

    /// What direction i sends to j.
    fn share(&self, i: usize, j: usize) -> F {
        self.power[i][j] * self.scale[j] * (self.scale[i] / self.row(i).max(F::ONE))
    }
}

impl Ridges<f64> {
    /// `lambda/P`, and how many directions at most exchange light of a wavelength.
    pub(crate) fn steps(&self, wavelength_nm: f64) -> (f64, usize) {
        let (_, shift) = self.shifts(wavelength_nm);
        // A little more: whoever counts them in single precision may find one more.
        (shift, ((2.0 / shift + 1e-3) as usize).min(ORDERS) + 1)
    }

    /// Unit vector across the ridges.
    pub(crate) fn across(&self) -> [f64; 2] {
        self.across
    }

    /// Shares that `count` directions, in steps of `lambda/P` along g, exchange: each with those before it and with itself.
    /// From the last and the first of them the horizon is `ends` steps away, both below 1: in these shares are smooth but for
    /// roots, though not where directions rise or set.
    pub(crate) fn exchanged(&self, wavelength_nm: f64, count: usize, [after, before]: [f64; 2]) -> Vec<f64> {
        let (shift, _) = self.steps(wavelength_nm);
        // z^2 = (r - x)(r + x), where r is the radius of the hemisphere at this distance from the plane of g.
        let height = |i: usize| shift * ((before + i as f64) * ((count - 1 - i) as f64 + after)).sqrt();
        let all: Vec<_> = (0..count).map(|i| (i as i32, height(i))).collect();
        let exchange = self.exchange(wavelength_nm, &all);
        (0..count)
            .flat_map(|j| (0..=j).map(move |i| (i, j)))
            .map(|(i, j)| 0.5 * (exchange.share(i, j) + exchange.share(j, i)))
            .collect()
    }
}

/// Probability of an order with a share, of 2 most + 1 orders. Where no order has a share a sample may be lost.
fn chance<F: Real>(share: F, most: i32) -> F {
    share * F::from_f64(1.0 - EVEN) + F::from_f64(EVEN / f64::from(2 * most + 1))
}

/// `J_m(x)^2`, m up to [`ORDERS`], 0 <= x <= 20, from a table: right to 1e-6.
fn bessel_square<F: Real>(m: usize, x: F) -> F {
    const STEPS: usize = 32;
    const END: usize = 20 * STEPS + 3;
    static TABLE: OnceLock<Vec<[f64; ORDERS + 1]>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        // From one step before 0: squares are even.
        (0..END).map(|i| bessel_squares((i as f64 - 1.0).abs() / STEPS as f64)).collect()
    });
    let place = x.max(F::ZERO).min(F::from_f64(20.0)) * F::from_f64(STEPS as f64);
    let start = place.whole().min(END - 4);
    let t = place - F::from_f64(start as f64);
    let weights = cubic(t);
    let sum = (0..4).fold(F::ZERO, |sum, k| sum + weights[k] * F::from_f64(table[start + k][m]));
    sum.max(F::ZERO)
}

/// `J_m(x)^2` for m from 0 to [`ORDERS`], 0 <= x <= 20: `J_0^2 + 2 sum J_m^2` is 1.
///
/// Miller's algorithm: `J_(m-1) = (2 m/x) J_m - J_(m+1)` downwards from far up, scaled by `J_0 + 2 sum J_2k = 1` (Abramowitz &
/// Stegun 9.1.27, 9.1.46 and 9.12, example 1).
fn bessel_squares(x: f64) -> [f64; ORDERS + 1] {
    let x = x.max(0.0).min(20.0);
    let mut out = [0.0; ORDERS + 1];
    if x < 1e-4 {
        // The series to its second term.
        out[0] = 1.0 - x * x / 2.0;
        out[1] = x * x / 4.0;
        return out;
    }
    // Even, and so far above x and the orders that what is left out is below 1e-16.
    let start = 2 * (ORDERS.max(x as usize) / 2 + 16);
    let (over, mut above, mut now, mut scale) = (2.0 / x, 0.0, 1e-250, 0.0);
    for m in (1..=start).rev() {
        // `now` is J_m.
        if m <= ORDERS {
            out[m] = now;
        }
        if m % 2 == 0 {
            scale += 2.0 * now;
        }
        (above, now) = (now, over * m as f64 * now - above);
    }
    out[0] = now;
    scale += now;
    out.map(|j| (j / scale) * (j / scale))
}

#[cfg(test)]
mod tests;
