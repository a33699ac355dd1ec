//! The number that a plan is reckoned in plainly: f64 and f32 with the functions of `libm`, and f32 with our own.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::base::num;

/// A real number with the functions that kernels use.
pub(super) trait Number:
    Copy
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest number to `x`.
    fn new(x: f64) -> Self;
    /// The same number as f64.
    fn get(self) -> f64;
    /// Square root of x >= 0.
    fn sqrt(self) -> Self;
    /// `sin(2 pi x)`.
    fn sin_turns(self) -> Self;
    /// `cos(2 pi x)`.
    fn cos_turns(self) -> Self;
    /// `atan2(y, x)` in turns.
    fn atan2_turns(y: Self, x: Self) -> Self;
    /// `e^x`.
    fn exp(self) -> Self;
    /// `x^p` for x > 0.
    fn power(self, p: Self) -> Self;

    /// Greatest whole number that is not above.
    fn floor(self) -> Self {
        Self::new(self.get().floor())
    }

    /// The lesser; a NaN loses.
    fn min(self, other: Self) -> Self {
        if self <= other || other.get().is_nan() { self } else { other }
    }

    /// The greater; a NaN loses.
    fn max(self, other: Self) -> Self {
        if self >= other || other.get().is_nan() { self } else { other }
    }

    /// Absolute value.
    fn abs(self) -> Self {
        Self::new(self.get().abs())
    }

    /// Limited to [0, 1]; NaN gives 0.
    fn saturate(self) -> Self {
        self.max(Self::new(0.0)).min(Self::new(1.0))
    }

    /// `a + (b - a) t`.
    fn lerp(a: Self, b: Self, t: Self) -> Self {
        a + (b - a) * t
    }

    /// `x - floor(x)`.
    fn fract(self) -> Self {
        self - self.floor()
    }

    /// The representative modulo 1 in [-0.5, 0.5].
    fn wrap_half(self) -> Self {
        self - (self + Self::new(0.5)).floor()
    }

    /// `x^p` for x >= 0, as [`num::powf`] has it at 0.
    fn powf(self, p: Self) -> Self {
        match (p.get() == 0.0, self.get() <= 0.0) {
            (true, _) => Self::new(1.0),
            (_, true) => Self::new(0.0),
            _ => self.power(p),
        }
    }
}

impl Number for f64 {
    fn new(x: f64) -> Self {
        x
    }
    fn get(self) -> f64 {
        self
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn sin_turns(self) -> Self {
        libm::sin(std::f64::consts::TAU * self.wrap_half())
    }
    fn cos_turns(self) -> Self {
        libm::cos(std::f64::consts::TAU * self.wrap_half())
    }
    fn atan2_turns(y: Self, x: Self) -> Self {
        libm::atan2(y, x) / std::f64::consts::TAU
    }
    fn exp(self) -> Self {
        libm::exp(self)
    }
    fn power(self, p: Self) -> Self {
        libm::pow(self, p)
    }
}

impl Number for f32 {
    fn new(x: f64) -> Self {
        x as Self
    }
    fn get(self) -> f64 {
        f64::from(self)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn sin_turns(self) -> Self {
        libm::sinf(std::f32::consts::TAU * self.wrap_half())
    }
    fn cos_turns(self) -> Self {
        libm::cosf(std::f32::consts::TAU * self.wrap_half())
    }
    fn atan2_turns(y: Self, x: Self) -> Self {
        libm::atan2f(y, x) / std::f32::consts::TAU
    }
    fn exp(self) -> Self {
        libm::expf(self)
    }
    fn power(self, p: Self) -> Self {
        libm::powf(self, p)
    }
}

/// f32 with the polynomials of [`num`].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Ours(f32);

impl Number for Ours {
    fn new(x: f64) -> Self {
        Self(x as f32)
    }
    fn get(self) -> f64 {
        f64::from(self.0)
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn sin_turns(self) -> Self {
        Self(num::sin_turns(self.0))
    }
    fn cos_turns(self) -> Self {
        Self(num::cos_turns(self.0))
    }
    fn atan2_turns(y: Self, x: Self) -> Self {
        Self(num::atan2_turns(y.0, x.0))
    }
    fn exp(self) -> Self {
        Self(num::exp(self.0))
    }
    fn power(self, p: Self) -> Self {
        Self(num::powf(self.0, p.0))
    }
}

macro_rules! operators {
    ($($trait:ident $name:ident $op:tt;)*) => {
        $(impl $trait for Ours {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        })*
    };
}

operators! {
    Add add +;
    Sub sub -;
    Mul mul *;
    Div div /;
}

impl Neg for Ours {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn functions<N: Number>(x: f64, y: f64) -> [f64; 6] {
        let (x, y) = (N::new(x), N::new(y));
        [x.sin_turns(), x.cos_turns(), N::atan2_turns(y, x), x.exp(), x.abs().power(y), x.wrap_half()]
            .map(Number::get)
    }

    #[test]
    fn all_numbers_have_the_same_functions() {
        for (x, y) in [(0.3, 1.7), (-2.4, 0.2), (0.01, -0.5), (7.25, 0.9)] {
            let exact = functions::<f64>(x, y);
            for other in [functions::<f32>(x, y), functions::<Ours>(x, y)] {
                for (a, b) in exact.iter().zip(other) {
                    assert!((a - b).abs() < 1e-5 * a.abs().max(1.0), "{x} {y}: {exact:?} {other:?}");
                }
            }
        }
        assert_eq!(functions::<f64>(0.25, 1.0)[0], 1.0);
    }

    #[test]
    fn the_lesser_the_greater_and_powers_of_0_are_those_of_our_kernels() {
        fn all<N: Number>() {
            let [zero, one, none] = [0.0, 1.0, f64::NAN].map(N::new);
            assert_eq!((zero.min(one).get(), zero.max(one).get(), none.saturate().get()), (0.0, 1.0, 0.0));
            assert_eq!((none.min(one).get(), none.max(zero).get()), (1.0, 0.0));
            assert_eq!((zero.powf(zero).get(), zero.powf(one).get()), (1.0, 0.0));
        }
        all::<f64>();
        all::<f32>();
        all::<Ours>();
    }
}
