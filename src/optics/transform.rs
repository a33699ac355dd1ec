//! The cosine transform of the colour weights: what a path difference does to a colour.
//!
//! `C_c(x) = int W_c(lambda) cos(2 pi x/lambda) d lambda` with the weights of [`super::cie`]; C(0) = 1, and C falls to
//! nothing for path differences of tens of micrometres, where the eye sees only the mean. Source: the idea is that of
//! Belcour & Barla 2017 (A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence, sec. 4) and of
//! Blender Cycles' table; here it is exact. `S(x) = int_0^x C` serves the footprint filter.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::cie;
use super::real::Real;

/// Path difference between two entries, nm: for C's shortest period, 380 nm, cubic interpolation is then right to 1e-7.
pub const STEP_NM: f64 = 4.0;
/// In single precision every so manieth entry is kept: 1e-6 is all that f32 is good for, and caches are small.
const STRIDE: usize = 2;
/// Intervals of the table.
const INTERVALS: usize = 10_240;
/// Path difference from which C is taken as 0, nm.
pub const END_NM: f64 = STEP_NM * INTERVALS as f64;
/// Path difference up to which [`exact`] is right, nm; |C| is below 1e-4 there.
pub const FAR_END_NM: f64 = 140_000.0;
/// Bound of |C| of any channel.
pub const GREATEST: f64 = 1.6;

/// C at a path difference up to [`FAR_END_NM`], by quadrature: slow. Beyond the table |C| is below 5e-4.
pub fn exact(x: f64) -> [f64; 3] {
    cie::integrate(|l| libm::cos(TAU * (x / l).fract()))
}

/// One entry: for red, green and blue.
#[derive(Clone, Copy, Debug, Default)]
struct Entry<F> {
    /// C.
    c: [F; 3],
    /// Derivative of C times the step.
    slope: [F; 3],
}

/// The transform as a table with exact slopes, interpolated by cubics (Hermite).
#[derive(Debug)]
pub struct Transform<F> {
    entries: Vec<Entry<F>>,
    /// S at the same places, nm.
    integrals: Vec<[F; 3]>,
    /// Path difference between two entries, nm, and its inverse.
    step: F,
    per_nm: F,
}

impl Transform<f64> {
    /// The shared one in double precision; made at its first use (about a tenth of a second).
    pub fn double() -> &'static Self {
        static TABLE: OnceLock<Transform<f64>> = OnceLock::new();
        TABLE.get_or_init(Self::compute)
    }

    /// Every entry by the quadrature of [`cie::nodes`].
    fn compute() -> Self {
        const CHUNK: usize = 512;
        let chunk = |chunk: usize| {
            let first = chunk * CHUNK;
            let count = CHUNK.min(INTERVALS + 1 - first);
            let mut entries = vec![(Entry::<f64>::default(), [0.0; 3]); count];
            for node in cie::nodes() {
                // cos and sin of 2 pi x/lambda, turned by one step from entry to entry.
                let omega = TAU / node.wavelength_nm;
                let start = (first as f64 * STEP_NM / node.wavelength_nm).fract() * TAU;
                let (mut sin, mut cos) = (libm::sin(start), libm::cos(start));
                let (dsin, dcos) = (libm::sin(omega * STEP_NM), libm::cos(omega * STEP_NM));
                for (entry, integral) in &mut entries {
                    for c in 0..3 {
                        let w = node.rgb[c];
                        entry.c[c] += w * cos;
                        entry.slope[c] -= w * omega * STEP_NM * sin;
                        integral[c] += w / omega * sin;
                    }
                    (cos, sin) = (cos * dcos - sin * dsin, sin * dcos + cos * dsin);
                }
            }
            entries
        };
        let chunks = (INTERVALS + 1).div_ceil(CHUNK);
        let chunks: Vec<Vec<_>> = (0..chunks).into_par_iter().map(chunk).collect();
        let (entries, integrals) = chunks.into_iter().flatten().unzip();
        Self { entries, integrals, step: STEP_NM, per_nm: 1.0 / STEP_NM }
    }
}

impl Transform<f32> {
    /// The shared one in single precision.
    pub fn single() -> &'static Self {
        static TABLE: OnceLock<Transform<f32>> = OnceLock::new();
        TABLE.get_or_init(|| {
            let (double, step) = (Transform::double(), STRIDE as f64 * STEP_NM);
            let entry = |e: &Entry<f64>| Entry {
                c: e.c.map(|v| v as f32),
                slope: e.slope.map(|v| (STRIDE as f64 * v) as f32),
            };
            Self {
                entries: double.entries.iter().step_by(STRIDE).map(entry).collect(),
                integrals: double.integrals.iter().step_by(STRIDE).map(|s| s.map(|v| v as f32)).collect(),
                step: step as f32,
                per_nm: (1.0 / step) as f32,
            }
        })
    }
}

impl<F: Real> Transform<F> {
    /// The interval of `x`, nm, and the place in it, in [0, 1).
    #[inline(always)]
    fn place(&self, x: F) -> (usize, F) {
        let position = x.abs() * self.per_nm;
        let i = position.whole();
        (i, position - F::from_f64(i as f64))
    }

