//! Counter-based integer hashing: the only source of randomness.
//!
//! A random number is a pure function of (seed, lattice coordinates, channel), so it does not depend on
//! evaluation order, threads or platform. The mixer is PCG's output permutation on 32 bits, chained over the
//! coordinates (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020: `pcg`, nested use).

/// PCG-RXS-M-XS on 32 bits after one LCG step.
#[inline(always)]
pub const fn pcg(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Hash of a pair of lattice coordinates under `seed`.
#[inline(always)]
pub const fn hash2(seed: u32, x: u32, y: u32) -> u32 {
    pcg(pcg(seed ^ x).wrapping_add(y))
}

/// Hash of one counter under `seed`.
#[inline(always)]
pub const fn hash1(seed: u32, x: u32) -> u32 {
    pcg(pcg(seed).wrapping_add(x))
}

/// A uniform f32 in [0, 1): the top 24 bits, so every value is exact.
#[inline(always)]
pub const fn unit(h: u32) -> f32 {
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A uniform f32 in [-1, 1).
#[inline(always)]
pub const fn signed(h: u32) -> f32 {
    2.0 * unit(h) - 1.0
}

/// The seed of a node: a hash of the set's seed and the node's name, so that adding, removing or
/// reordering other nodes changes nothing.
pub fn node_seed(seed: u64, name: &str) -> u32 {
    let mut h = pcg(seed as u32) ^ pcg((seed >> 32) as u32 ^ 0x9e37_79b9);
    for byte in name.bytes() {
        h = pcg(h ^ u32::from(byte));
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pcg_is_a_permutation_on_a_sample_and_has_no_bias() {
        let mut seen: Vec<u32> = (0..1 << 16).map(pcg).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 1 << 16);
        let mean: f64 = (0..1 << 16).map(|i| f64::from(unit(pcg(i)))).sum::<f64>() / 65536.0;
        // Standard error of the mean of 65536 uniforms is 0.0011.
        assert!((mean - 0.5).abs() < 0.005, "{mean}");
    }

    #[test]
    fn node_seeds_depend_on_name_and_seed() {
        assert_ne!(node_seed(1, "a"), node_seed(1, "b"));
        assert_ne!(node_seed(1, "a"), node_seed(2, "a"));
        assert_ne!(node_seed(1, "a"), node_seed(1 << 32 | 1, "a"));
    }
}
