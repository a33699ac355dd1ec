//! What a series of marks is made of, once for all texels.

use super::{Marks, Sides};
use crate::base::hash;
use crate::node::Cx;

/// Hash channels.
const SHIFT: u32 = 1;
const SIZE: u32 = 2;
const SLIP: u32 = 3;
const VALUE: u32 = 4;

/// One mark, with every length in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    /// From the middle of its period, periods.
    pub(super) shift: f32,
    /// Of its left half against its right, of the series' slip, in [-1, 1).
    pub(super) slip: f32,
    pub(super) half_width: f32,
    pub(super) half_length: f32,
    /// Growth of the half length with the distance from the middle, and the length of its normal.
    pub(super) lean: f32,
    pub(super) normal: f32,
    /// 1 / `normal`, and 1 / the lesser of both halves: for bounds only, which need not be exact.
    pub(super) per_normal: f32,
    pub(super) per_least: f32,
    /// 1 / `half_width` and 1 / `half_length`, for bounds only.
    pub(super) per_half: [f32; 2],
    /// Width over which corners are rounded.
    pub(super) rounding: f32,
    /// How far the ends lie tail-ward.
    pub(super) bend: f32,
    pub(super) random: f32,
}

/// The marks on one side.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub(super) marks: Vec<Mark>,
    /// -1 where it is the mirror image.
    pub(super) mirror: f32,
    /// Where the first period begins, periods.
    pub(super) offset: f32,
}

/// A series with every length in mm.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) count: f32,
    pub(super) period_mm: f32,
    pub(super) girth_mm: f32,
    pub(super) sides: Vec<Side>,
    pub(super) position_mm: f32,
    /// On the mid-back the slip moves the left half only, sheared across the mark's middle.
    pub(super) slip: f32,
    /// 1 / the width over which the slip sets in, 1/mm.
    pub(super) per_slip: f32,
    pub(super) is_bent: bool,
    pub(super) blend_mm: f32,
    pub(super) texel_u: f32,
}

impl Series {
    pub(super) fn new(marks: &Marks, cx: &Cx<'_>) -> Self {
        let domain = &cx.domain;
        let middle = marks.sides == Sides::Middle;
        // Any number may stand in a struct made by hand.
        let count = marks.count.clamp(1, 10_000);
        let period_mm = domain.length_mm / count as f32;
        let flank_mm = 0.5 * domain.girth_mm * (1.0 - marks.belly);
        let half_width = (marks.reach * flank_mm).max(1e-6);
        let half_length = (0.5 * marks.length * period_mm).max(1e-6);
        let mark = |side: u32, number: u32| {
            let h = hash::hash2(cx.seed, number, side);
            let size = 1.0 + marks.jitter_size * hash::signed(hash::hash1(h, SIZE));
            let (hx, hy) = (half_width * size, half_length * size);
            let lean = hy * (marks.taper - 1.0) / hx;
            let normal = (1.0 + lean * lean).sqrt();
            Mark {
                shift: marks.jitter * hash::signed(hash::hash1(h, SHIFT)),
                slip: hash::signed(hash::hash1(h, SLIP)),
                half_width: hx,
                half_length: hy,
                lean,
                normal,
                per_normal: 1.0 / normal,
                per_least: 1.0 / hx.min(hy),
                per_half: [1.0 / hx, 1.0 / hy],
                rounding: 2.0 * marks.roundness * hx.min(hy),
                bend: marks.chevron * 2.0 * hy,
                random: hash::unit(hash::hash1(h, VALUE)),
            }
        };
        let stagger = if marks.sides == Sides::Alternate { 0.5 } else { 0.0 };
        let side = |side: u32| Side {
            marks: (0..count).map(|number| mark(side, number)).collect(),
            mirror: if side == 1 { -1.0 } else { 1.0 },
            offset: marks.offset.max(-1e3).min(1e3) + stagger * side as f32,
        };
        Self {
            count: count as f32,
            period_mm,
            girth_mm: domain.girth_mm,
            sides: (0..if middle { 1 } else { 2 }).map(side).collect(),
            position_mm: if middle { 0.0 } else { marks.position * flank_mm },
            slip: if middle { marks.slip } else { 0.0 },
            per_slip: 1.0 / (0.8 * marks.reach * flank_mm).max(1e-6),
            is_bent: marks.chevron != 0.0,
            blend_mm: marks.blend * period_mm,
            texel_u: 1.0 / domain.width as f32,
        }
    }
}

impl Side {
    /// The mark of period `k`, a whole number of at most a few `count`.
    #[inline(always)]
    pub(super) fn mark(&self, k: f32) -> &Mark {
        // Whole numbers below 2^24 are exact.
        let n = self.marks.len() as f32;
        &self.marks[(k - n * (k / n).floor()) as usize]
    }
}
