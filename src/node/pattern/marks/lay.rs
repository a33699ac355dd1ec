//! Marks laid over rows of texels.

use std::ops::Range;

use super::series::{Mark, Series, Side};
use crate::base::num;
use crate::multiversion;

/// Where the texels of a row lie in the series on one side; rows are as long as [`padded`] says.
pub(super) struct Places {
    /// Texels of the row.
    width: usize,
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
        let row = || vec![0.0; padded(width)];
        Self { width, across: row(), slip: row(), along: row(), period: row() }
    }

    /// The block of lanes from texel `first` on, a multiple of [`LANES`].
    #[inline(always)]
    fn lanes(&self, first: usize) -> Lanes {
        Lanes {
            across: lanes(&self.across, first),
            slip: lanes(&self.slip, first),
            along: lanes(&self.along, first),
            period: lanes(&self.period, first),
        }
    }
}

/// Texels worked on at once.
const LANES: usize = 16;

/// Length of a row of `width` texels in whole blocks of lanes.
pub(super) fn padded(width: usize) -> usize {
    width.next_multiple_of(LANES)
}

#[inline(always)]
fn lanes(row: &[f32], first: usize) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&row[first..first + LANES]);
    lanes
}

/// [`Places`] of a few texels.
struct Lanes {
    across: [f32; LANES],
    slip: [f32; LANES],
    along: [f32; LANES],
    period: [f32; LANES],
}

