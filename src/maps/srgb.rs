//! sRGB codes of 8 bits by look-up.
//!
//! The transfer function takes a power for each sample, and so does the error of its code. But 8 bits have 255 steps:
//! where they lie is found once, from the very function, so that the codes are the same to the last one.

use std::sync::LazyLock;

use crate::base::{color, num};
use crate::multiversion;

/// Parts of [0, 1], so narrow that none holds two steps: the steps of the darkest codes are 3.0e-4 apart.
const PARTS: usize = 4096;
/// Codes.
const CODES: usize = 256;

/// Where the codes change.
#[derive(Debug)]
pub(super) struct Codes {
    /// The code at the start of each part.
    start: [u32; PARTS],
    /// The least linear value of the next code, by code; infinite for the last one.
    next: [f32; CODES],
    /// Linear value of each code.
    linear: [f32; CODES],
}

/// The code of a linear value in [0, 1]: the nearest to its encoded value.
#[inline(always)]
fn code(linear: f32) -> u32 {
    num::whole(num::saturate(color::linear_to_srgb(linear)) * 255.0 + 0.5)
}

impl Codes {
    /// The table, made once.
    pub(super) fn get() -> &'static Self {
        static CODES: LazyLock<Box<Codes>> = LazyLock::new(|| Box::new(Codes::new()));
        &CODES
    }

    fn new() -> Self {
        let next = std::array::from_fn(|k| if k + 1 < CODES { least(k as u32 + 1) } else { f32::INFINITY });
        let start = std::array::from_fn(|part| code(part as f32 / PARTS as f32));
        let linear = std::array::from_fn(|k| color::srgb_to_linear(k as f32 * (1.0 / 255.0)));
        Self { start, next, linear }
    }

    /// The linear value of a code.
    #[inline(always)]
    pub(super) fn linear(&self, code: u16) -> f32 {
        self.linear[usize::from(code) % CODES]
    }
}

/// The least linear value of a code from 1 to 255, among all floats: codes never fall where values rise.
fn least(k: u32) -> f32 {
    let (mut below, mut at) = (0u32, 1f32.to_bits());
    while at - below > 1 {
        let middle = below + (at - below) / 2;
        if code(f32::from_bits(middle)) >= k {
            at = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(at)
}

/// Samples worked on at once: between look-ups, which go one by one, they are numbers of one vector.
const LANES: usize = 16;

#[inline(always)]
fn block(table: &Codes, linear: &[f32; LANES]) -> [u16; LANES] {
    let (mut v, mut part, mut start) = ([0.0; LANES], [0; LANES], [0; LANES]);
    for l in 0..LANES {
        // 1 lies in the last part.
        v[l] = linear[l].max(0.0).min(1.0 - f32::EPSILON / 2.0);
        part[l] = num::whole(v[l] * PARTS as f32);
    }
    for l in 0..LANES {
        start[l] = table.start[part[l] as usize % PARTS];
    }
    let mut codes = [0; LANES];
    for l in 0..LANES {
        codes[l] = (start[l] + u32::from(v[l] >= table.next[start[l] as usize % CODES])) as u16;
    }
    codes
}

multiversion! {
    /// Codes of linear values, which are limited to [0, 1]; NaN gives 0.
    pub(super) fn codes(table: &Codes, row: &[f32], out: &mut [u16]) {
        let (rows, rest) = row.as_chunks::<LANES>();
        let (outs, out_rest) = out.as_chunks_mut::<LANES>();
        for (o, v) in outs.iter_mut().zip(rows) {
            *o = block(table, v);
        }
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        out_rest.copy_from_slice(&block(table, &last)[..rest.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_codes(values: &[f32]) {
        let mut found = vec![0; values.len()];
        codes(Codes::get(), values, &mut found);
        for (v, found) in values.iter().zip(found) {
            assert_eq!(u32::from(found), code(num::saturate(*v)), "{v:e}");
        }
    }

    #[test]
    fn codes_are_those_of_the_function_around_every_step_and_between() {
        // Every float of 2^13 around each step, every 2^9-th of all, and what lies outside. An exhaustive run (all 2^30
        // floats of [0, 1], once) found no fall and no difference.
        for &step in &Codes::get().next[..CODES - 1] {
            let first = step.to_bits() - (1 << 12);
            assert_codes(&(first..first + (1 << 13)).map(f32::from_bits).collect::<Vec<_>>());
        }
        assert_codes(&(0..=1f32.to_bits()).step_by(1 << 9).map(f32::from_bits).collect::<Vec<_>>());
        assert_codes(&[-0.0, -1.0, 1.0, 1.0f32.next_down(), 1.0f32.next_up(), 1e30, f32::NAN, f32::INFINITY]);
        assert_codes(&[f32::NEG_INFINITY, f32::MIN_POSITIVE, 1e-45]);
    }

    #[test]
    fn no_part_holds_two_steps() {
        let parts: Vec<u32> =
            Codes::get().next[..CODES - 1].iter().map(|v| num::whole(v * PARTS as f32)).collect();
        assert!(parts.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn a_code_decodes_to_its_linear_value() {
        let all: Vec<u16> = (0..256).collect();
        let linear: Vec<f32> = all.iter().map(|&code| Codes::get().linear(code)).collect();
        for (&code, v) in all.iter().zip(&linear) {
            assert_eq!(*v, color::srgb_to_linear(f32::from(code) * (1.0 / 255.0)));
        }
        let mut back = vec![0; 256];
        codes(Codes::get(), &linear, &mut back);
        assert_eq!(back, all);
    }
}
