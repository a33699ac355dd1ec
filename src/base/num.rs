//! Portable elementary functions: the same bits on every platform and SIMD level, and vectorisable.
//!
//! std's `sin`, `exp` and `pow` call the C library, which differs between platforms; these are polynomials over
//! `+ - *` and bit operations only. Measured errors are asserted in this file's tests.

use std::f32::consts::PI;

/// Linear interpolation `a + (b - a) t`.
#[inline(always)]
pub fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// `x` limited to [0, 1]; NaN gives 0.
#[inline(always)]
pub fn saturate(x: f32) -> f32 {
    // `max` first: f32::max returns the other operand for NaN.
    x.max(0.0).min(1.0)
}

/// Cubic Hermite step from 0 at `e0` to 1 at `e1`; a hard step at `e1` where `e0 == e1`; `e0 > e1` falls.
#[inline(always)]
pub fn smoothstep(e0: f32, e1: f32, x: f32) -> f32 {
    let t = linear_step(e0, e1, x);
    t * t * (3.0 - 2.0 * t)
}

/// Linear step from 0 at `e0` to 1 at `e1`; a hard step at `e1` where `e0 == e1`; `e0 > e1` falls.
#[inline(always)]
pub fn linear_step(e0: f32, e1: f32, x: f32) -> f32 {
    let width = e1 - e0;
    let t = (x - e0) / if width == 0.0 { 1.0 } else { width };
    let hard = if x >= e1 { 1.0 } else { 0.0 };
    if width == 0.0 { hard } else { saturate(t) }
}

/// `sqrt(max(x, 0))`.
#[inline(always)]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// Polynomial smooth minimum with blend width `k >= 0`; k = 0 is the exact minimum.
///
/// Source: Inigo Quilez, "Smooth minimum", quadratic form.
#[inline(always)]
pub fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / if k > 0.0 { k } else { 1.0 };
    a.min(b) - h * h * k * 0.25
}

/// Polynomial smooth maximum with blend width `k >= 0`; k = 0 is the exact maximum.
#[inline(always)]
pub fn smooth_max(a: f32, b: f32, k: f32) -> f32 {
    -smooth_min(-a, -b, k)
}

/// `x - floor(x)`, in [0, 1]; the rounding of tiny negative x can give exactly 1.
#[inline(always)]
pub fn fract(x: f32) -> f32 {
    x - x.floor()
}

/// The representative of `x` modulo 1 in [-0.5, 0.5]: a signed distance on the unit torus.
#[inline(always)]
pub fn wrap_half(x: f32) -> f32 {
    x - (x + 0.5).floor()
}

/// `sin(2 pi x)` for x in turns, |x| < 2^22; maximum absolute error 1.5e-7.
#[inline(always)]
pub fn sin_turns(x: f32) -> f32 {
    // Reduce to [-1/4, 1/4] turns: sin(pi - a) = sin(a).
    let r = x - (x + 0.5).floor();
    let r = if r > 0.25 { 0.5 - r } else { r };
    let r = if r < -0.25 { -0.5 - r } else { r };
    // Taylor series of sin in a = 2 pi r, |a| <= pi/2, to a^11: truncation below 6e-8.
    let a = 2.0 * PI * r;
    let s = a * a;
    a * (1.0
        + s * (-1.666_666_7e-1
            + s * (8.333_333e-3 + s * (-1.984_127e-4 + s * (2.755_731_9e-6 + s * -2.505_210_8e-8)))))
}

/// `cos(2 pi x)` for x in turns, |x| < 2^22; maximum absolute error 2e-7.
#[inline(always)]
pub fn cos_turns(x: f32) -> f32 {
    // Reduce first: adding a quarter turn to a large x would round it.
    sin_turns(wrap_half(x) + 0.25)
}

/// `atan(z)` in turns for |z| <= tan(pi/8); maximum error 3e-7 turns.
#[inline(always)]
pub fn atan_turns(z: f32) -> f32 {
    let s = z * z;
    let p = z
        * (1.0
            + s * (-0.333_333_33
                + s * (0.2 + s * (-0.142_857_15 + s * (0.111_111_11 + s * (-0.090_909_09 + s * 0.06))))));
    p * (0.5 / PI)
}

