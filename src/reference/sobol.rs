//! Owen-scrambled Sobol points in four dimensions (Burley 2020, Practical Hash-based Owen Scrambling, JCGT 9(4)).
//!
//! The same points as the crate `sobol_burley` gives, bit by bit (a test holds it), from a table in place of a loop over
//! bits, and as plain loops over lanes, which are compiled for the caller's instruction set: about twice as fast.

/// Dimensions.
const LANES: usize = 4;
/// Bits of an index.
const BITS: usize = 16;

/// What eight bits of an index add to a point, by the bits in reverse: those of the low byte, then those of the high one.
static BYTES: [[[u32; LANES]; 256]; BITS / 8] = {
    let directions = directions();
    let mut bytes = [[[0; LANES]; 256]; BITS / 8];
    let mut i = 0;
    while i < 256 * BITS {
        let (byte, reversed, bit) = (i / (256 * 8), i / 8 % 256, i % 8);
        if (reversed >> (7 - bit)) & 1 == 1 {
            let mut lane = 0;
            while lane < LANES {
                bytes[byte][reversed][lane] ^= directions[byte * 8 + bit][lane];
                lane += 1;
            }
        }
        i += 1;
    }
    bytes
};

/// What each bit of an index adds to a point, the half in the lowest bit: van der Corput's sequence, then those of the first
/// primitive polynomials with the initial numbers of Joe & Kuo (2008, new-joe-kuo-6).
const fn directions() -> [[u32; LANES]; BITS] {
    // Degree, inner coefficients, initial numbers.
    let polynomials: [(usize, u32, [u32; 3]); LANES - 1] =
        [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
    let mut directions = [[0; LANES]; BITS];
    let mut lane = 0;
    while lane < LANES {
        // As published: the half in the highest bit.
        let mut v = [0u32; BITS];
        let mut i = 0;
        while i < BITS {
            v[i] = if lane == 0 {
                1 << (31 - i)
            } else {
                let (degree, inner, initial) = polynomials[lane - 1];
                if i < degree {
                    initial[i] << (31 - i)
                } else {
                    let mut sum = v[i - degree] ^ (v[i - degree] >> degree);
                    let mut k = 1;
                    while k < degree {
                        if (inner >> (degree - 1 - k)) & 1 == 1 {
                            sum ^= v[i - k];
                        }
                        k += 1;
                    }
                    sum
                }
            };
            directions[i][lane] = v[i].reverse_bits();
            i += 1;
        }
        lane += 1;
    }
    directions
}

/// For each of N: point `index` (below 2^16) of the sequence that its seed shuffles and scrambles, in [0, 1).
#[inline(always)]
pub(super) fn fours<const N: usize>(indices: &[u32; N], seeds: &[u32; N]) -> [[f32; LANES]; N] {
    let mut digits = [[0; LANES]; N];
    let mut keys = [[0; LANES]; N];
    let mut shuffled = [0; N];
    for i in 0..N {
        shuffled[i] = scramble(indices[i].reverse_bits(), mix(seeds[i] ^ 0x79c6_8e4a));
    }
    for i in 0..N {
        let (low, high) =
            (&BYTES[0][(shuffled[i] >> 24) as usize], &BYTES[1][(shuffled[i] >> 16 & 0xff) as usize]);
        for lane in 0..LANES {
            digits[i][lane] = low[lane] ^ high[lane];
            keys[i][lane] = seeds[i].wrapping_mul(0x9c8f_2d3b) ^ KEYS[lane];
        }
    }
    let mut points = [[0.0; LANES]; N];
    let (digits, keys) = (digits.as_flattened(), keys.as_flattened());
    for (i, point) in points.as_flattened_mut().iter_mut().enumerate() {
        let scrambled = scramble(digits[i], mix(keys[i])).reverse_bits();
        // 23 bits are a number in [1, 2).
        *point = f32::from_bits((scrambled >> 9) | 0x3f80_0000) - 1.0;
    }
    points
}

/// What makes the scrambling of each dimension another.
const KEYS: [u32; LANES] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];

/// Scrambles digits, the first in the lowest bit, each by those before it (Vegdahl 2021, Building a Better LK Hash).
#[inline(always)]
fn scramble(digits: u32, seed: u32) -> u32 {
    let mut d = digits;
    d ^= d.wrapping_mul(0x3d20_adea);
    d = d.wrapping_add(seed);
    d = d.wrapping_mul((seed >> 16) | 1);
    d ^= d.wrapping_mul(0x0552_6c56);
    d ^ d.wrapping_mul(0x53a2_2864)
}

/// Mixes the bits of a seed (Wellons, hash-prospector).
#[inline(always)]
fn mix(seed: u32) -> u32 {
    let s = seed ^ 0xe6fe_3beb;
    let s = (s ^ (s >> 16)).wrapping_mul(0x7feb_352d);
    let s = (s ^ (s >> 15)).wrapping_mul(0x846c_a68b);
    s ^ (s >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_are_those_of_the_crate() {
        for seed in [0, 1, 77, 0xdead_beef] {
            for index in (0..1 << 16).step_by(7).chain([1, 2, 3, 0xffff]) {
                let other = index ^ 5;
                assert_eq!(
                    fours(&[index, other], &[seed, seed]),
                    [index, other].map(|i| sobol_burley::sample_4d(i, 0, seed)),
                    "{index} {seed}"
                );
            }
        }
        assert_ne!(fours(&[5], &[1])[0], sobol_burley::sample_4d(5, 0, 2));
    }
}
