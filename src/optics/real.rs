//! The number that optics is computed in: f32 for shading, f64 for truth.

use std::fmt::{Debug, Display};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use super::transform::Transform;
use crate::base::num;

/// A real number with portable elementary functions.
pub trait Real:
    Copy
    + Debug
    + Display
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Cosines between 0 and this are taken as this: below it squares of admittances would underflow.
    const LEAST_COSINE: Self;

    /// The nearest number to `x`.
    fn from_f64(x: f64) -> Self;
    /// The same number as f64.
    fn to_f64(self) -> f64;
    /// `max(x, 0)^(1/2)`.
    fn safe_sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Greatest whole number that is not above.
    fn floor(self) -> Self;
    /// The whole part of a number that is not negative, NaN is 0, at most 2^31 - 1.
    fn whole(self) -> usize;
    /// The lesser; a NaN loses.
    fn min(self, other: Self) -> Self;
    /// The greater; a NaN loses.
    fn max(self, other: Self) -> Self;
    /// `e^x`.
    fn exp(self) -> Self;
    /// `e^-x` for x >= 0, in f32 without a call, so that loops over bands vectorise; 0 from 87 on in f32.
    fn decay(self) -> Self;
    /// Natural logarithm of x > 0.
    fn ln(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// `(sin(pi x), cos(pi x))` for x in [-1/2, 1/2]; exact 0 and 1 at the ends and in the middle.
    fn sin_cos_half_turns(self) -> (Self, Self);
    /// What `y`, the rounded `sqrt(n1^2 - n0^2 + n0^2 c^2)`, lacks of the true root; 0 where that is not worth its time.
    #[inline(always)]
    fn root_rest(_n0: Self, _n1: Self, _cosine: Self, _y: Self) -> Self {
        Self::ZERO
    }
    /// `2 d (y + rest)/lambda` less the nearest whole number.
    #[inline(always)]
    fn reduced_turns(d: Self, y: Self, _rest: Self, lambda: Self) -> Self {
        let turns = (d + d) * y / lambda;
        turns - (turns + Self::from_f64(0.5)).floor()
    }
    /// `sin^2(2 pi d (y + rest)/lambda)`: half the phase of a film. `inverse` is 1/lambda.
    #[inline(always)]
    fn phase_sine_squared(d: Self, y: Self, rest: Self, lambda: Self, _inverse: Self) -> Self {
        Self::reduced_turns(d, y, rest, lambda).sin_cos_half_turns().0.squared()
    }
    /// The transform of the colour weights in this precision, made at its first use.
    fn transform() -> &'static Transform<Self>;

    /// `x^2`.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    /// Limited to [0, 1]; NaN gives 0.
    #[inline(always)]
    fn saturate(self) -> Self {
        self.max(Self::ZERO).min(Self::ONE)
    }
}

macro_rules! shared {
    ($real:ty) => {
        const ZERO: Self = 0.0;
        const ONE: Self = 1.0;

        #[inline(always)]
        fn safe_sqrt(self) -> Self {
            <$real>::max(self, 0.0).sqrt()
        }
        #[inline(always)]
        fn abs(self) -> Self {
            <$real>::abs(self)
        }
        #[inline(always)]
        fn floor(self) -> Self {
            <$real>::floor(self)
        }
        #[inline(always)]
        fn whole(self) -> usize {
            // Of 32 bits and signed: one instruction, where `floor` is a call.
            (self as i32).max(0) as usize
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            <$real>::min(self, other)
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            <$real>::max(self, other)
        }
    };
}