multiversion! {
    pub(super) fn find(s: &Series, side: &Side, v: f32, du: &[f32], dv: &[f32], place: &mut Places) {
        let n = du.len();
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

/// Texels that are looked at together, whole blocks of lanes: neighbours mostly lie in the same period, so that what a mark is made of is
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

/// From the mark's middle along the body, mm.
#[inline(always)]
fn along_mark<const BENT: bool>(s: &Series, mark: &Mark, k: f32, across: f32, slip: f32, along: f32) -> f32 {
    let y = (along - k - 0.5 - mark.shift - slip * mark.slip) * s.period_mm;
    if BENT { y - mark.bend * (across / mark.half_width).min(1.0) } else { y }
}

#[inline(always)]
fn outline<const ELLIPSE: bool>(mark: &Mark, x: f32, y: f32) -> f32 {
    if ELLIPSE { ellipse(mark, x, y) } else { quad(mark, x, y) }
}

/// Whether the distance is less than `best`. It takes no division, and yes is certain: the bounds have room for rounding.
#[inline(always)]
fn is_less<const ELLIPSE: bool>(mark: &Mark, x: f32, y: f32, best: f32) -> bool {
    if ELLIPSE {
        // r / |grad r| is at least the lesser half: outside, the distance is at most 1 - r of it.
        let r = (1.0 - best * mark.per_least).max(1.0);
        let (nx, ny) = (x * mark.per_half[0], y * mark.per_half[1]);
        nx * nx + ny * ny > 1.0002 * r * r
    } else {
        // A smooth minimum is at most the lesser of both.
        let side = (mark.half_length + mark.lean * x.min(mark.half_width) - y.abs()) * mark.per_normal;
        let most = (mark.half_width - x).min(side);
        most + 1e-5 * most.abs() < best
    }
}

/// Distances to the mark of period `k`; none where no texel's reaches what it must.
#[inline(always)]
fn reaching<const ELLIPSE: bool, const BENT: bool>(
    s: &Series,
    mark: &Mark,
    k: f32,
    at: &Lanes,
    least: &[f32; LANES],
) -> Option<[f32; LANES]> {
    let mut y = [0.0; LANES];
    let mut any = false;
    for l in 0..LANES {
        y[l] = along_mark::<BENT>(s, mark, k, at.across[l], at.slip[l], at.along[l]);
        any |= !is_less::<ELLIPSE>(mark, at.across[l], y[l], least[l]);
    }
    if !any {
        return None;
    }
    let mut d = [0.0; LANES];
    for l in 0..LANES {
        d[l] = outline::<ELLIPSE>(mark, at.across[l], y[l]);
    }
    Some(d)
}

/// Lay the mark of period `k` over those texels that lie in its own and the two neighbouring periods.
///
/// What a series has not is not computed: `BENT`, `BLENDED` are a division each.
#[inline(always)]
fn lay<const ELLIPSE: bool, const BENT: bool, const BLENDED: bool>(
    s: &Series,
    mark: &Mark,
    k: f32,
    place: &Places,
    texels: Range<usize>,
    distance: &mut [f32],
    random: &mut [f32],
) {
    for first in texels.step_by(LANES) {
        let at = place.lanes(first);
        let (mut best, mut value) = (lanes(distance, first), lanes(random, first));
        let mut least = best;
        if BLENDED {
            // A mark that is farther away than the blend changes nothing.
            for l in 0..LANES {
                least[l] = best[l] - 1.001 * s.blend_mm;
            }
        }
        let Some(d) = reaching::<ELLIPSE, BENT>(s, mark, k, &at, &least) else { continue };
        for l in 0..LANES {
            let near = (k - at.period[l]).abs() <= 1.0;
            let more = if BLENDED { num::smooth_max(best[l], d[l], s.blend_mm) } else { best[l].max(d[l]) };
            value[l] = if near & (d[l] > best[l]) { mark.random } else { value[l] };
            best[l] = if near { more } else { best[l] };
        }
        distance[first..first + LANES].copy_from_slice(&best);
        random[first..first + LANES].copy_from_slice(&value);
    }
}

/// Lay the marks of period `k` and its neighbours over texels that all lie in it: its own first, which is mostly the
/// nearest, so that there is little left to do. Of marks that are equally near the first along the body counts.
#[inline(always)]
fn lay_around<const ELLIPSE: bool, const BENT: bool>(
    s: &Series,
    side: &Side,
    k: f32,
    place: &Places,
    texels: Range<usize>,
    distance: &mut [f32],
    random: &mut [f32],
) {
    let (before, own, after) = (*side.mark(k - 1.0), *side.mark(k), *side.mark(k + 1.0));
    for first in texels.step_by(LANES) {
        let at = place.lanes(first);
        let (mut best, mut value) = (lanes(distance, first), lanes(random, first));
        let mut least = best;
        let (mut nearest, mut of) = ([f32::NEG_INFINITY; LANES], [own.random; LANES]);
        if let Some(d) = reaching::<ELLIPSE, BENT>(s, &own, k, &at, &least) {
            for l in 0..LANES {
                nearest[l] = d[l].max(f32::NEG_INFINITY);
                least[l] = best[l].max(d[l]);
            }
        }
        if let Some(d) = reaching::<ELLIPSE, BENT>(s, &before, k - 1.0, &at, &least) {
            for l in 0..LANES {
                of[l] = if d[l] >= nearest[l] { before.random } else { of[l] };
                nearest[l] = nearest[l].max(d[l]);
                least[l] = least[l].max(d[l]);
            }
        }
        if let Some(d) = reaching::<ELLIPSE, BENT>(s, &after, k + 1.0, &at, &least) {
            for l in 0..LANES {
                of[l] = if d[l] > nearest[l] { after.random } else { of[l] };
                nearest[l] = nearest[l].max(d[l]);
            }
        }
        for l in 0..LANES {
            value[l] = if nearest[l] > best[l] { of[l] } else { value[l] };
            best[l] = best[l].max(nearest[l]);
        }
        distance[first..first + LANES].copy_from_slice(&best);
        random[first..first + LANES].copy_from_slice(&value);
    }
}

/// Lay the marks around one texel.
#[inline(always)]
fn lay_one<const ELLIPSE: bool, const BENT: bool, const BLENDED: bool>(
    s: &Series,
    side: &Side,
    place: &Places,
    i: usize,
    distance: &mut f32,
    random: &mut f32,
) {
    for step in [-1.0, 0.0, 1.0] {
        let k = place.period[i] + step;
        let mark = side.mark(k);
        let y = along_mark::<BENT>(s, mark, k, place.across[i], place.slip[i], place.along[i]);
        let d = outline::<ELLIPSE>(mark, place.across[i], y);
        *random = if d > *distance { mark.random } else { *random };
        *distance = if BLENDED { num::smooth_max(*distance, d, s.blend_mm) } else { distance.max(d) };
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
    for first in (0..place.width).step_by(BLOCK) {
        let texels = first..(first + BLOCK).min(place.width);
        let (least, greatest) = span(&place.period[texels.clone()]);
        if greatest - least > FEW {
            for i in texels {
                lay_one::<ELLIPSE, BENT, BLENDED>(s, side, place, i, &mut distance[i], &mut random[i]);
            }
        } else if !BLENDED && least == greatest {
            lay_around::<ELLIPSE, BENT>(s, side, least, place, texels, distance, random);
        } else {
            let mut k = least - 1.0;
            while k <= greatest + 1.0 {
                let mark = *side.mark(k);
                lay::<ELLIPSE, BENT, BLENDED>(s, &mark, k, place, texels.clone(), distance, random);
                k += 1.0;
            }
        }
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
