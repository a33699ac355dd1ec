//! Kernels of encoding: values to codes, codes to bytes, and how far codes are from values.

use super::srgb::Codes;
use crate::base::{color, hash, num};
use crate::multiversion;

/// The nearest sample of `x` in [0, 1]; at 16 bits the f32 product is exact to 1/256 of a step.
#[inline(always)]
fn nearest(x: f32, max: f32) -> u16 {
    num::whole(num::saturate(x) * max + 0.5) as u16
}

/// The sample below or above `x`, chosen so that the mean over texels is `x`; exact samples stay as they are.
#[inline(always)]
fn dithered(x: f32, max: f32, seed: u32, col: u32, row: u32) -> u16 {
    // One step less than 1: 255 + 0.99999 must not round to 256 in f32.
    let noise = hash::unit(hash::hash2(seed, col, row)) * 0.9999;
    num::whole(num::saturate(x) * max + noise) as u16
}

multiversion! {
    pub(super) fn linear(row: &[f32], offset: f32, scale: f32, max: f32, out: &mut [u16]) {
        for (o, v) in out.iter_mut().zip(row) {
            *o = nearest((*v - offset) * scale, max);
        }
    }
}

multiversion! {
    pub(super) fn linear_dithered(
        row: &[f32], offset: f32, scale: f32, max: f32, seed: u32, y: u32, out: &mut [u16],
    ) {
        for (x, (o, v)) in out.iter_mut().zip(row).enumerate() {
            *o = dithered((*v - offset) * scale, max, seed, x as u32, y);
        }
    }
}

multiversion! {
    pub(super) fn srgb(row: &[f32], max: f32, out: &mut [u16]) {
        for (o, v) in out.iter_mut().zip(row) {
            *o = nearest(color::linear_to_srgb(num::saturate(*v)), max);
        }
    }
}

multiversion! {
    pub(super) fn srgb_dithered(row: &[f32], max: f32, seed: u32, y: u32, out: &mut [u16]) {
        for (x, (o, v)) in out.iter_mut().zip(row).enumerate() {
            *o = dithered(color::linear_to_srgb(num::saturate(*v)), max, seed, x as u32, y);
        }
    }
}

/// The low 16 bits of whole numbers.
pub(super) fn ids(row: &[f32], out: &mut [u16]) {
    for (o, &id) in out.iter_mut().zip(row) {
        // `as` saturates and takes NaN to 0; ids are whole numbers, exact in f32 below 2^24.
        *o = (id as u32 & 0xffff) as u16;
    }
}

multiversion! {
    pub(super) fn pack_grey8(codes: &[u16], out: &mut [u8]) {
        for (o, &code) in out.iter_mut().zip(codes) {
            *o = code as u8;
        }
    }
}

multiversion! {
    pub(super) fn pack_grey16(codes: &[u16], out: &mut [u8]) {
        for (o, code) in out.as_chunks_mut::<2>().0.iter_mut().zip(codes) {
            *o = code.to_be_bytes();
        }
    }
}

multiversion! {
    pub(super) fn pack_rgb8(r: &[u16], g: &[u16], b: &[u16], out: &mut [u8]) {
        let out = out.as_chunks_mut::<3>().0;
        let n = out.len();
        let (r, g, b) = (&r[..n], &g[..n], &b[..n]);
        for i in 0..n {
            out[i] = [r[i] as u8, g[i] as u8, b[i] as u8];
        }
    }
}

multiversion! {
    pub(super) fn pack_rgb16(r: &[u16], g: &[u16], b: &[u16], out: &mut [u8]) {
        let out = out.as_chunks_mut::<6>().0;
        let n = out.len();
        let (r, g, b) = (&r[..n], &g[..n], &b[..n]);
        for i in 0..n {
            let (r, g, b) = (r[i].to_be_bytes(), g[i].to_be_bytes(), b[i].to_be_bytes());
            out[i] = [r[0], r[1], g[0], g[1], b[0], b[1]];
        }
    }
}

/// Independent sums, so that they vectorise: float addition is not associative, the lanes fix its order.
const LANES: usize = 16;