impl Real for f32 {
    shared!(f32);
    const LEAST_COSINE: Self = 1e-9;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        libm::expf(self)
    }
    #[inline(always)]
    fn decay(self) -> Self {
        // No `floor`, which is a call on plain x86-64. The digits are those of `num::exp2` but where a half is rounded the
        // other way.
        let x = (self * -std::f32::consts::LOG2_E).max(-126.0).min(127.0);
        let whole = x + num::WHOLE;
        let e = num::exp2_fraction(x - (whole - num::WHOLE)) * num::power_of_two(whole);
        if self < 87.0 { e } else { 0.0 }
    }
    #[inline(always)]
    fn ln(self) -> Self {
        num::log2(self) * std::f32::consts::LN_2
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        libm::tanhf(self)
    }
    #[inline(always)]
    fn phase_sine_squared(d: Self, y: Self, _rest: Self, _lambda: Self, inverse: Self) -> Self {
        // Adding and taking away 3 * 2^22 rounds to a whole number, where `floor` would be a call on plain x86-64. A film
        // of more turns than 2^22 is half a metre thick: its phase is lost in f32 anyway.
        const ROUND: f32 = 12_582_912.0;
        let turns = ((d + d) * y * inverse).min(4_194_304.0);
        let a = (turns - ((turns + ROUND) - ROUND)) * std::f32::consts::PI;
        // Taylor series of sin to a^11, |a| <= pi/2: truncation below 6e-8.
        let s = a * a;
        let sin = a
            * (1.0
                + s * (-1.666_666_7e-1
                    + s * (8.333_333e-3 + s * (-1.984_127e-4 + s * (2.755_731_9e-6 + s * -2.505_210_8e-8)))));
        sin * sin
    }
    #[inline(always)]
    fn sin_cos_half_turns(self) -> (Self, Self) {
        // cos(pi x) = sin(2 pi (1/4 - |x|/2)); the difference is exact near the zero of the cosine.
        (num::sin_turns(self * 0.5), num::sin_turns(0.25 - self.abs() * 0.5))
    }
    fn transform() -> &'static Transform<Self> {
        Transform::single()
    }
}

impl Real for f64 {
    shared!(f64);
    const LEAST_COSINE: Self = 1e-60;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn exp(self) -> Self {
        libm::exp(self)
    }
    #[inline(always)]
    fn decay(self) -> Self {
        libm::exp(-self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        libm::log(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        libm::tanh(self)
    }
    #[inline(always)]
    fn sin_cos_half_turns(self) -> (Self, Self) {
        use std::f64::consts::PI;
        (libm::sin(PI * self), libm::sin(PI * (0.5 - self.abs())))
    }
    // A film of 2.5 mm has ten thousand turns: rounded thrice, R would be 5e-13 off.
    #[inline]
    fn root_rest(n0: Self, n1: Self, cosine: Self, y: Self) -> Self {
        let (x, x_rest) = product(n0, cosine);
        let sum = [product(n1, n1), product(-n0, n0), product(x, x), (2.0 * x * x_rest, 0.0), product(-y, y)]
            .into_iter()
            .fold((0.0, 0.0), |(high, low), (h, l)| {
                let total = high + h;
                let part = total - high;
                (total, low + ((high - (total - part)) + (h - part)) + l)
            });
        let rest = (sum.0 + sum.1) / (2.0 * y);
        // At the critical angle y is all rounding, and the phase must be that of this y.
        if rest.abs() <= 1e-8 * y { rest } else { 0.0 }
    }
    #[inline]
    fn reduced_turns(d: Self, y: Self, rest: Self, lambda: Self) -> Self {
        let (path, path_rest) = product(2.0 * d, y);
        let turns = path / lambda;
        let (back, back_rest) = product(turns, lambda);
        let low = ((path - back) - back_rest + path_rest + 2.0 * d * rest) / lambda;
        turns - (turns + 0.5).floor() + low
    }
    fn transform() -> &'static Transform<Self> {
        Transform::double()
    }
}

/// `a b` as a rounded product and its rounding error, exactly (Dekker 1971; Veltkamp's split).
#[inline(always)]
fn product(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let c = x * 134_217_729.0;
        let high = c - (c - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    let p = a * b;
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_of_thick_films_are_right_to_the_last_digits() {
        // n0 0, so that y = n1 = 1.5 exactly: 2 d y/lambda = 3e9/7 turns.
        assert_eq!(f64::root_rest(0.0, 1.5, 0.3, 1.5), 0.0);
        let turns = f64::reduced_turns(1e9, 1.5, 0.0, 7.0);
        assert!((turns + 3.0 / 7.0).abs() < 1e-15, "{turns}");
        // sqrt(2) and what its rounding lost (the digits are in any table).
        let rest = f64::root_rest(1.0, 2f64.sqrt(), 0.0, 1.0);
        assert!((rest - 1.36e-16).abs() < 1e-17, "{rest:e}");
        let (p, rest) = product(1.0 + f64::EPSILON, 1.0 + f64::EPSILON);
        assert_eq!((p, rest), (1.0 + 2.0 * f64::EPSILON, f64::EPSILON * f64::EPSILON));
    }
}
