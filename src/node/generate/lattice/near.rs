//! Looking up what lies near each other: with AVX-512, sixteen texels' cells come out of two registers.
//!
//! Measured reason for what is `unsafe` here: gathering them one by one takes 29 cycles for sixteen on Zen 4, which was 3 % of all
//! built-in presets' CPU time.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

#[cfg(target_arch = "x86_64")]
use crate::base::simd::{self, Level};

/// Cells behind the last one that [`look_up`] may read: the first ones again.
pub(super) const AGAIN: usize = 32;

/// The lowest 8 bits of each column's cell. `cells` holds `count` values and, behind them, [`AGAIN`] as on a ring; neighbours' columns are
/// usually fewer than that apart.
pub(super) fn look_up(cells: &[u32], count: u32, columns: &[u16], out: &mut [u8]) {
    #[cfg(target_arch = "x86_64")]
    if simd::level() == Level::Avx512 {
        // SAFETY: `level()` is Avx512 only where `detected()` found it.
        #[allow(unsafe_code, reason = "see the module's note")]
        return unsafe { near(cells, count, columns, out) };
    }
    each(cells, columns, out);
}

fn each(cells: &[u32], columns: &[u16], out: &mut [u8]) {
    for (o, &column) in out.iter_mut().zip(columns) {
        *o = cells.get(usize::from(column)).map_or(0, |&bits| bits as u8);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn near(cells: &[u32], count: u32, columns: &[u16], out: &mut [u8]) {
    let (columns, columns_rest) = columns.as_chunks::<16>();
    let (outs, out_rest) = out.as_chunks_mut::<16>();
    let (count, room) = (_mm512_set1_epi32(count as i32), _mm512_set1_epi32(AGAIN as i32));
    for (out, columns) in outs.iter_mut().zip(columns) {
        let first = columns[0];
        // SAFETY: sixteen numbers of 16 bits are what is loaded.
        #[allow(unsafe_code, reason = "the standard library has no safe load")]
        let all = unsafe { _mm256_loadu_si256(columns.as_ptr().cast()) };
        // How far each is from the first one, around the ring.
        let from = _mm512_sub_epi32(_mm512_cvtepu16_epi32(all), _mm512_set1_epi32(first.into()));
        let before = _mm512_movepi32_mask(from);
        let from = _mm512_mask_add_epi32(from, before, from, count);
        let far = _mm512_cmpge_epu32_mask(from, room);
        match cells.get(usize::from(first)..).and_then(|cells| cells.first_chunk::<AGAIN>()) {
            Some(held) if far == 0 => {
                // SAFETY: 32 numbers of 32 bits are what is loaded, 16 of 8 bits are what is stored.
                #[allow(unsafe_code, reason = "the standard library has neither as safe functions")]
                unsafe {
                    let [low, high] = [0, 16].map(|i| _mm512_loadu_si512(held[i..].as_ptr().cast()));
                    let bits = _mm512_permutex2var_epi32(low, from, high);
                    _mm_storeu_si128(out.as_mut_ptr().cast(), _mm512_cvtepi32_epi8(bits));
                }
            }
            _ => each(cells, columns, out),
        }
    }
    each(cells, columns_rest, out_rest);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::hash;

    #[test]
    fn near_and_far_columns_find_their_cells() {
        for count in [1u32, 2, 5, 16, 31, 33, 500] {
            let mut cells: Vec<u32> = (0..count).map(|i| hash::hash2(1, i, 0)).collect();
            cells.extend((0..AGAIN).map(|i| cells[i % count as usize]).collect::<Vec<_>>());
            for stride in [0.0f32, 0.1, 0.9, 1.7, 2.3, 40.0, -0.4] {
                let columns: Vec<u16> = (0..333)
                    .map(|x| (x as f32 * stride + 3.0).rem_euclid(count as f32) as u16 % count as u16)
                    .collect();
                let mut found = vec![0; columns.len()];
                look_up(&cells, count, &columns, &mut found);
                let expected: Vec<u8> = columns.iter().map(|&c| cells[c as usize] as u8).collect();
                assert_eq!(found, expected, "{count} {stride}");
            }
        }
    }
}
