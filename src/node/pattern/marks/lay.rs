//! Marks laid over rows of texels.

use super::series::{Mark, Series, Side};
use crate::base::num;
use crate::multiversion;

/// Where the texels of a row lie in the series on one side.
pub(super) struct Places {
    /// From the line of the marks' centres, mm, at least 0.
    across: Vec<f32>,
    /// Slip that applies there, periods.
    slip: Vec<f32>,
    /// Along the series, periods.
    along: Vec<f32>,
    /// `along` rounded down: the period it lies in.
    period: Vec<f32>,
}

impl Places {
    pub(super) fn new(width: usize) -> Self {
        let row = || vec![0.0; width];
        Self { across: row(), slip: row(), along: row(), period: row() }
    }
}

multiversion! {
    pub(super) fn find(s: &Series, side: &Side, v: f32, du: &[f32], dv: &[f32], place: &mut Places) {
        let n = place.across.len();
        let (du, dv, across) = (&du[..n], &dv[..n], &mut place.across[..n]);
        let (slip, along, period) = (&mut place.slip[..n], &mut place.along[..n], &mut place.period[..n]);
        for i in 0..n {
            let u = (i as f32 + 0.5) * s.texel_u + du[i];
            let x = num::wrap_half(u - 0.5) * s.girth_mm;
            // Around the body a mark's centre is met both ways.
            let from = num::wrap_half((x * side.mirror - s.position_mm) / s.girth_mm) * s.girth_mm;
            across[i] = from.abs();
            slip[i] = s.slip * num::saturate(0.5 - x * s.per_slip);
            let p = num::fract(v + dv[i]) * s.count - side.offset;
            along[i] = p;
            period[i] = p.floor();
        }
    }
}

multiversion! {
    pub(super) fn push(distance: &[f32], by: &[f32], out: &mut [f32]) {
        for ((o, d), by) in out.iter_mut().zip(distance).zip(by) { *o = (d + by).max(-1e9).min(1e9); }
    }
}

/// Texels that are looked at together: neighbours mostly lie in the same period, so that what a mark is made of is
/// read once for all of them.
const BLOCK: usize = 128;
/// Where the texels of a block lie in more periods, each is looked at alone.
const FEW: f32 = 4.0;

/// Least and greatest of some whole numbers.
#[inline(always)]
fn span(values: &[f32]) -> (f32, f32) {
    let mut low = [f32::MAX; 16];
    let mut high = [f32::MIN; 16];
    let (whole, rest) = values.as_chunks::<16>();
    for v in whole {
        for l in 0..16 {
            low[l] = if v[l] < low[l] { v[l] } else { low[l] };
            high[l] = if v[l] > high[l] { v[l] } else { high[l] };
        }
    }
    let (mut least, mut greatest) = (f32::MAX, f32::MIN);
    for l in 0..16 {
        (least, greatest) = (least.min(low[l]), greatest.max(high[l]));
    }
    for &v in rest {
        (least, greatest) = (least.min(v), greatest.max(v));
    }
    (least, greatest)
}

/// Distance to a four-sided mark's outline at (`x` >= 0, `y`) from its centre, mm, positive inside.
///
/// It is bounded by its ends (|x| = half width) and by sides that lean by the taper; distances to those lines are exact,
/// corners are rounded by a smooth minimum.
#[inline(always)]
fn quad(mark: &Mark, x: f32, y: f32) -> f32 {
    let side = (mark.half_length + mark.lean * x.min(mark.half_width) - y.abs()) / mark.normal;
    num::smooth_min(mark.half_width - x, side, mark.rounding)
}

/// Distance to an ellipse's outline: r (1 - r) / |grad r|, exact to first order at the outline.
#[inline(always)]
fn ellipse(mark: &Mark, x: f32, y: f32) -> f32 {
    let (hx, hy) = (mark.half_width, mark.half_length);
    let (nx, ny) = (x / hx, y / hy);
    let r = (nx * nx + ny * ny).sqrt();
    let (gx, gy) = (nx / hx, ny / hy);
    let d = (r * (1.0 - r) / (gx * gx + gy * gy).sqrt().max(1e-12)).max(-1e6);
    if r > 1e-3 { d } else { hx.min(hy) }
}

