//! The random numbers of the jitter nodes.

use crate::base::{hash, num};

/// Three numbers in [-1, 1) from one `random` in [0, 1], which is the same all over a scale.
///
/// * `independent` - three hashes of `random`; else `2 random - 1` three times.
#[inline(always)]
pub(super) fn draws(random: f32, seed: u32, independent: bool) -> [f32; 3] {
    let r = num::saturate(random);
    // 24 bits hold every value that a hash gives: 12 and 12, because `whole` goes to 2^23.
    let high = num::whole(r * 4096.0);
    let low = num::whole((r * 4096.0 - high as f32) * 4096.0);
    let bits = (high << 12) + low;
    let together = 2.0 * r - 1.0;
    let own = |channel| hash::signed(hash::hash2(seed, bits, channel));
    let pick = |channel| if independent { own(channel) } else { together };
    [pick(0), pick(1), pick(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn independent_draws_are_uncorrelated_and_unbiased() {
        let n = 4000;
        let all: Vec<_> = (0..n).map(|i| draws(hash::unit(hash::pcg(i)), 7, true)).collect();
        for a in 0..3 {
            let mean: f32 = all.iter().map(|d| d[a]).sum::<f32>() / n as f32;
            // Standard error 0.009.
            assert!(mean.abs() < 0.04, "{a}: {mean}");
            for b in 0..a {
                let product: f32 = all.iter().map(|d| d[a] * d[b]).sum::<f32>() / n as f32;
                assert!(product.abs() < 0.03, "{a} {b}: {product}");
            }
        }
    }

    #[test]
    fn the_random_is_hashed_by_its_24_bits() {
        let odd = [0.0, 1e-45, 5e-8, 1.0, 1.0f32.next_down(), 0.5f32.next_down(), 0.3];
        for r in (0..4000).map(|i| hash::unit(hash::pcg(i))).chain(odd) {
            let bits = (r * 16_777_216.0) as u32;
            let own = [0, 1, 2].map(|channel| hash::signed(hash::hash2(7, bits, channel)));
            assert_eq!(draws(r, 7, true), own, "{r}");
        }
    }

    #[test]
    fn together_is_the_random_itself() {
        assert_eq!(draws(0.75, 7, false), [0.5; 3]);
        assert_eq!(draws(1e30, 7, false), [1.0; 3]);
    }
}
