//! Painting copies into bands of rows.

use super::instances::Instance;
use super::pattern::{self, PatternKind};
use super::settings::{Blending, TileSampler};
use super::stamp::Stamp;
use crate::base::{Domain, num};

/// Rows of a band: the unit of parallel work.
pub(super) const BAND: usize = 32;

/// Lanes of the node's outputs within one band.
pub(super) type Lanes<'a> = [Option<&'a mut [f32]>; 5];

/// A copy on the grid of texels, where it is painted.
#[derive(Clone, Copy)]
struct Placed {
    /// Centre, texels.
    center: [f32; 2],
    /// How far the box reaches, texels, from the centre.
    extent: [f32; 2],
    /// Size of a texel in the copy's frame, in which the box is [-1, 1]².
    texel: [f32; 2],
    /// From texels to the copy's frame.
    matrix: [f32; 4],
    level: f32,
}

fn placed(instance: &Instance, domain: &Domain, stamps: &[Stamp<'_>]) -> Placed {
    let (tu, tv) = (domain.texel_u_mm(), domain.texel_v_mm());
    let [hx, hy] = instance.half.map(|h| h.max(1e-12));
    let (cos, sin) = (instance.cos, instance.sin);
    let matrix = [cos * tu / hx, sin * tv / hx, -sin * tu / hy, cos * tv / hy];
    let texel = [matrix[0].abs() + matrix[1].abs(), matrix[2].abs() + matrix[3].abs()];
    // Products of two of these stay finite.
    let texel = texel.map(|t| t.min(1e12));
    let turned = [hx * cos.abs() + hy * sin.abs(), hx * sin.abs() + hy * cos.abs()];
    Placed {
        center: [instance.u * domain.width as f32, instance.v * domain.height as f32],
        // Four tiles hold any copy of a tile whose sides are alike; in a ribbon a turned copy may be cut off there.
        extent: [
            (turned[0] / tu + 1.0).min(4.0 * domain.width as f32),
            (turned[1] / tv + 1.0).min(4.0 * domain.height as f32),
        ],
        texel,
        matrix,
        level: stamps[instance.pattern as usize].level(0.5 * texel[0], 0.5 * texel[1]),
    }
}

/// First and last texel whose centre lies within `extent` of `center`.
fn span(center: f32, extent: f32) -> (i64, i64) {
    ((center - extent - 0.5).ceil() as i64, (center + extent - 0.5).floor() as i64)
}

/// For every band, the numbers of the copies that touch it, in painting order.
pub(super) fn by_band(table: &[Instance], domain: &Domain, stamps: &[Stamp<'_>]) -> Vec<Vec<u32>> {
    let height = domain.height as i64;
    let bands = domain.height.div_ceil(BAND);
    let mut lists = vec![Vec::new(); bands];
    for (i, instance) in table.iter().enumerate() {
        let p = placed(instance, domain, stamps);
        let (first, last) = span(p.center[1], p.extent[1]);
        if last - first + 1 >= height {
            lists.iter_mut().for_each(|list| list.push(i as u32));
            continue;
        }
        // A box less than a tile high: at most two runs of bands, which may share one.
        let (a, b) = (first.rem_euclid(height) as usize / BAND, last.rem_euclid(height) as usize / BAND);
        let wraps = last.rem_euclid(height) < first.rem_euclid(height);
        let (head, tail) = if wraps { (0..b + 1, a.max(b + 1)..bands) } else { (a..b + 1, 0..0) };
        if first <= last {
            head.chain(tail).for_each(|band| lists[band].push(i as u32));
        }
    }
    lists
}

/// Overlap of the texel of width `texel` at `x` with [-1, 1], as a part of the texel.
#[inline(always)]
fn overlap(x: f32, texel: f32) -> f32 {
    ((x + 0.5 * texel).min(1.0) - (x - 0.5 * texel).max(-1.0)).max(0.0).min(texel) / texel
}

/// What all bands share.
pub(super) struct Scene<'a> {
    pub(super) node: &'a TileSampler,
    pub(super) domain: &'a Domain,
    pub(super) stamps: &'a [Stamp<'a>],
    pub(super) table: &'a [Instance],
}