/// `atan2(y, x)` in turns, in [-0.5, 0.5]; (0, 0) gives 0; maximum error 4e-7 turns.
#[inline(always)]
pub fn atan2_turns(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (lo, hi) = (ax.min(ay), ax.max(ay));
    let t = if hi > 0.0 { lo / hi } else { 0.0 };
    // Reduce [0, 1] to [-0.4142, 0.4142] by atan(t) = pi/4 + atan((t - 1) / (t + 1)).
    let far = t > 0.414_213_57;
    let z = if far { (t - 1.0) / (t + 1.0) } else { t };
    let a = (if far { 0.125 } else { 0.0 }) + atan_turns(z);
    let a = if ay > ax { 0.25 - a } else { a };
    let a = if x < 0.0 { 0.5 - a } else { a };
    if y < 0.0 { -a } else { a }
}

/// `3 * 2^22`: added to a number of less than 22 bits it rounds it to a whole one, which is then in the lowest bits.
pub const WHOLE: f32 = 12_582_912.0;

/// `2^i` for whole i in [-126, 127], given `i + WHOLE`: without a cast, which LLVM makes number by number for AVX-512.
#[inline(always)]
pub fn power_of_two(whole: f32) -> f32 {
    f32::from_bits((whole.to_bits() << 23).wrapping_add(0x3f80_0000))
}

/// The whole part of `v` in [0, 2^23): the same as a cast, which LLVM makes number by number for AVX-512.
#[inline(always)]
pub fn whole(v: f32) -> u32 {
    // At 2^23 and above floats are whole numbers: the sum is `v` rounded, at most one too great.
    let rounded = v + 8_388_608.0;
    let one_too_great = u32::from(rounded - 8_388_608.0 > v);
    (rounded.to_bits() - one_too_great) & 0x007f_ffff
}

/// `2^f` for |f| <= 1/2: Taylor series of `e^(f ln 2)` to f^7, truncation 5e-9.
#[inline(always)]
pub fn exp2_fraction(f: f32) -> f32 {
    1.0 + f
        * (0.693_147_2
            + f * (0.240_226_51
                + f * (0.055_504_11
                    + f * (0.009_618_129
                        + f * (0.001_333_355_8 + f * (0.000_154_035_3 + f * 0.000_015_252_7))))))
}

/// `2^x`, x clamped to [-126, 127]; maximum relative error 2e-7.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let x = x.max(-126.0).min(127.0);
    let i = (x + 0.5).floor();
    exp2_fraction(x - i) * power_of_two(i + WHOLE)
}

/// `log2(x)` for normal x > 0 (smaller x read as 2^-126); maximum absolute error 3e-7 for x in [1/2, 2].
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let bits = x.max(f32::MIN_POSITIVE).to_bits() as i32;
    // Exponent so that the mantissa lies in [sqrt(1/2), sqrt(2)).
    let e = (bits - 0x3f35_04f3) >> 23;
    let m = f32::from_bits((bits - (e << 23)) as u32);
    let t = (m - 1.0) / (m + 1.0);
    let s = t * t;
    // 2 atanh(t) / ln 2.
    let p = t
        * (2.885_390_1
            + s * (0.961_796_7
                + s * (0.577_078_02 + s * (0.412_198_6 + s * (0.320_598_9 + s * 0.262_308_2)))));
    e as f32 + p
}

/// `x^p` for x >= 0; 0^0 = 1, 0^p = 0 for p > 0; relative error below 5e-6 for results in [1e-6, 1e6].
#[inline(always)]
pub fn powf(x: f32, p: f32) -> f32 {
    let y = exp2(p * log2(x));
    let y = if x <= 0.0 { 0.0 } else { y };
    if p == 0.0 { 1.0 } else { y }
}

/// Cube root, with the sign of x, for |x| <= 1e30; maximum relative error 3e-7 for normal x, and 0 for 0.
///
/// From the bits of `1 / cbrt(x)`, to 4 %, by a step of fourth order and one of second order without a division.
#[inline(always)]
pub fn cbrt(x: f32) -> f32 {
    let a = x.abs();
    let y = f32::from_bits(0x54a2_1d2a - a.to_bits() / 3);
    // How far a y^3 is from 1, and the series of (1 - e)^(-1/3).
    let e = 1.0 - a * y * y * y;
    let y = y + y * (e * (0.333_333_34 + e * (0.222_222_22 + e * 0.172_839_5)));
    let e = 1.0 - a * y * y * y;
    let y = y + y * (e * 0.333_333_34);
    (a * y * y).copysign(x)
}

