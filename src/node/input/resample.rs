//! Making an image smaller by exact area averages, and reading it between its texels.

use crate::base::Plane;

/// The plane with `width` columns and `height` rows at most: each texel of a smaller side is the exact mean of the
/// area it covers; a side that is not larger stays as it is. The mean of the plane is kept.
pub(super) fn shrink(plane: Plane, width: usize, height: usize) -> Plane {
    let (w, h) = (plane.width(), plane.height());
    if plane.data().is_empty() {
        return plane;
    }
    let (new_w, new_h) = (width.clamp(1, w), height.clamp(1, h));
    let plane = if new_w == w {
        plane
    } else {
        let spans = spans(w, new_w);
        Plane::from_fn(new_w, h, |x, y| spans[x].mean(|i| plane.row(y as i64)[i]))
    };
    if new_h == h {
        return plane;
    }
    let spans = spans(h, new_h);
    Plane::from_fn(new_w, new_h, |x, y| spans[y].mean(|i| plane.row(i as i64)[x]))
}

/// The texels of a line that one texel of a shorter line covers.
struct Span {
    first: usize,
    /// Covered length of each, from `first` on; in (0, 1].
    cover: Vec<f64>,
}

impl Span {
    fn mean(&self, value: impl Fn(usize) -> f32) -> f32 {
        let sum: f64 = self.cover.iter().enumerate().map(|(i, c)| c * f64::from(value(self.first + i))).sum();
        let total: f64 = self.cover.iter().sum();
        (sum / total) as f32
    }
}

/// The spans of `new` texels over `old > new` texels.
fn spans(old: usize, new: usize) -> Vec<Span> {
    // In units of 1 / new of an old texel all ends are whole numbers, so no rounding loses a sliver.
    (0..new)
        .map(|i| {
            let (start, end) = (i * old, (i + 1) * old);
            let (first, last) = (start / new, (end - 1) / new);
            let cover = (first..=last)
                .map(|t| ((end.min((t + 1) * new) - start.max(t * new)) as f64) / new as f64)
                .collect();
            Span { first, cover }
        })
        .collect()
}

/// Where a sample lies: four texels and how much of each. Made once for all planes of an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tap {
    corners: [usize; 4],
    tx: f32,
    ty: f32,
}

impl Tap {
    /// Bilinear, at texel coordinates `x` in [0, width] and `y` in [0, height], with centres at integer + 0.5, of a
    /// torus.
    #[inline]
    pub(super) fn new(x: f32, y: f32, width: usize, height: usize) -> Self {
        let (x0, x1, tx) = neighbours(x, width);
        let (y0, y1, ty) = neighbours(y, height);
        let corners = [y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1];
        Self { corners, tx, ty }
    }

    /// The value there.
    #[inline]
    pub(super) fn read(&self, texels: &[f32]) -> f32 {
        let [a, b, c, d] = self.corners.map(|i| f64::from(texels[i]));
        let (tx, ty) = (f64::from(self.tx), f64::from(self.ty));
        let (top, bottom) = (a + (b - a) * tx, c + (d - c) * tx);
        // f64 between: f32 differences of a float file's extremes would overflow.
        (top + (bottom - top) * ty) as f32
    }
}

/// The texels before and after a coordinate in [0, count], wrapped, and the place between them in [0, 1].
#[inline]
fn neighbours(x: f32, count: usize) -> (usize, usize, f32) {
    // `x + 0.5` has the whole part of the texel after; it is not negative, so that a cast rounds it down.
    let x = x + 0.5;
    let after = (x as usize).min(count);
    let wrap = |i: usize| if i >= count { i - count } else { i };
    (wrap(after + count - 1), wrap(after), x - after as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_by_a_whole_factor_is_the_block_mean() {
        let p = Plane::from_fn(6, 4, |x, y| (x + 10 * y) as f32);
        let s = shrink(p.clone(), 3, 2);
        for y in 0..2 {
            for x in 0..3 {
                let (i, j) = (2 * x, 2 * y);
                let mean = 0.25 * (p.at(i, j) + p.at(i + 1, j) + p.at(i, j + 1) + p.at(i + 1, j + 1));
                assert_eq!(s.at(x, y), mean);
            }
        }
    }

    #[test]
    fn shrinking_by_a_fraction_weighs_by_covered_area_and_keeps_the_mean() {
        // 5 texels over 2: the middle one is halved.
        let s = shrink(Plane::from_vec(5, 1, vec![1.0, 2.0, 3.0, 4.0, 5.0]), 2, 1);
        assert_eq!(s.data(), &[4.5 / 2.5, 10.5 / 2.5]);
        let p = Plane::from_fn(37, 23, |x, y| ((x * 31 + y * 17) % 29) as f32);
        let mean = |p: &Plane| crate::base::num::mean(p.data());
        assert!((mean(&shrink(p.clone(), 10, 7)) - mean(&p)).abs() < 1e-5);
    }

    #[test]
    fn nothing_is_enlarged_and_nothing_vanishes() {
        let p = Plane::from_fn(3, 2, |x, y| (x + y) as f32);
        assert_eq!(shrink(p.clone(), 100, 2), p);
        assert_eq!(shrink(p.clone(), 0, 0).data(), &[1.5]);
        assert_eq!(shrink(Plane::default(), 3, 3), Plane::default());
    }

    #[test]
    fn a_tap_is_exact_at_centres_and_wraps() {
        let texels = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(Tap::new(1.5, 0.5, 2, 2).read(&texels), 2.0);
        assert_eq!(Tap::new(0.0, 0.5, 2, 2).read(&texels), 1.5);
        assert_eq!(Tap::new(1.0, 1.0, 2, 2).read(&texels), 2.5);
        assert_eq!(Tap::new(0.5, 0.5, 1, 1).read(&[f32::MAX]), f32::MAX);
    }
}
