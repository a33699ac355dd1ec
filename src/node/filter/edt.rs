//! Euclidean distance to the outline of a mask, on the torus: the core of `distance`, `outline`, `dilate`, `erode`.
//!
//! Seeds are the texels at which the mask crosses its level towards a neighbour. Every texel's nearest seed is found
//! exactly in two passes (columns, then rows by the lower envelope of parabolas: Felzenszwalb and Huttenlocher,
//! "Distance transforms of sampled functions", Theory of Computing 8, 2012). A row is unrolled from its column with
//! the nearest seed, whose parabola nothing on the other side can undercut, so one turn of the torus is enough.
//!
//! From the seed to the outline itself goes the linear interpolation of the mask: a straight outline is met exactly,
//! wherever it lies between texel centres.

use rayon::prelude::*;

use crate::base::Domain;
use crate::multiversion;
use crate::node::Inputs;

/// What a length of these nodes is measured in.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LengthUnit {
    /// Fractions of the tile's shorter side.
    #[default]
    Tile,
    /// Millimetres.
    Mm,
}

impl LengthUnit {
    /// One unit in mm.
    pub(super) fn mm(self, domain: &Domain) -> f32 {
        match self {
            Self::Tile => domain.shorter_mm(),
            Self::Mm => 1.0,
        }
    }
}

/// No seed in the column. Sums of two stay far from overflow.
const NONE: i32 = 1 << 29;
/// Values are limited to this, so that squares stay finite.
const LIMIT: f32 = 1e18;
/// Half the length of the piece of outline that one seed stands for, in texels.
const PIECE: f64 = 0.71;

/// Bytes that [`signed_distance`] works in: a texel's excess over the level, whether it is a seed, and its offset.
pub(super) fn own_bytes(domain: &Domain) -> u64 {
    9 * domain.texels() as u64
}

/// Signed distance in mm, negative inside, of the mask `ins[mask] >= ins[level]`, for the whole plane.
///
/// A mask without an outline is half the tile's diagonal away from it.
pub(super) fn signed_distance(domain: &Domain, ins: &Inputs<'_>, mask: usize, level: usize, out: &mut [f32]) {
    let (width, height) = (domain.width, domain.height);
    let (mask, level) = (ins.scalar(mask), ins.scalar(level));
    let mut excess = vec![0.0f32; width * height];
    excess.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        subtract(mask.row(y as i64), level.row(y as i64), row);
    });
    let row = |y: usize| &excess[y * width..(y + 1) * width];
    let mut seeds = vec![0u8; width * height];
    seeds.par_chunks_mut(width).enumerate().for_each(|(y, seeds)| {
        crossings(row((y + height - 1) % height), row(y), row((y + 1) % height), seeds);
    });
    let offsets = column_offsets(&seeds, width);
    drop(seeds);
    let (tu, tv) = (f64::from(domain.texel_u_mm()), f64::from(domain.texel_v_mm()));
    let far = 0.5 * domain.girth_mm.hypot(domain.length_mm);
    out.par_chunks_mut(width).enumerate().for_each_init(Scratch::default, |scratch, (y, out)| {
        let dy = &offsets[y * width..(y + 1) * width];
        if !envelope(dy, tv / tu, scratch) {
            for (o, f) in out.iter_mut().zip(row(y)) {
                *o = if *f >= 0.0 { -far } else { far };
            }
            return;
        }
        for x in 0..width {
            let dx = scratch.dx[x];
            let sx = (x as i64 + i64::from(dx)).rem_euclid(width as i64) as usize;
            let dy = dy[sx];
            let sy = (y as i64 + i64::from(dy)).rem_euclid(height as i64) as usize;
            let distance = to_outline(&excess, (width, height), (sx, sy), (-dx, -dy), (tu, tv));
            out[x] = if row(y)[x] >= 0.0 { -distance } else { distance };
        }
    });
}

multiversion! {
    fn subtract(mask: &[f32], level: &[f32], out: &mut [f32]) {
        for ((o, m), l) in out.iter_mut().zip(mask).zip(level) {
            *o = (*m - *l).max(-LIMIT).min(LIMIT);
        }
    }
}

multiversion! {
    fn crossings(above: &[f32], here: &[f32], below: &[f32], out: &mut [u8]) {
        let n = here.len();
        for i in 0..n {
            let inside = here[i] >= 0.0;
            out[i] = u8::from((above[i] >= 0.0) != inside) | u8::from((below[i] >= 0.0) != inside);
        }
        for i in 0..n {
            let inside = here[i] >= 0.0;
            let (left, right) = (here[if i == 0 { n - 1 } else { i - 1 }], here[if i + 1 == n { 0 } else { i + 1 }]);
            out[i] |= u8::from((left >= 0.0) != inside) | u8::from((right >= 0.0) != inside);
        }
    }
}

