use super::*;
use crate::base::hash;
use crate::base::simd::{self, Level};
use proptest::prelude::*;

/// What another decoder makes of compressed bytes.
fn inflate(blocks: &[u8], length: usize) -> Vec<u8> {
    let stream: Vec<u8> = blocks.iter().copied().chain([0x03, 0x00]).collect();
    let mut bytes = vec![0; length + 1];
    let mut inflate = zlib_rs::Inflate::new(false, 15);
    let status = inflate.decompress(&stream, &mut bytes, zlib_rs::InflateFlush::Finish);
    assert_eq!(status, Ok(zlib_rs::Status::StreamEnd));
    assert_eq!((inflate.total_in(), inflate.total_out()), (stream.len() as u64, length as u64));
    bytes.truncate(length);
    bytes
}

fn check(bytes: &[u8]) -> usize {
    // Room that was used before: nothing of it is left.
    let mut out = vec![7; 90];
    let length = compress(bytes, &mut out);
    assert!(inflate(&out[..length], bytes.len()) == bytes);
    length
}

#[test]
fn lengths_of_repeats_are_those_of_the_standard() {
    // First length and extra bits of each symbol, from the table of RFC 1951, 3.2.5.
    let table = [
        (3, 0),
        (4, 0),
        (5, 0),
        (6, 0),
        (7, 0),
        (8, 0),
        (9, 0),
        (10, 0),
        (11, 1),
        (13, 1),
        (15, 1),
        (17, 1),
        (19, 2),
        (23, 2),
        (27, 2),
        (31, 2),
        (35, 3),
        (43, 3),
        (51, 3),
        (59, 3),
        (67, 4),
        (83, 4),
        (99, 4),
        (115, 4),
        (131, 5),
        (163, 5),
        (195, 5),
        (227, 5),
        (258, 0),
    ];
    for length in 3..=MAX_REPEAT {
        let i = table.iter().rposition(|&(first, _)| first <= length).unwrap();
        let (first, extra) = table[i];
        assert_eq!(length_symbol(length), (257 + i, (length - first) as u32, extra), "{length}");
    }
}

#[test]
fn runs_of_every_length_come_back() {
    for zeros in (0..600).chain([4095, 65_536, 200_000]) {
        let mut bytes = vec![5; zeros % 9];
        bytes.resize(bytes.len() + zeros, 0);
        bytes.extend([1, 2]);
        check(&bytes);
    }
}

#[test]
fn few_symbols_many_symbols_and_very_unequal_ones_come_back() {
    assert_eq!(check(&[]), 0);
    for byte in [0, 1, 255] {
        check(&[byte]);
        check(&[byte; 100]);
    }
    let all: Vec<u8> = (0..100_000).map(|i| (i % 256) as u8).collect();
    // Nothing to gain: stored, with the heads of four blocks.
    assert!(check(&all) <= all.len() + 4 * 5);
    // Counts like Fibonacci's numbers make the deepest trees: the limit is reached and repaired.
    let (mut a, mut b) = (1usize, 1usize);
    let mut steep = Vec::new();
    for symbol in 1..24 {
        steep.extend(std::iter::repeat_n(symbol, a));
        (a, b) = (b, a + b);
    }
    check(&steep[steep.len() - 32_768..]);
    check(&steep);
}

#[test]
fn every_simd_level_writes_the_same_bytes() {
    // Small numbers and rare great ones, zeros alone and in runs, and an odd end: codes of 1 to 12 bits.
    let byte = |i: u32| match hash::hash2(5, i / 40, 0) % 5 {
        0 => 0,
        _ => (hash::hash2(6, i, 0).leading_zeros() as u8).wrapping_mul(1 + (i % 7) as u8),
    };
    let bytes: Vec<u8> = (0..150_003).map(byte).collect();
    let at = |level| {
        simd::force(level);
        let mut out = Vec::new();
        let length = compress(&bytes, &mut out);
        out.truncate(length);
        out
    };
    let plain = at(Level::Baseline);
    assert!(inflate(&plain, bytes.len()) == bytes);
    for level in Level::ALL {
        assert!(at(level) == plain, "{level:?}");
    }
    simd::force(Level::Avx512);
}

#[test]
fn codes_are_as_short_as_entropy_allows_but_for_half_a_bit() {
    // Two-sided geometric numbers, as filters leave them.
    let bytes: Vec<u8> = (0..32_768u32)
        .map(|i| {
            let h = hash::hash2(3, i, 0);
            let size = (h & 0xffff_fff0).leading_zeros() as u8;
            if h & 1 == 0 { size } else { size.wrapping_neg() }
        })
        .collect();
    let mut counts = [0f64; 256];
    bytes.iter().for_each(|&b| counts[usize::from(b)] += 1.0);
    let n = bytes.len() as f64;
    let entropy: f64 = counts.iter().filter(|c| **c > 0.0).map(|c| -c * (c / n).log2()).sum();
    let bits = 8.0 * check(&bytes) as f64;
    assert!(bits > entropy && bits < entropy + 0.5 * n, "{bits} {entropy}");
}

proptest! {
    #[test]
    fn lengths_are_a_whole_prefix_code_within_the_limit(
        counts in proptest::collection::vec(prop_oneof![Just(0u32), 1u32..4, 1u32..1 << 30], 2..286),
    ) {
        let mut lengths = vec![0; counts.len()];
        code_lengths(&counts, MAX_BITS, &mut lengths);
        let used = counts.iter().filter(|n| **n > 0).count();
        for (n, length) in counts.iter().zip(&lengths) {
            prop_assert_eq!(*n > 0, *length > 0);
            prop_assert!(usize::from(*length) <= MAX_BITS);
        }
        let sum: usize = lengths.iter().filter(|l| **l > 0).map(|&l| 1 << (MAX_BITS - usize::from(l))).sum();
        prop_assert!(used < 2 || sum == 1 << MAX_BITS, "{sum}");
    }

    #[test]
    fn any_bytes_come_back(
        parts in proptest::collection::vec((any::<u8>(), 0usize..400, 0u8..4), 0..300),
    ) {
        let bytes: Vec<u8> = parts
            .into_iter()
            .flat_map(|(byte, n, spread)| {
                (0..n).map(move |i| if spread == 0 { 0 } else { byte.wrapping_add(i as u8 % spread) })
            })
            .collect();
        check(&bytes);
    }
}
