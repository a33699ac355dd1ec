//! One scale laid over the texels of a band.

use super::scale_paint::Band;
use crate::base::{num, sdf};
use crate::multiversion;

/// Texels worked on at once.
pub(super) const LANES: usize = 16;

/// What the kernels need to know of one scale.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub(super) cos: f32,
    pub(super) sin: f32,
    pub(super) half_width: f32,
    pub(super) half_length: f32,
    /// Half diagonals of the outline before it is cut to the half width and length, and its corner radius, mm.
    pub(super) hx: f32,
    pub(super) hy: f32,
    pub(super) radius: f32,
    pub(super) relief: f32,
    pub(super) dome: f32,
    pub(super) peak: f32,
    pub(super) bevel: f32,
    pub(super) keel: f32,
    pub(super) keel_width: f32,
    pub(super) keel_length: f32,
    /// Width of the anti-aliasing ramp, mm.
    pub(super) ramp: f32,
    /// The scale's number in the band.
    pub(super) number: u32,
    /// From a texel to the next, mm.
    pub(super) step_mm: f32,
}

/// The texels to lay it over: the same columns of several rows.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub(super) column: usize,
    pub(super) len: usize,
    /// Offset of the first column's centre from the scale's, around the body, mm.
    pub(super) x_mm: f32,
    /// The scale's centre along the body, mm.
    pub(super) y_mm: f32,
    /// Length of a texel along the body, mm.
    pub(super) texel_v: f32,
    /// First row, and one past the last.
    pub(super) rows: [i64; 2],
}

/// Forms of scales.
const FACET: u8 = 0;
const LEAF: u8 = 1;
const GRANULE: u8 = 2;
const SCUTE: u8 = 3;

/// Signed distance to the outline at (`x`, `y`) from the centre, negative inside, mm.
#[inline(always)]
fn distance<const FORM: u8>(pen: &Pen, x: f32, y: f32) -> f32 {
    let (a, b) = (pen.half_width, pen.half_length);
    match FORM {
        FACET => sdf::rounded_truncated_rhombus(x, y, pen.hx, pen.hy, a, b, pen.radius),
        LEAF => sdf::vesica(x, y, a, b),
        GRANULE => sdf::disc(x, y, a.min(b)),
        _ => sdf::rounded_box(x, bowed(pen, x, y), a, b, pen.radius),
    }
}

/// Height of the scale's body at (`x`, `y`) from the centre, mm.
#[inline(always)]
fn body<const FORM: u8>(pen: &Pen, x: f32, y: f32) -> f32 {
    match FORM {
        FACET | LEAF => roof(pen, x, y),
        GRANULE => {
            // A cone on a disc.
            let r = pen.half_width.min(pen.half_length);
            let c = num::saturate(1.0 - sdf::length(x, y) / r);
            pen.relief * (c * (1.0 - 0.35 * c) / 0.65) + pen.keel * c * c * c
        }
        _ => {
            // The ends sink to the base, so that the lowest row can lie over them.
            let ends = 1.0 - num::smoothstep(0.8, 1.0, (x / pen.half_width).abs());
            ends * roof(pen, x, bowed(pen, x, y))
        }
    }
}

/// `y` of a scute, a wide band whose free edge bows toward the tail.
#[inline(always)]
fn bowed(pen: &Pen, x: f32, y: f32) -> f32 {
    let s = x / pen.half_width;
    y + 0.5 * pen.half_length * (s * s).min(4.0)
}

/// Height profile along the scale: a long gentle ramp to the peak, then a short fall to 0.8 at the tip.
#[inline(always)]
fn ramp_profile(t: f32, peak: f32) -> f32 {
    let up = num::saturate(t / peak);
    let down = num::saturate((t - peak) / (1.0 - peak).max(1e-3));
    up * (1.3 - 0.3 * up) * (1.0 - 0.2 * down * down)
}