/// Rows from each texel to the nearest seed of its column, through the seam; [`NONE`] or more where there is none.
/// Of two seeds equally near it is the one below.
fn column_offsets(seeds: &[u8], width: usize) -> Vec<i32> {
    let height = (seeds.len() / width) as i32;
    let mut offsets = vec![0i32; seeds.len()];
    let mut last = vec![-NONE; width];
    let mut next = vec![NONE; width];
    // The last seed of the turn before, the first of the turn after.
    for (y, seeds) in seeds.chunks_exact(width).enumerate() {
        track(seeds, y as i32 - height, &mut last);
    }
    for (y, seeds) in seeds.chunks_exact(width).enumerate().rev() {
        track(seeds, y as i32 + height, &mut next);
    }
    let rows = || seeds.chunks_exact(width).enumerate();
    for ((y, seeds), out) in rows().zip(offsets.chunks_exact_mut(width)) {
        track(seeds, y as i32, &mut last);
        upwards(y as i32, &last, out);
    }
    for ((y, seeds), out) in rows().zip(offsets.chunks_exact_mut(width)).rev() {
        track(seeds, y as i32, &mut next);
        nearer(y as i32, &next, out);
    }
    offsets
}

multiversion! {
    fn track(seeds: &[u8], y: i32, latest: &mut [i32]) {
        for (l, s) in latest.iter_mut().zip(seeds) { *l = if *s != 0 { y } else { *l }; }
    }
}

multiversion! {
    fn upwards(y: i32, last: &[i32], out: &mut [i32]) {
        for (o, l) in out.iter_mut().zip(last) { *o = *l - y; }
    }
}

multiversion! {
    fn nearer(y: i32, next: &[i32], out: &mut [i32]) {
        for (o, n) in out.iter_mut().zip(next) {
            let down = *n - y;
            *o = if down <= -*o { down } else { *o };
        }
    }
}

/// What [`envelope`] works in; its result is `dx`.
#[derive(Default)]
struct Scratch {
    /// Columns from each texel to that of its nearest seed.
    dx: Vec<i32>,
    /// Unrolled columns of the parabolas on the envelope, with their squared heights.
    sites: Vec<(i32, f64)>,
    /// Where each parabola begins to be the lowest.
    starts: Vec<f64>,
}

/// The column of the nearest seed for every texel of a row, given the rows `dy` to each column's nearest; `ratio` is
/// the height of a texel over its width. False if there is no seed. Of two equally near it is the one to the right.
fn envelope(dy: &[i32], ratio: f64, scratch: &mut Scratch) -> bool {
    let n = dy.len();
    let nearest =
        (0..n).min_by_key(|&x| dy[x].unsigned_abs()).filter(|&x| dy[x].unsigned_abs() < NONE as u32 / 2);
    let Some(origin) = nearest else { return false };
    let Scratch { dx, sites, starts } = scratch;
    sites.clear();
    starts.clear();
    for i in 0..=n {
        let d = dy[(origin + i) % n];
        if d.unsigned_abs() >= NONE as u32 / 2 {
            continue;
        }
        let (x, height) = (i as i32, (f64::from(d) * ratio).powi(2));
        let mut start = f64::NEG_INFINITY;
        while let (Some(&(x0, height0)), Some(&start0)) = (sites.last(), starts.last()) {
            // The intersection with the last parabola, in a form that is exact where the heights are equal.
            start = 0.5 * f64::from(x + x0) + (height - height0) / (2.0 * f64::from(x - x0));
            if start > start0 {
                break;
            }
            sites.pop();
            starts.pop();
            start = f64::NEG_INFINITY;
        }
        sites.push((x, height));
        starts.push(start);
    }
    dx.resize(n, 0);
    let mut k = 0;
    for i in 0..n {
        while k + 1 < sites.len() && starts[k + 1] <= i as f64 {
            k += 1;
        }
        dx[(origin + i) % n] = sites[k].0 - i as i32;
    }
    true
}