/// Lay the mark of period `k` over those texels, from `first` on, that lie in its own and the two neighbouring periods.
///
/// What a series has not is not computed: `BENT`, `BLENDED` are a division each.
#[inline(always)]
fn lay<const ELLIPSE: bool, const BENT: bool, const BLENDED: bool>(
    s: &Series,
    mark: &Mark,
    k: f32,
    place: &Places,
    first: usize,
    distance: &mut [f32],
    random: &mut [f32],
) {
    let texels = first..first + distance.len();
    let (across, slip) = (&place.across[texels.clone()], &place.slip[texels.clone()]);
    let (along, period) = (&place.along[texels.clone()], &place.period[texels]);
    let (mark, period_mm, blend_mm) = (*mark, s.period_mm, s.blend_mm);
    let n = distance.len();
    let (across, slip, along) = (&across[..n], &slip[..n], &along[..n]);
    let (period, random) = (&period[..n], &mut random[..n]);
    for i in 0..n {
        let y = (along[i] - k - 0.5 - mark.shift - slip[i] * mark.slip) * period_mm;
        let y = if BENT { y - mark.bend * (across[i] / mark.half_width).min(1.0) } else { y };
        let d = if ELLIPSE { ellipse(&mark, across[i], y) } else { quad(&mark, across[i], y) };
        let best = distance[i];
        let near = (k - period[i]).abs() <= 1.0;
        let more = if BLENDED { num::smooth_max(best, d, blend_mm) } else { best.max(d) };
        random[i] = if near & (d > best) { mark.random } else { random[i] };
        distance[i] = if near { more } else { best };
    }
}

#[inline(always)]
fn lay_all<const ELLIPSE: bool, const BENT: bool, const BLENDED: bool>(
    s: &Series,
    side: &Side,
    place: &Places,
    distance: &mut [f32],
    random: &mut [f32],
) {
    let n = distance.len();
    let mut first = 0;
    while first < n {
        let mut end = (first + BLOCK).min(n);
        let (mut least, mut greatest) = span(&place.period[first..end]);
        if greatest - least > FEW {
            end = first + 1;
            (least, greatest) = (place.period[first], place.period[first]);
        }
        let (distance, random) = (&mut distance[first..end], &mut random[first..end]);
        let mut k = least - 1.0;
        while k <= greatest + 1.0 {
            lay::<ELLIPSE, BENT, BLENDED>(s, side.mark(k), k, place, first, distance, random);
            k += 1.0;
        }
        first = end;
    }
}

multiversion! {
    /// Lay one side's four-sided marks over the distances so far.
    pub(super) fn quads(s: &Series, side: &Side, place: &Places, distance: &mut [f32], random: &mut [f32]) {
        match (s.is_bent, s.blend_mm > 0.0) {
            (false, false) => lay_all::<false, false, false>(s, side, place, distance, random),
            (false, true) => lay_all::<false, false, true>(s, side, place, distance, random),
            (true, false) => lay_all::<false, true, false>(s, side, place, distance, random),
            (true, true) => lay_all::<false, true, true>(s, side, place, distance, random),
        }
    }
}

multiversion! {
    /// Lay one side's ellipses over the distances so far.
    pub(super) fn ellipses(s: &Series, side: &Side, place: &Places, distance: &mut [f32], random: &mut [f32]) {
        match (s.is_bent, s.blend_mm > 0.0) {
            (false, false) => lay_all::<true, false, false>(s, side, place, distance, random),
            (false, true) => lay_all::<true, false, true>(s, side, place, distance, random),
            (true, false) => lay_all::<true, true, false>(s, side, place, distance, random),
            (true, true) => lay_all::<true, true, true>(s, side, place, distance, random),
        }
    }
}