impl Scene<'_> {
    /// Paint the copies of `list` into the band whose first row is `first`; `value` holds the background.
    pub(super) fn paint(&self, list: &[u32], first: usize, value: &mut [f32], lanes: &mut Lanes<'_>) {
        let width = self.domain.width;
        let rows = value.len() / width;
        // The greatest contribution so far, of the copy that gets the texel's id.
        let mut best = match self.node.blending {
            Blending::Max => value.to_vec(),
            _ => vec![0.0; value.len()],
        };
        for &number in list {
            let instance = &self.table[number as usize];
            let p = placed(instance, self.domain, self.stamps);
            let (y0, y1) = span(p.center[1], p.extent[1]);
            let (x0, x1) = span(p.center[0], p.extent[0]);
            // Every image of the box that crosses the band.
            let height = self.domain.height as i64;
            let (band0, band1) = (first as i64, (first + rows) as i64 - 1);
            let lowest = (y0 - band1).div_euclid(height);
            let highest = (y1 - band0).div_euclid(height);
            for image in lowest..=highest {
                let base = image * height;
                for y in y0.max(band0 + base)..=y1.min(band1 + base) {
                    let start = (y - base - band0) as usize * width;
                    self.row(instance, &p, y, x0..=x1, start, value, &mut best, lanes);
                }
            }
        }
    }

    /// Paint one row of one copy.
    #[expect(clippy::too_many_arguments, reason = "the inner loop's state, flat")]
    fn row(
        &self,
        instance: &Instance,
        p: &Placed,
        y: i64,
        xs: std::ops::RangeInclusive<i64>,
        start: usize,
        value: &mut [f32],
        best: &mut [f32],
        lanes: &mut Lanes<'_>,
    ) {
        let width = self.domain.width as i64;
        let dy = y as f32 + 0.5 - p.center[1];
        let mut column = xs.start().rem_euclid(width) as usize;
        for x in xs {
            let at = start + column;
            column = if column as i64 + 1 == width { 0 } else { column + 1 };
            let dx = x as f32 + 0.5 - p.center[0];
            let (px, py) = (p.matrix[0] * dx + p.matrix[1] * dy, p.matrix[2] * dx + p.matrix[3] * dy);
            let cover = overlap(px, p.texel[0]) * overlap(py, p.texel[1]);
            if cover <= 0.0 {
                continue;
            }
            let (s, t) = orient(instance, px.max(-1.0).min(1.0), py.max(-1.0).min(1.0));
            let pattern = match self.node.pattern_kind {
                PatternKind::Input => self.stamps[instance.pattern as usize].sample(s, t, p.level),
                kind => {
                    let texel = (0.5 * (p.texel[0] + p.texel[1])).min(2.0);
                    pattern::value(kind, 2.0 * s - 1.0, 2.0 * t - 1.0, self.node.pattern_specific, texel)
                }
            };
            if self.blend(instance.color, pattern * cover, cover, &mut value[at], &mut best[at]) {
                let put = [instance.id, (instance.index + 1) as f32, s, t];
                for (lane, put) in lanes[1..].iter_mut().zip(put) {
                    if let Some(lane) = lane {
                        lane[at] = put;
                    }
                }
            }
        }
    }

    /// Put a copy's texel on top; whether the texel now belongs to that copy.
    fn blend(&self, color: f32, pattern: f32, cover: f32, value: &mut f32, best: &mut f32) -> bool {
        let opacity = self.node.global_opacity;
        let shown = color * pattern * opacity;
        match self.node.blending {
            Blending::Add => {
                *value += shown;
                let wins = shown.abs() > *best;
                *best = best.max(shown.abs());
                wins
            }
            Blending::Max => {
                *value = value.max(shown);
                let wins = shown > *best;
                *best = best.max(shown);
                wins
            }
            Blending::Alpha => {
                *value = num::lerp(*value, color, num::saturate(pattern * opacity));
                pattern >= 0.5
            }
            Blending::Order => {
                // `pattern` carries the coverage of the texel: what it covers is replaced.
                if pattern > 0.0 {
                    *value = num::lerp(*value, color * pattern / cover, cover * opacity);
                }
                pattern > 0.0 && cover >= 0.5
            }
        }
    }
}

/// From the box [-1, 1]² to the pattern's unit square, by mirrors and quarter turns.
fn orient(instance: &Instance, x: f32, y: f32) -> (f32, f32) {
    let x = if instance.flip[0] { -x } else { x };
    let y = if instance.flip[1] { -y } else { y };
    // The pattern turns from u towards v, so its point is the box's turned back.
    let (x, y) = match instance.quarter {
        0 => (x, y),
        1 => (y, -x),
        2 => (-x, -y),
        _ => (-y, x),
    };
    (0.5 + 0.5 * x, 0.5 + 0.5 * y)
}