/// Height of a shingle, mm.
#[inline(always)]
fn roof(pen: &Pen, x: f32, y: f32) -> f32 {
    let s = x / pen.half_width;
    let t = 0.5 + 0.5 * y / pen.half_length;
    let across = 1.0 - pen.dome * (s * s).min(1.0);
    // A roof with a rounded ridge, fading in from the base and out before its end.
    let roof = (1.0 - s.abs() / pen.keel_width).max(0.0);
    let roof = roof * (2.0 - roof) * roof;
    let along = num::saturate(t * 6.0) * num::saturate((pen.keel_length - t) * 8.0 + 1.0);
    pen.relief * ramp_profile(t, pen.peak) * across + pen.keel * roof * along
}

/// Lay the scale over what is there, [`LANES`] texels at a time.
#[inline(always)]
fn lay<const FORM: u8>(pen: &Pen, run: &Run, band: &mut Band) {
    let pen = *pen;
    let (len, chunks) = (run.len as i32, run.len.div_ceil(LANES));
    for row in run.rows[0]..run.rows[1] {
        let y_mm = (row as f32 + 0.5) * run.texel_v - run.y_mm;
        let start = (row - band.rows.start) as usize * band.stride + run.column;
        let span = start..start + chunks * LANES;
        let (top, _) = band.top[span.clone()].as_chunks_mut::<LANES>();
        let (height, _) = band.height[span.clone()].as_chunks_mut::<LANES>();
        let (edge, _) = band.edge[span.clone()].as_chunks_mut::<LANES>();
        let (outline, _) = band.outline[span.clone()].as_chunks_mut::<LANES>();
        let (cover, _) = band.cover[span].as_chunks_mut::<LANES>();
        for c in 0..chunks {
            let (mut x, mut y, mut d) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let mut any_inside = false;
            for l in 0..LANES {
                let i = (c * LANES + l) as i32;
                let dx = run.x_mm + i as f32 * pen.step_mm;
                (x[l], y[l]) = sdf::turn(dx, y_mm, pen.cos, pen.sin);
                let out = distance::<FORM>(&pen, x[l], y[l]);
                // Texels past the run are infinitely far away: nothing of them changes.
                d[l] = if i < len { out } else { f32::INFINITY };
                any_inside |= d[l] < 0.0;
            }
            for l in 0..LANES {
                let alpha = num::saturate(0.5 - d[l] / pen.ramp);
                cover[c][l] += (1.0 - cover[c][l]) * alpha;
                // A border is this scale's own outline, or that of a scale laid over it later.
                edge[c][l] = if d[l] < 0.0 { -d[l] } else { edge[c][l].min(d[l]) };
            }
            if any_inside {
                for l in 0..LANES {
                    let inside = d[l] < 0.0;
                    // The rim rises from what lies beneath to the scale's body within the bevel.
                    let rim = num::saturate(-d[l] / pen.bevel);
                    let rim = rim * (2.0 - rim);
                    let h = num::lerp(height[c][l], body::<FORM>(&pen, x[l], y[l]), rim);
                    height[c][l] = if inside { h.max(0.0) } else { height[c][l] };
                    outline[c][l] = if inside { -d[l] } else { outline[c][l] };
                    top[c][l] = if inside { pen.number } else { top[c][l] };
                }
            }
        }
    }
}

multiversion! {
    /// Rhombus and hexagon.
    pub(super) fn lay_facet(pen: &Pen, run: &Run, band: &mut Band) { lay::<FACET>(pen, run, band) }
}

multiversion! {
    /// Leaf.
    pub(super) fn lay_leaf(pen: &Pen, run: &Run, band: &mut Band) { lay::<LEAF>(pen, run, band) }
}

multiversion! {
    /// Granule: a cone on a disc.
    pub(super) fn lay_granule(pen: &Pen, run: &Run, band: &mut Band) { lay::<GRANULE>(pen, run, band) }
}

multiversion! {
    /// Scute: a wide band whose free edge bows toward the tail.
    pub(super) fn lay_scute(pen: &Pen, run: &Run, band: &mut Band) { lay::<SCUTE>(pen, run, band) }
}
