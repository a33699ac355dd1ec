//! An input image as a stamp: smaller versions of it, so that small copies do not alias.

use crate::base::{Plane, Rows, num};

/// An image and its halves, down to one texel.
pub(super) struct Stamp<'a> {
    full: Rows<'a>,
    height: usize,
    halves: Vec<Plane>,
}

impl<'a> Stamp<'a> {
    /// The stamp of an input of `height` rows.
    pub(super) fn new(full: Rows<'a>, height: usize) -> Self {
        let mut halves: Vec<Plane> = Vec::new();
        if full.constant().is_none() {
            let (mut w, mut h) = (full.width(), height);
            while w > 1 || h > 1 {
                let rows = halves.last().map_or(full, Plane::rows);
                halves.push(halved(rows, w, h));
                (w, h) = ((w / 2).max(1), (h / 2).max(1));
            }
        }
        Self { full, height, halves }
    }

    /// How far down the halves to read where a texel of the output covers `du` by `dv` of the stamp's unit square.
    pub(super) fn level(&self, du: f32, dv: f32) -> f32 {
        let texels = |d: f32, n: usize| (d * n as f32).max(1.0).min(1e6);
        // The mean of both directions: the sharper one would alias, the softer one would blur.
        let level = 0.5 * (num::log2(texels(du, self.full.width())) + num::log2(texels(dv, self.height)));
        level.max(0.0).min(self.halves.len() as f32)
    }

    /// The stamp at (`s`, `t`) in [0, 1]², between two halves; it does not wrap.
    pub(super) fn sample(&self, s: f32, t: f32, level: f32) -> f32 {
        if let Some(value) = self.full.constant() {
            return value.max(-1e15).min(1e15);
        }
        let low = level.floor();
        let (i, mix) = (low as usize, level - low);
        let a = self.at(i, s, t);
        let value = if mix > 0.0 { num::lerp(a, self.at(i + 1, s, t), mix) } else { a };
        value.max(-1e15).min(1e15)
    }

    fn at(&self, level: usize, s: f32, t: f32) -> f32 {
        let (rows, w, h) = match level.min(self.halves.len()) {
            0 => (self.full, self.full.width() as f32, self.height as f32),
            i => (
                self.halves[i - 1].rows(),
                self.halves[i - 1].width() as f32,
                self.halves[i - 1].height() as f32,
            ),
        };
        // Half a texel from the border, the next texel would be that of the opposite border.
        let x = (s * w).max(0.5).min(w - 0.5);
        let y = (t * h).max(0.5).min(h - 0.5);
        rows.bilinear(x, y)
    }
}

/// Weights of up to three texels from `2 i` that make texel `i` of half a side: each covers the same part of the image.
fn weights(i: usize, side: usize) -> [f32; 3] {
    let half = side / 2;
    if side == 1 {
        [1.0, 0.0, 0.0]
    } else if side.is_multiple_of(2) {
        [0.5, 0.5, 0.0]
    } else {
        let n = side as f32;
        [(half - i) as f32 / n, half as f32 / n, (i + 1) as f32 / n]
    }
}

fn halved(rows: Rows<'_>, w: usize, h: usize) -> Plane {
    Plane::from_fn((w / 2).max(1), (h / 2).max(1), |x, y| {
        let (wx, wy) = (weights(x, w), weights(y, h));
        let mut sum = 0.0;
        for (j, wy) in wy.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let row = rows.row((2 * y + j) as i64);
            for (i, wx) in wx.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                sum += wx * wy * row[2 * x + i].max(-1e15).min(1e15);
            }
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_keep_the_mean_of_odd_images() {
        let p = Plane::from_fn(13, 7, |x, y| (x * x + 3 * y) as f32);
        let stamp = Stamp::new(p.rows(), 7);
        assert_eq!(stamp.halves.len(), 3);
        let mean = num::mean(p.data());
        assert!((f64::from(stamp.sample(0.3, 0.9, 3.0)) - mean).abs() < 1e-4);
        assert!((f64::from(stamp.sample(0.3, 0.9, stamp.level(1.0, 1.0))) - mean).abs() < 1.0);
    }

    #[test]
    fn borders_do_not_bleed() {
        let p = Plane::from_fn(8, 8, |x, _| if x < 4 { 0.0 } else { 1.0 });
        let stamp = Stamp::new(p.rows(), 8);
        assert_eq!(stamp.sample(0.0, 0.5, 0.0), 0.0);
        assert_eq!(stamp.sample(1.0, 0.5, 0.0), 1.0);
    }
}
