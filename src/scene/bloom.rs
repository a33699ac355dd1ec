//! Bloom: the light that a lens spreads around what is bright.
//!
//! The spread light is the mean of the picture at half its size, a quarter, and so on, each blurred by as much: a peak with
//! wide skirts, as real lenses have (Jimenez 2014, Next Generation Post Processing in Call of Duty: Advanced Warfare, takes
//! such a pyramid for it; weights are ours).

/// Brighter than this is this bright: the target of the preview holds no more.
const BRIGHTEST: f32 = 6e4;
/// Levels are not smaller than this many texels a side.
const LEAST_SIDE: usize = 4;

/// Spread `share` of the light of a picture, rows of `width` texels of linear light, around each of its texels.
///
/// * `share` - in [0, 1], else cut to it; 0 and NaN leave the picture as it is.
/// * light is neither lost nor made, but for a little at the edges, where what is outside is taken to be as bright as the edge.
/// * where light is spread, texels are cut to [0, 60000] first; NaN is 0.
pub fn bloom(texels: &mut [[f32; 3]], width: usize, share: f32) {
    let height = texels.len().checked_div(width).unwrap_or(0);
    if share.is_nan() || share <= 0.0 || width * height == 0 || texels.len() != width * height {
        return;
    }
    let share = share.min(1.0);
    // `max` first: it gives 0 for NaN.
    let limited = texels.iter().map(|t| t.map(|c| c.max(0.0).min(BRIGHTEST)));
    let mut levels = vec![Level { width, height, texels: limited.collect() }];
    while let Some(last) = levels.last().filter(|l| l.width.min(l.height) >= 2 * LEAST_SIDE) {
        levels.push(last.halved());
    }
    let count = levels.len() - 1;
    if count == 0 {
        return;
    }
    // From the smallest up: each is the mean of itself and all below.
    let mut spread = levels.swap_remove(count);
    for (below, level) in levels.drain(1..).rev().enumerate() {
        spread = level.mixed(&spread, 1.0 / (below + 2) as f32);
    }
    let shared = levels[0].mixed(&spread, 1.0 - share);
    texels.copy_from_slice(&shared.texels);
}

/// A picture of the pyramid.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
}

impl Level {
    /// The texel, or the nearest one of the edge.
    fn at(&self, x: isize, y: isize) -> [f32; 3] {
        let inside = |i: isize, n: usize| (i.max(0) as usize).min(n - 1);
        self.texels[inside(y, self.height) * self.width + inside(x, self.width)]
    }

    /// Half as many columns and rows, rounded up, each the mean of the 16 texels around by a tent.
    fn halved(&self) -> Self {
        const TENT: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let texels = (0..width * height).map(|i| {
            let (x, y) = (2 * (i % width) as isize, 2 * (i / width) as isize);
            let mut mean = [0.0; 3];
            for (row, a) in TENT.iter().enumerate() {
                for (column, b) in TENT.iter().enumerate() {
                    let texel = self.at(x + column as isize - 1, y + row as isize - 1);
                    (0..3).for_each(|c| mean[c] += a * b * texel[c]);
                }
            }
            mean
        });
        Self { width, height, texels: texels.collect() }
    }

    /// This one and a smaller one drawn as large as it, bilinear; `own` is the share of this one.
    fn mixed(&self, smaller: &Self, own: f32) -> Self {
        let texels = self.texels.iter().enumerate().map(|(i, texel)| {
            let (x, y) = ((i % self.width) as isize, (i / self.width) as isize);
            // Three quarters of the nearest, a quarter of the next.
            let (x0, y0) = (x / 2, y / 2);
            let (x1, y1) = (x0 + 2 * (x % 2) - 1, y0 + 2 * (y % 2) - 1);
            let [a, b, c, d] =
                [smaller.at(x0, y0), smaller.at(x1, y0), smaller.at(x0, y1), smaller.at(x1, y1)];
            std::array::from_fn(|i| {
                let below = 0.75 * (0.75 * a[i] + 0.25 * b[i]) + 0.25 * (0.75 * c[i] + 0.25 * d[i]);
                below + own * (texel[i] - below)
            })
        });
        Self { width: self.width, height: self.height, texels: texels.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 96;
    const HEIGHT: usize = 64;

    fn point(light: f32) -> Vec<[f32; 3]> {
        let mut texels = vec![[0.0; 3]; WIDTH * HEIGHT];
        texels[HEIGHT / 2 * WIDTH + WIDTH / 2] = [light; 3];
        texels
    }

    #[test]
    fn even_light_stays_and_no_share_changes_nothing() {
        let mut even = vec![[0.5, 1.0, 2.0]; WIDTH * HEIGHT];
        bloom(&mut even, WIDTH, 0.3);
        assert!(even.iter().all(|t| (t[0] - 0.5).abs() < 1e-5 && (t[2] - 2.0).abs() < 1e-5));
        for share in [0.0, -1.0, f32::NAN] {
            let mut same = point(9.0);
            bloom(&mut same, WIDTH, share);
            assert_eq!(same, point(9.0), "{share}");
        }
        // Too small to spread in, or no picture at all.
        for (count, width) in [(1, 1), (12, 4), (0, 0), (7, 3)] {
            let mut small = vec![[1.0; 3]; count];
            bloom(&mut small, width, 0.5);
            assert_eq!(small, vec![[1.0; 3]; count]);
        }
    }

    #[test]
    fn a_bright_place_spreads_far_and_keeps_its_light() {
        let mut texels = point(100.0);
        bloom(&mut texels, WIDTH, 0.2);
        let at = |x: usize| texels[HEIGHT / 2 * WIDTH + x][1];
        let sum: f32 = texels.iter().map(|t| t[1]).sum();
        assert!((sum - 100.0).abs() < 1.0, "{sum}");
        assert!((80.0..90.0).contains(&at(WIDTH / 2)), "{}", at(WIDTH / 2));
        for (near, far) in [(1, 4), (4, 12), (12, 25)] {
            assert!(at(WIDTH / 2 + near) > 1.5 * at(WIDTH / 2 + far), "{near} {far}");
        }
        assert!(at(WIDTH / 2 + 25) > 1e-4);
    }

    #[test]
    fn what_is_no_number_does_not_spread() {
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            let mut texels = point(odd);
            bloom(&mut texels, WIDTH, 0.5);
            let beside = texels[HEIGHT / 2 * WIDTH + WIDTH / 2 + 1][0];
            assert!(beside.is_finite() && beside >= 0.0, "{odd} {beside}");
            assert_eq!(beside > 0.0, odd > 0.0, "{odd}");
        }
    }
}
