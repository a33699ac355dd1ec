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

/// Ticks of a part. Floats of at least 2^-13, which the first step is above, lie on them.
const TICKS: f32 = 16_777_216.0;

/// Where the codes change.
#[derive(Debug)]
pub(super) struct Codes {
    /// The code at the start of each part and, 8 bits above it, the last tick before the next code.
    parts: [u32; PARTS],
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
        let mut steps = steps().map(|step| step * PARTS as f32).into_iter().peekable();
        let mut code = 0;
        let parts = std::array::from_fn(|part| {
            let start = part as f32;
            let step = steps.next_if(|step| *step < start + 1.0);
            let last = step.map_or(TICKS, |step| (step - start) * TICKS) - 1.0;
            let entry = code | (last as u32) << 8;
            code += u32::from(step.is_some());
            entry
        });
        let linear = std::array::from_fn(|k| color::srgb_to_linear(k as f32 * (1.0 / 255.0)));
        Self { parts, linear }
    }

    /// The linear value of a code.
    #[inline(always)]
    pub(super) fn linear(&self, code: u16) -> f32 {
        self.linear[usize::from(code) % CODES]
    }
}

/// The least linear value of each code from 1 on.
fn steps() -> [f32; CODES - 1] {
    std::array::from_fn(|k| least(k as u32 + 1))
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
    let (mut tick, mut part, mut entry) = ([0.0; LANES], [0; LANES], [0; LANES]);
    for l in 0..LANES {
        // 1 lies in the last part. What follows is exact: a product with a power of two, and the fraction of a float.
        let at = linear[l].max(0.0).min(1.0 - f32::EPSILON / 2.0) * PARTS as f32;
        part[l] = num::whole(at);
        tick[l] = (at - part[l] as i32 as f32) * TICKS;
    }
    for l in 0..LANES {
        entry[l] = table.parts[part[l] as usize % PARTS];
    }
    let mut codes = [0; LANES];
    for l in 0..LANES {
        let last = (entry[l] >> 8) as i32 as f32;
        codes[l] = ((entry[l] & 0xff) + u32::from(tick[l] > last)) as u16;
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
        for step in steps() {
            let first = step.to_bits() - (1 << 12);
            assert_codes(&(first..first + (1 << 13)).map(f32::from_bits).collect::<Vec<_>>());
        }
        assert_codes(&(0..=1f32.to_bits()).step_by(1 << 9).map(f32::from_bits).collect::<Vec<_>>());
        assert_codes(&[-0.0, -1.0, 1.0, 1.0f32.next_down(), 1.0f32.next_up(), 1e30, f32::NAN, f32::INFINITY]);
        assert_codes(&[f32::NEG_INFINITY, f32::MIN_POSITIVE, 1e-45]);
    }

    #[test]
    fn no_part_holds_two_steps() {
        let parts = steps().map(|v| num::whole(v * PARTS as f32));
        assert!(parts.windows(2).all(|w| w[0] < w[1]));
        // No step at the start of a part, and ticks fine enough for all floats around each.
        assert!(steps().iter().all(|v| *v > 2f32.powi(-13) && (v * PARTS as f32).fract() > 0.0));
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
