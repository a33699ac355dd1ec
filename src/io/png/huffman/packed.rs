//! Codes of eight literals at once, where the machine has AVX-512 VBMI: the table of codes fits into eight registers.
//!
//! Codes are joined in lanes of 16, 32 and 64 bits instead of one after another. Measured reason for what is `unsafe` here:
//! Huffman codes of five maps at 2048x2048 take 33 ms with it and 52 ms without (one thread, Zen 4).

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

#[cfg(target_arch = "x86_64")]
use crate::base::simd::{self, Level};

/// Bits that are written at once at most.
const MOST_BITS: u64 = 56;

/// The codes of each eight bytes of a block, joined.
#[derive(Default)]
pub(super) struct Packed {
    bits: Vec<u64>,
    counts: Vec<u64>,
}

impl Packed {
    /// Join the codes of a block, where this machine can. Each of `literals` is a code of at most 12 bits and, 16 bits above
    /// it, how many those are.
    pub(super) fn set(&mut self, block: &[u8], literals: &[u32; 256]) {
        self.bits.clear();
        self.counts.clear();
        #[cfg(target_arch = "x86_64")]
        if simd::level() == Level::Avx512 && is_x86_feature_detected!("avx512vbmi") {
            // SAFETY: `level()` is Avx512 only where `detected()` found all of those, and VBMI has just been found.
            #[allow(unsafe_code, reason = "see the module's note: measured 1.6x")]
            unsafe {
                join(block, literals, self);
            }
        }
    }

    /// The codes of the eight bytes from `8 i` on, and how many bits they are, if they were joined and can be written at once.
    #[inline(always)]
    pub(super) fn word(&self, i: usize) -> Option<(u64, u32)> {
        let (bits, count) = (*self.bits.get(i)?, *self.counts.get(i)?);
        (count <= MOST_BITS).then_some((bits, count as u32))
    }
}

/// Bytes as a vector, lowest first.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn vector(bytes: [u8; 64]) -> __m512i {
    // SAFETY: both are 64 bytes, and any bits are a value of either.
    #[allow(unsafe_code, reason = "the standard library has no safe load")]
    unsafe {
        std::mem::transmute(bytes)
    }
}

/// A vector's lanes.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn lanes(vector: __m512i) -> [u64; 8] {
    // SAFETY: both are 64 bytes, and any bits are a value of either.
    #[allow(unsafe_code, reason = "the standard library has no safe store")]
    unsafe {
        std::mem::transmute(vector)
    }
}

/// An entry of a table of 256 bytes for each byte of `at`.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
#[inline]
fn look_up(table: &[__m512i; 4], at: __m512i) -> __m512i {
    let low = _mm512_permutex2var_epi8(table[0], at, table[1]);
    let high = _mm512_permutex2var_epi8(table[2], at, table[3]);
    _mm512_mask_blend_epi8(_mm512_movepi8_mask(at), low, high)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx512vbmi")]
fn join(block: &[u8], literals: &[u32; 256], out: &mut Packed) {
    // The lowest 8 bits of a code; the other four, and above them how many bits there are.
    let table = |byte: &dyn Fn(u32) -> u32| -> [__m512i; 4] {
        std::array::from_fn(|k| vector(std::array::from_fn(|i| byte(literals[64 * k + i]) as u8)))
    };
    let low_of = table(&|code| code & 0xff);
    let rest_of = table(&|code| code >> 8 & 15 | code >> 16 << 4);
    for bytes in block.as_chunks::<64>().0 {
        let at = vector(*bytes);
        // Most zeros are told as runs.
        if _mm512_test_epi64_mask(at, at) == 0 {
            out.bits.extend([0; 8]);
            out.counts.extend([u64::MAX; 8]);
            continue;
        }
        let (low, rest) = (look_up(&low_of, at), look_up(&rest_of, at));
        let nibble = _mm512_set1_epi8(15);
        let high = _mm512_and_si512(rest, nibble);
        let count = _mm512_and_si512(_mm512_srli_epi16::<4>(rest), nibble);
        // Two codes, the second above the first: 16 bits of them, and what lies above.
        let byte = _mm512_set1_epi16(0xff);
        let first = _mm512_or_si512(_mm512_and_si512(low, byte), _mm512_slli_epi16::<8>(high));
        let second = _mm512_or_si512(_mm512_srli_epi16::<8>(low), _mm512_andnot_si512(byte, high));
        let by = _mm512_and_si512(count, byte);
        let low = _mm512_or_si512(first, _mm512_sllv_epi16(second, by));
        let high = _mm512_srlv_epi16(second, _mm512_sub_epi16(_mm512_set1_epi16(16), by));
        let count = _mm512_maddubs_epi16(count, _mm512_set1_epi8(1));
        // Four: 32 bits, and what lies above.
        let word = _mm512_set1_epi32(0xffff);
        let first = _mm512_or_si512(_mm512_and_si512(low, word), _mm512_slli_epi32::<16>(high));
        let second = _mm512_or_si512(_mm512_srli_epi32::<16>(low), _mm512_andnot_si512(word, high));
        let by = _mm512_and_si512(count, word);
        let low = _mm512_or_si512(first, _mm512_sllv_epi32(second, by));
        let high = _mm512_srlv_epi32(second, _mm512_sub_epi32(_mm512_set1_epi32(32), by));
        let count = _mm512_madd_epi16(count, _mm512_set1_epi16(1));
        // Eight.
        let half = _mm512_set1_epi64(0xffff_ffff);
        let first = _mm512_or_si512(_mm512_and_si512(low, half), _mm512_slli_epi64::<32>(high));
        let second = _mm512_or_si512(_mm512_srli_epi64::<32>(low), _mm512_andnot_si512(half, high));
        let by = _mm512_and_si512(count, half);
        out.bits.extend(lanes(_mm512_or_si512(first, _mm512_sllv_epi64(second, by))));
        out.counts.extend(lanes(_mm512_add_epi64(by, _mm512_srli_epi64::<32>(count))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::hash;

    #[test]
    fn codes_are_joined_as_one_after_another() {
        // Any bits of 0 to 12, as many words of more than 56 bits as of fewer.
        let literals: [u32; 256] = std::array::from_fn(|s| {
            let count = hash::hash2(1, s as u32, 0) % 13;
            (hash::hash2(2, s as u32, 0) & ((1 << count) - 1)) | count << 16
        });
        let block: Vec<u8> =
            (0..5000).map(|i| if i % 192 < 64 { 0 } else { hash::hash2(3, i, 0) as u8 }).collect();
        let mut packed = Packed::default();
        packed.set(&block, &literals);
        if packed.bits.is_empty() {
            println!("SKIPPED: this machine has no AVX-512 VBMI");
            return;
        }
        let (mut joined, mut long) = (0, 0);
        for (i, word) in block.as_chunks::<8>().0.iter().enumerate() {
            let (mut bits, mut count) = (0u128, 0);
            for &byte in word {
                let code = literals[usize::from(byte)];
                bits |= u128::from(code & 0xffff) << count;
                count += code >> 16;
            }
            match packed.word(i) {
                Some(found) => {
                    assert_eq!(found, (bits as u64, count), "word {i}");
                    joined += 1;
                }
                // Whole groups of zeros, what is too long, and what is left of the block.
                None => assert!(count > 56 || i % 24 < 8 || i >= 5000 / 64 * 8, "word {i}"),
            }
            long += u32::from(count > 56);
        }
        assert!(joined > 100 && long > 100, "{joined} {long}");
        // What was there is forgotten.
        packed.set(&block[..70], &literals);
        assert!(packed.word(8).is_none());
    }
}