/// Largest and summed squared error of codes.
pub(super) type RowError = (f32, f64);

/// What codes stand for.
trait Decode: Copy {
    fn value(self, code: u16) -> f32;
}

#[derive(Clone, Copy)]
struct Linear {
    offset: f32,
    step: f32,
}

impl Decode for Linear {
    #[inline(always)]
    fn value(self, code: u16) -> f32 {
        self.offset + f32::from(code) * self.step
    }
}

/// Linear light behind the sRGB transfer function.
#[derive(Clone, Copy)]
struct Srgb {
    step: f32,
}

impl Decode for Srgb {
    #[inline(always)]
    fn value(self, code: u16) -> f32 {
        color::srgb_to_linear(f32::from(code) * self.step)
    }
}

impl Decode for &Codes {
    #[inline(always)]
    fn value(self, code: u16) -> f32 {
        self.linear(code)
    }
}

#[inline(always)]
fn error(row: &[f32], codes: &[u16], decode: impl Decode) -> RowError {
    let (mut max, mut sum) = ([0.0f32; LANES], [0.0f32; LANES]);
    let (rows, row_rest) = row.as_chunks::<LANES>();
    let (all, codes_rest) = codes.as_chunks::<LANES>();
    for (row, codes) in rows.iter().zip(all) {
        for i in 0..LANES {
            let e = (row[i] - decode.value(codes[i])).abs();
            max[i] = max[i].max(e);
            sum[i] += e * e;
        }
    }
    for (i, (&v, &code)) in row_rest.iter().zip(codes_rest).enumerate() {
        let e = (v - decode.value(code)).abs();
        max[i] = max[i].max(e);
        sum[i] += e * e;
    }
    fold(&max, &sum)
}

multiversion! {
    pub(super) fn linear_error(row: &[f32], codes: &[u16], offset: f32, step: f32) -> RowError {
        error(row, codes, Linear { offset, step })
    }
}

multiversion! {
    pub(super) fn srgb_error(row: &[f32], codes: &[u16], step: f32) -> RowError {
        error(row, codes, Srgb { step })
    }
}

multiversion! {
    /// The same for codes of 8 bits.
    pub(super) fn srgb8_error(row: &[f32], codes: &[u16], table: &Codes) -> RowError {
        error(row, codes, table)
    }
}

#[inline(always)]
fn fold(max: &[f32; LANES], sum: &[f32; LANES]) -> RowError {
    let m = max.iter().fold(0.0f32, |a, &b| a.max(b));
    (m, sum.iter().map(|&s| f64::from(s)).sum())
}

multiversion! {
    /// Least and greatest finite value: infinity and minus infinity where there is none.
    pub(super) fn extremes(row: &[f32]) -> [f32; 2] {
        let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        let (rows, rest) = row.as_chunks::<LANES>();
        for row in rows {
            for i in 0..LANES {
                // `&`, not `&&`, which LLVM makes a jump for each value.
                let (v, finite) = (row[i], row[i].abs() <= f32::MAX);
                least[i] = if finite & (v < least[i]) { v } else { least[i] };
                most[i] = if finite & (v > most[i]) { v } else { most[i] };
            }
        }
        for (i, &v) in rest.iter().enumerate() {
            if v.is_finite() {
                least[i] = least[i].min(v);
                most[i] = most[i].max(v);
            }
        }
        [
            least.into_iter().fold(f32::INFINITY, f32::min),
            most.into_iter().fold(f32::NEG_INFINITY, f32::max),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_those_of_the_finite_values() {
        let values: Vec<f32> = (0..100).map(|i| ((i * 37) % 100) as f32 - 20.0).collect();
        let mut odd = values.clone();
        odd[3] = f32::NAN;
        odd[40] = f32::INFINITY;
        odd[99] = f32::NEG_INFINITY;
        for values in [&values[..], &values[..7], &odd[..], &odd[..4], &odd[3..4], &[]] {
            let finite = || values.iter().copied().filter(|v| v.is_finite());
            let plain = [finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max)];
            assert_eq!(extremes(values), plain);
        }
    }
}