/// Distance in mm to the outline near the seed, from the texel at `away` (columns, rows) of the seed.
///
/// The outline is taken as a piece of line through the point at which the mask crosses its level between the seed and
/// a neighbour, the one nearest to the texel; its normal is the gradient around the seed.
fn to_outline(
    excess: &[f32],
    (width, height): (usize, usize),
    (x, y): (usize, usize),
    away: (i32, i32),
    (tu, tv): (f64, f64),
) -> f32 {
    let columns = [if x == 0 { width - 1 } else { x - 1 }, x, if x + 1 == width { 0 } else { x + 1 }];
    let rows = [if y == 0 { height - 1 } else { y - 1 }, y, if y + 1 == height { 0 } else { y + 1 }];
    let f = rows.map(|y| columns.map(|x| f64::from(excess[y * width + x])));
    let here = f[1][1];
    let (px, py) = (f64::from(away.0) * tu, f64::from(away.1) * tv);
    // Towards the inside, by Scharr's weights (their scale does not matter); the inside of a seed outside lies beyond
    // the crossing. A feature one texel thin crosses on both sides and has no gradient.
    let column = |i: usize| 3.0 * f[0][i] + 10.0 * f[1][i] + 3.0 * f[2][i];
    let line = |j: usize| 3.0 * f[j][0] + 10.0 * f[j][1] + 3.0 * f[j][2];
    let (gu, gv) = ((column(2) - column(0)) / tu, (line(2) - line(0)) / tv);
    let g = (gu * gu + gv * gv).sqrt();
    let inside = here >= 0.0;
    let side = if inside { -1.0 } else { 1.0 };
    let unlike = |there: f64| (there >= 0.0) != inside;
    let thin = (unlike(f[1][0]) && unlike(f[1][2])) || (unlike(f[0][1]) && unlike(f[2][1]));
    // The nearest crossing: first one that the gradient agrees with, else any, with its own direction.
    let mut best = (false, f64::INFINITY, (0.0, 0.0), (0.0, 0.0));
    for (eu, ev, there) in
        [(-1.0, 0.0, f[1][0]), (1.0, 0.0, f[1][2]), (0.0, -1.0, f[0][1]), (0.0, 1.0, f[2][1])]
    {
        if unlike(there) {
            let t = here / (here - there);
            let (qx, qy) = (px - t * eu * tu, py - t * ev * tv);
            let d = qx * qx + qy * qy;
            let agrees = !thin && side * (gu * eu + gv * ev) > 0.0;
            if agrees && !best.0 || agrees == best.0 && d < best.1 {
                best = (agrees, d, (qx, qy), if agrees { (gu / g, gv / g) } else { (eu, ev) });
            }
        }
    }
    let (_, _, (qx, qy), (nu, nv)) = best;
    let across = qx * nu + qy * nv;
    let along = ((qy * nu - qx * nv).abs() - PIECE * (tu * tv).sqrt()).max(0.0);
    (across * across + along * along).sqrt() as f32
}

#[cfg(test)]
mod tests {
    use super::super::testing::noise;
    use super::*;

    #[test]
    fn nearest_seeds_are_those_of_brute_force_on_the_torus() {
        for (w, h, seed) in [(1, 1, 1), (1, 9, 2), (7, 1, 3), (13, 9, 4), (17, 31, 5), (32, 20, 6)] {
            for part in [0.005, 0.03, 0.3, 1.0] {
                for ratio in [1.0f64, 1.3, 0.6] {
                    let seeds: Vec<u8> =
                        noise(w, h, seed).data().iter().map(|&v| u8::from(v < part)).collect();
                    let offsets = column_offsets(&seeds, w);
                    let mut scratch = Scratch::default();
                    for y in 0..h {
                        let dy = &offsets[y * w..(y + 1) * w];
                        let found = envelope(dy, ratio, &mut scratch);
                        assert_eq!(found, seeds.contains(&1));
                        for x in (0..w).take_while(|_| found) {
                            let column = (x as i64 + i64::from(scratch.dx[x])).rem_euclid(w as i64) as usize;
                            let (du, dv) = (f64::from(scratch.dx[x]), f64::from(dy[column]) * ratio);
                            let row = (y as i64 + i64::from(dy[column])).rem_euclid(h as i64) as usize;
                            assert_eq!(seeds[row * w + column], 1);
                            let best = brute(&seeds, w, h, (x, y), ratio);
                            assert!(
                                (du * du + dv * dv - best).abs() < 1e-9,
                                "{w} {h} {part} {ratio} {x} {y}"
                            );
                        }
                    }
                }
            }
        }
    }

    fn brute(seeds: &[u8], w: usize, h: usize, (x, y): (usize, usize), ratio: f64) -> f64 {
        let around = |a: usize, b: usize, n: usize| {
            let d = a.abs_diff(b);
            d.min(n - d) as f64
        };
        let mut best = f64::INFINITY;
        for i in (0..w * h).filter(|&i| seeds[i] == 1) {
            let (du, dv) = (around(i % w, x, w), around(i / w, y, h) * ratio);
            best = best.min(du * du + dv * dv);
        }
        best
    }
}