/// `e^x`; relative error below 1e-5 for |x| <= 20.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    exp2(x * std::f32::consts::LOG2_E)
}

/// Mean of a slice in f64, in index order: the same at any thread count.
pub fn mean(values: &[f32]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
}

/// Least and greatest finite value of a slice; (0, 0) where there is none.
pub fn min_max(values: &[f32]) -> (f32, f32) {
    let (lo, hi) = values
        .iter()
        .filter(|v| v.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), &v| (lo.min(v), hi.max(v)));
    if lo <= hi { (lo, hi) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_part_is_that_of_a_cast() {
        let ends = (0..=65_535u32).chain(8_388_000..8_388_607).flat_map(|k| {
            let v = k as f32;
            [v, v.next_up(), (v + 1.0).next_down(), v + 0.5, (v + 0.5).next_down(), (v + 0.5).next_up()]
        });
        for v in ends.chain([0.0, 1e-45, 0.49999997, 8_388_607.5]) {
            assert_eq!(whole(v), v as u32, "{v}");
        }
    }

    fn grid(lo: f64, hi: f64) -> impl Iterator<Item = f32> {
        (0..=200_000).map(move |i| (lo + (hi - lo) * f64::from(i) / 200_000.0) as f32)
    }

    #[test]
    fn sin_and_cos_are_within_their_stated_error_of_std_f64() {
        for x in grid(-20.0, 20.0) {
            let a = f64::from(x) * std::f64::consts::TAU;
            assert!((f64::from(sin_turns(x)) - a.sin()).abs() < 2e-7, "sin {x}");
            assert!((f64::from(cos_turns(x)) - a.cos()).abs() < 3e-7, "cos {x}");
        }
    }

    #[test]
    fn exp2_log2_powf_are_within_their_stated_error_of_std_f64() {
        for x in grid(-20.0, 20.0) {
            let e = f64::from(x).exp2();
            assert!((f64::from(exp2(x)) / e - 1.0).abs() < 3e-7, "exp2 {x}");
        }
        for x in grid(1e-3, 4.0) {
            let e = f64::from(x).log2();
            assert!((f64::from(log2(x)) - e).abs() < 4e-7 * e.abs().max(1.0), "log2 {x}");
            let e = f64::from(x).powf(2.4);
            assert!((f64::from(powf(x, 2.4)) / e - 1.0).abs() < 5e-6, "powf {x}");
        }
        assert_eq!(powf(0.0, 0.0), 1.0);
        assert_eq!(powf(0.0, 2.0), 0.0);
        assert!(exp2(1e30).is_finite() && exp2(-1e30) >= 0.0);
    }

    #[test]
    fn cbrt_is_within_its_stated_error_of_std_f64() {
        for x in grid(-126.0, 99.0).map(f32::exp2).chain(grid(1e-3, 1.0)) {
            let e = f64::from(x).cbrt();
            assert!((f64::from(cbrt(x)) / e - 1.0).abs() < 3e-7, "{x}: {}", cbrt(x));
            assert_eq!(cbrt(-x), -cbrt(x));
        }
        assert_eq!(cbrt(0.0), 0.0);
        assert!(cbrt(1e-45) < 1e-14);
    }

    #[test]
    fn atan2_is_within_its_stated_error_of_std_f64() {
        for i in 0..100_000 {
            let a = f64::from(i) / 100_000.0 * std::f64::consts::TAU;
            let (y, x) = (a.sin() as f32, a.cos() as f32);
            let e = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
            let d = (f64::from(atan2_turns(y, x)) - e).abs();
            assert!(d.min(1.0 - d) < 4e-7, "{a}: {d}");
        }
        assert_eq!(atan2_turns(0.0, 0.0), 0.0);
    }

    #[test]
    fn steps_have_their_limits() {
        assert_eq!(linear_step(0.5, 0.5, 0.49), 0.0);
        assert_eq!(linear_step(0.5, 0.5, 0.5), 1.0);
        assert_eq!(smoothstep(1.0, 0.0, 0.0), 1.0);
        assert_eq!(smooth_min(1.0, 2.0, 0.0), 1.0);
        assert_eq!(saturate(f32::NAN), 0.0);
    }
}
