//! The filters of PNG rows: each byte less what its neighbours predict (PNG 3rd edition, section 9).

use crate::multiversion;

/// How a byte is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// By the texel to the left.
    Sub = 1,
    /// By the texel above.
    Up = 2,
    /// By the one of left, above and above left that is nearest to left + above - above left.
    Paeth = 4,
}

/// Rows of `row_bytes`, `texel_bytes` a texel, filtered, each behind the byte that names its filter: they become `out`.
///
/// The first row is filtered by [`Filter::Sub`]: nothing outside of these rows is read, so that strips of an image can be
/// filtered apart.
pub(super) fn rows(samples: &[u8], row_bytes: usize, texel_bytes: usize, filter: Filter, out: &mut Vec<u8>) {
    // All of it is written below: what was there need not be cleared.
    out.resize(samples.len() / row_bytes * (1 + row_bytes), 0);
    let mut above = None;
    for (row, out) in samples.chunks_exact(row_bytes).zip(out.chunks_exact_mut(1 + row_bytes)) {
        let filter = if above.is_some() { filter } else { Filter::Sub };
        out[0] = filter as u8;
        let (head, tail) = out[1..].split_at_mut(texel_bytes);
        let above = above.replace(row).unwrap_or(row);
        let (left, here) = (&row[..row_bytes - texel_bytes], &row[texel_bytes..]);
        match filter {
            Filter::Sub => {
                head.copy_from_slice(&row[..texel_bytes]);
                less(here, left, tail);
            }
            Filter::Up => {
                less(row, above, &mut out[1..]);
            }
            Filter::Paeth => {
                // Left of the first texel is zero, and so is what is above that: the prediction is what is above.
                less(&row[..texel_bytes], &above[..texel_bytes], head);
                paeth(here, left, &above[texel_bytes..], &above[..row_bytes - texel_bytes], tail);
            }
        }
    }
}

multiversion! {
    fn less(row: &[u8], predicted: &[u8], out: &mut [u8]) {
        for (o, (v, p)) in out.iter_mut().zip(row.iter().zip(predicted)) {
            *o = v.wrapping_sub(*p);
        }
    }
}

multiversion! {
    fn paeth(row: &[u8], left: &[u8], above: &[u8], above_left: &[u8], out: &mut [u8]) {
        let n = out.len();
        let (row, left, above, above_left) = (&row[..n], &left[..n], &above[..n], &above_left[..n]);
        for i in 0..n {
            let (a, b, c) = (i16::from(left[i]), i16::from(above[i]), i16::from(above_left[i]));
            // Distances of left + above - above left to each of the three.
            let (to_a, to_b) = ((b - c).abs(), (a - c).abs());
            let to_c = (a + b - 2 * c).abs();
            let b_or_c = if to_b <= to_c { b } else { c };
            let nearest = if to_a <= to_b && to_a <= to_c { a } else { b_or_c };
            out[i] = row[i].wrapping_sub(nearest as u8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::hash;

    /// Undo filters as a decoder does, byte by byte, from the standard's text.
    fn undo(filtered: &[u8], row_bytes: usize, texel_bytes: usize) -> Vec<u8> {
        let mut rows: Vec<u8> = Vec::new();
        for (y, filtered) in filtered.chunks(1 + row_bytes).enumerate() {
            for i in 0..row_bytes {
                let at = y * row_bytes + i;
                let left = if i >= texel_bytes { i32::from(rows[at - texel_bytes]) } else { 0 };
                let above = if y > 0 { i32::from(rows[at - row_bytes]) } else { 0 };
                let corner = match (y, i >= texel_bytes) {
                    (1.., true) => i32::from(rows[at - row_bytes - texel_bytes]),
                    _ => 0,
                };
                let estimate = left + above - corner;
                let distances = [left, above, corner].map(|v| (estimate - v).abs());
                let least = distances.into_iter().min();
                let predicted = match filtered[0] {
                    1 => left,
                    2 => above,
                    4 if Some(distances[0]) == least => left,
                    4 if Some(distances[1]) == least => above,
                    4 => corner,
                    other => panic!("filter {other}"),
                };
                rows.push(filtered[1 + i].wrapping_add(predicted as u8));
            }
        }
        rows
    }

    #[test]
    fn a_decoder_gets_the_rows_back_from_every_filter() {
        for texel_bytes in [1, 2, 3, 6] {
            for (width, height) in [(1, 1), (1, 5), (5, 1), (67, 4)] {
                let n = width * texel_bytes * height;
                let samples: Vec<u8> = (0..n as u32).map(|i| (hash::hash2(5, i, 0) >> 24) as u8).collect();
                for filter in [Filter::Sub, Filter::Up, Filter::Paeth] {
                    let mut filtered = vec![9; 30];
                    rows(&samples, width * texel_bytes, texel_bytes, filter, &mut filtered);
                    assert_eq!(undo(&filtered, width * texel_bytes, texel_bytes), samples);
                }
            }
        }
    }
}