    /// C at a path difference, nm, for red, green and blue; 0 from [`END_NM`] on.
    #[inline]
    pub fn at(&self, x: F) -> [F; 3] {
        let (i, t) = self.place(x);
        let Some([a, b]) = self.entries.get(i..i + 2) else { return [F::ZERO; 3] };
        hermite(a.c, a.slope, b.c, b.slope, t)
    }

    /// `S(x) = int_0^x C`, nm, for x >= 0; constant from [`END_NM`] on.
    #[inline]
    pub fn integral(&self, x: F) -> [F; 3] {
        let (i, t) = self.place(x);
        let (Some([a, b]), Some(&[sa, sb])) = (self.entries.get(i..i + 2), self.integrals.get(i..i + 2))
        else {
            return self.integrals[self.integrals.len() - 1];
        };
        let slope = |e: &Entry<F>| e.c.map(|c| c * self.step);
        hermite(sa, slope(a), sb, slope(b), t)
    }

    /// Mean of C over path differences from `a` to `b`, nm, 0 <= a, b: what a pixel sees whose path difference varies so.
    ///
    /// `(S(b) - S(a))/(b - a)`; for narrow footprints C in the middle, where the quotient would cancel.
    #[inline]
    pub fn mean(&self, a: F, b: F) -> [F; 3] {
        let width = (b - a).abs();
        if width < F::ONE {
            return self.at((a + b) * F::from_f64(0.5));
        }
        let (sa, sb) = (self.integral(a.min(b)), self.integral(a.max(b)));
        std::array::from_fn(|c| (sb[c] - sa[c]) / width)
    }
}

#[inline(always)]
fn hermite<F: Real>(a: [F; 3], da: [F; 3], b: [F; 3], db: [F; 3], t: F) -> [F; 3] {
    let (two, three) = (F::from_f64(2.0), F::from_f64(3.0));
    let u = F::ONE - t;
    // Weights of the values and of the slopes at both ends.
    let (wb, sa, sb) = (t * t * (three - two * t), t * u * u, -(t * t * u));
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * wb + da[c] * sa + db[c] * sb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anchors_are_the_independent_values() {
        let anchors = [
            (0.0, [1.0, 1.0, 1.0]),
            (100.0, [0.56713757, 0.40450133, 0.15146940]),
            (550.0, [0.71283453, 1.02787605, 0.11752581]),
            (1000.0, [-1.20404661, 0.63780457, 0.21135174]),
            (3000.0, [0.52318392, -0.19102175, -0.09696641]),
        ];
        for (x, expected) in anchors {
            for c in 0..3 {
                let at = Transform::double().at(x)[c];
                assert!((at - expected[c]).abs() < 1e-7, "{x} {c}: {at}");
            }
        }
    }

    #[test]
    fn the_independent_table_is_met_at_every_entry() {
        let text = include_str!("../../tests/reference/fourier_table_20nm.csv");
        let mut worst = 0.0f64;
        for line in text.lines().skip(1) {
            let n: Vec<f64> = line.split(',').map(|w| w.parse().expect("a number")).collect();
            let at = Transform::double().at(n[0]);
            for c in 0..3 {
                worst = worst.max((at[c] - n[c + 1]).abs());
            }
        }
        println!("worst {worst:e}");
        // That table is a sum over fractions of a nanometre, ours is the integral.
        assert!(worst < 5e-7, "{worst:e}");
    }

    #[test]
    fn between_entries_the_table_is_the_integral() {
        let (mut worst, mut single) = (0.0f64, 0.0f64);
        for i in 0..500 {
            let x = 0.37 + f64::from(i) * 81.7 * f64::from(i) / 500.0;
            let (e, at, f) = (exact(x), Transform::double().at(x), Transform::single().at(x as f32));
            for c in 0..3 {
                worst = worst.max((at[c] - e[c]).abs());
                single = single.max((f64::from(f[c]) - e[c]).abs());
            }
        }
        let entries = &Transform::double().entries;
        let greatest = entries.iter().flat_map(|e| e.c).fold(0.0f64, |m, c| m.max(c.abs()));
        println!("f64 {worst:e}, f32 {single:e}, greatest {greatest}, last {:?}", exact(END_NM));
        assert!(worst < 1e-7 && single < 3e-5, "{worst:e} {single:e}");
        assert!(greatest < GREATEST);
        let far =
            |x: f64| (0..300).flat_map(|i| exact(x + 7.0 * f64::from(i))).fold(0.0f64, |m, c| m.max(c.abs()));
        let (end, far_end) = (far(END_NM), far(FAR_END_NM));
        println!("greatest from the end {end:e}, from the far end {far_end:e}");
        assert!(end < 5e-4 && far_end < 1e-4, "{end:e} {far_end:e}");
    }

    #[test]
    fn the_integral_is_that_of_the_transform() {
        let table = Transform::double();
        for (a, b) in [(0.0, 50.0), (300.0, 900.0), (1000.0, 1003.9), (777.0, 781.5)] {
            let n = 2000;
            for c in 0..3 {
                let sum: f64 =
                    (0..n).map(|i| table.at(a + (b - a) * (f64::from(i) + 0.5) / f64::from(n))[c]).sum();
                let mean = table.mean(a, b)[c];
                assert!((mean - sum / f64::from(n)).abs() < 2e-5, "{a} {b} {c}: {mean}");
            }
        }
    }
}
