//! The series itself: what each polarisation brings, and how many terms are needed.

use super::super::real::Real;
use super::super::thin_film::Admittances;
use super::super::transform::{self, END_NM, FAR_END_NM, GREATEST, Transform};
use super::MAX_ORDER;

/// The series of one polarisation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Series<F> {
    /// Mean transmittance over all phases, `A`.
    pub(super) a: F,
    /// Mean reflectance over all phases, `1 - A`.
    pub(super) r: F,
    /// Ratio of successive terms, `q = -r01 r12`.
    pub(super) q: F,
}

impl<F: Real> Series<F> {
    /// Without cancellation, in admittances (y > 0): `A = 4 x y z/((x + z)(x z + y^2))` and
    /// `1 - A = (x (y - z)^2 + z (x - y)^2)/((x + z)(x z + y^2))`.
    ///
    /// Source: `A = (1 - a^2)(1 - b^2)/(1 - q^2)` with `a = (x - y)/(x + y)`, `b = (y - z)/(y + z)`, multiplied out.
    #[inline(always)]
    pub(super) fn new(Admittances { x, yy, z }: Admittances<F>, y: F) -> Self {
        let den = (x + z) * (x * z + yy);
        let (xy, yz) = (x - y, y - z);
        Self {
            a: F::from_f64(4.0) * x * y * z / den,
            r: (x * yz.squared() + z * xy.squared()) / den,
            q: -(xy * yz / ((x + y) * (y + z))),
        }
    }
}

/// Both polarisations at one direction; `path` is the path difference, nm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Both<F> {
    pub(super) s: Series<F>,
    pub(super) p: Series<F>,
    pub(super) path: F,
}

impl<F: Real> Both<F> {
    /// Terms 1 to `order` with this transform of the path difference. Both polarisations share it.
    #[inline(always)]
    pub(super) fn sum(&self, order: u16, transform: impl Fn(F) -> [F; 3]) -> [F; 3] {
        let Self { s, p, path } = *self;
        let mut rgb = [(s.r + p.r) * F::from_f64(0.5); 3];
        let (mut ts, mut tp, mut x) = (s.a, p.a, F::ZERO);
        for _ in 0..order {
            (ts, tp, x) = (ts * s.q, tp * p.q, x + path);
            // Minus twice the mean of both polarisations.
            let term = ts + tp;
            let c = transform(x);
            rgb = std::array::from_fn(|i| rgb[i] - term * c[i]);
        }
        rgb
    }

    /// Terms 1 to `order`, as far as the table goes.
    #[inline(always)]
    pub(super) fn short(&self, table: &Transform<F>, order: u16) -> [F; 3] {
        // Of a film of millimetres not even the first.
        let order = if self.path < F::from_f64(END_NM) { order } else { 0 };
        self.sum(order, |x| table.at(x))
    }

    /// Terms 1 to `order`, the first of them by quadrature where the table ends.
    pub(super) fn long(&self, table: &Transform<F>, order: u16) -> [F; 3] {
        // Terms further on are of strong films, and cancel.
        let exact = self.path * F::from_f64(8.5);
        let most = (FAR_END_NM / self.path.to_f64()).min(f64::from(order)) as u16;
        self.sum(most, |x| {
            if x.to_f64() >= END_NM && x <= exact {
                transform::exact(x.to_f64()).map(F::from_f64)
            } else {
                table.at(x)
            }
        })
    }

    /// Terms after which at most `left` remains: `2 A |q|^(K+1)/(1 - |q|) max|C|` for each polarisation, or all that the
    /// transform's table has; `None` where these are too many, and the film so thin that summing wavelengths is better.
    pub(super) fn order(&self, left: f64) -> Option<u16> {
        let terms = |series: Series<F>| {
            let (a, q) = (series.a.to_f64(), series.q.to_f64().abs());
            let rest = left * (1.0 - q) / (2.0 * a * GREATEST);
            if rest >= 1.0 || q == 0.0 {
                return 0.0;
            }
            // 1 - q may vanish in rounding: as many as there can be.
            if q >= 1.0 { f64::INFINITY } else { (libm::log(rest) / libm::log(q)).ceil().max(0.0) }
        };
        let path = self.path.to_f64();
        let needed = terms(self.s).max(terms(self.p)).min((END_NM / path).ceil());
        // A film of less than half a wave has no fringes: 1 nm steps of the wavelength are then right to 1e-9.
        if needed > 64.0 && path < 150.0 || needed > f64::from(MAX_ORDER) {
            return None;
        }
        Some(needed as u16)
    }
}
