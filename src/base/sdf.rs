//! Exact signed distances to plane shapes.
//!
//! Every function takes a point relative to the shape's centre and lengths in one common unit (mm in this crate),
//! and returns the distance to the outline in that unit, **negative inside**, as the field writes it. Distances are
//! exact, not bounds, so an offset outline is `d - offset` and a coverage needs no further scaling. x runs across a
//! scale, y along it: pointed shapes have their tips on the y axis.
//!
//! Points up to 1e15 and lengths in [0, 1e15] give finite results; lengths of 0 collapse the shape to a segment or
//! a point. All functions are branch-free arithmetic, so loops over them vectorise.
//!
//! Sources: the construction of each form (fold by the shape's symmetry, then distance to one edge or arc) is that
//! of Inigo Quilez, "2D distance functions"; the algebra here is derived anew, in forms that do not cancel.

use super::num;

/// `|(x, y)|`.
#[inline(always)]
pub fn length(x: f32, y: f32) -> f32 {
    (x * x + y * y).sqrt()
}

/// The point (`x`, `y`) seen from a frame that is turned anticlockwise by the angle of (`cos`, `sin`).
#[inline(always)]
pub fn turn(x: f32, y: f32, cos: f32, sin: f32) -> (f32, f32) {
    (cos * x + sin * y, cos * y - sin * x)
}

/// Part of a texel that a shape covers, from the distance `d` (negative inside) and the width of the edge's ramp.
///
/// A straight edge along a texel side gives the exact area for `width` = the texel. `width` 0 is a hard edge.
#[inline(always)]
pub fn coverage(d: f32, width: f32) -> f32 {
    num::linear_step(-0.5 * width, 0.5 * width, -d)
}

/// Squared distance to the segment from (`ax`, `ay`) to (`bx`, `by`).
#[inline(always)]
fn segment_sq(x: f32, y: f32, ax: f32, ay: f32, bx: f32, by: f32) -> f32 {
    let (ex, ey) = (bx - ax, by - ay);
    let (px, py) = (x - ax, y - ay);
    // A segment of length 0 has t = 0: its first end.
    let t = num::saturate((px * ex + py * ey) / (ex * ex + ey * ey).max(f32::MIN_POSITIVE));
    let (dx, dy) = (px - t * ex, py - t * ey);
    dx * dx + dy * dy
}

/// Disc of radius `r`.
#[inline(always)]
pub fn disc(x: f32, y: f32, r: f32) -> f32 {
    length(x, y) - r
}

/// Ring: all points at most `half_width` from the circle of radius `r`.
#[inline(always)]
pub fn ring(x: f32, y: f32, r: f32, half_width: f32) -> f32 {
    (length(x, y) - r).abs() - half_width
}

/// Rectangle of half sides `hx`, `hy`.
#[inline(always)]
pub fn rectangle(x: f32, y: f32, hx: f32, hy: f32) -> f32 {
    let (dx, dy) = (x.abs() - hx, y.abs() - hy);
    length(dx.max(0.0), dy.max(0.0)) + dx.max(dy).min(0.0)
}

/// Rectangle of half sides `hx`, `hy` (outer), corners rounded with `radius`, limited to the shorter half side.
#[inline(always)]
pub fn rounded_box(x: f32, y: f32, hx: f32, hy: f32, radius: f32) -> f32 {
    let r = radius.min(hx.min(hy)).max(0.0);
    rectangle(x, y, hx - r, hy - r) - r
}

/// Capsule: all points at most `r` from the segment from (0, -`half_length`) to (0, `half_length`).
#[inline(always)]
pub fn capsule(x: f32, y: f32, half_length: f32, r: f32) -> f32 {
    length(x, (y.abs() - half_length).max(0.0)) - r
}

/// Rhombus with corners (±`hx`, 0) and (0, ±`hy`).
#[inline(always)]
pub fn rhombus(x: f32, y: f32, hx: f32, hy: f32) -> f32 {
    let (x, y) = (x.abs(), y.abs());
    let d = segment_sq(x, y, hx, 0.0, 0.0, hy).sqrt();
    // `>=`: a rhombus of no width has no inside.
    let outside = x * hy + y * hx >= hx * hy;
    if outside { d } else { -d }
}

/// Radius of the greatest disc in the rhombus with half diagonals `hx`, `hy`; 0 where one of them is 0.
#[inline(always)]
pub fn rhombus_inradius(hx: f32, hy: f32) -> f32 {
    hx * hy / length(hx, hy).max(f32::MIN_POSITIVE)
}

/// [`rhombus`] whose corners are rounded with `radius`, limited to the greatest inner disc; it stays inside the sharp
/// one and touches its sides.
#[inline(always)]
pub fn rounded_rhombus(x: f32, y: f32, hx: f32, hy: f32, radius: f32) -> f32 {
    let inner = rhombus_inradius(hx, hy);
    let r = radius.min(inner).max(0.0);
    let k = 1.0 - r / inner.max(f32::MIN_POSITIVE);
    rhombus(x, y, hx * k, hy * k) - r
}

/// Convex hexagon or octagon: [`rhombus`] with half diagonals `hx`, `hy`, cut off at |x| = `cut_x` and |y| = `cut_y`.
///
/// A cut beyond its corner cuts nothing; cuts that meet inside the rhombus give the rectangle between them.
/// With `cut_y >= hy` it is the pointed hexagon of a snake's dorsal scale: sides at ±`cut_x`, tips at ±`hy`.
#[inline(always)]
pub fn truncated_rhombus(x: f32, y: f32, hx: f32, hy: f32, cut_x: f32, cut_y: f32) -> f32 {
    let (x, y) = (x.abs(), y.abs());
    let (cx, cy) = (cut_x.min(hx).max(0.0), cut_y.min(hy).max(0.0));
    // Corners of the first quadrant's outline: (cx, 0), (cx, y1), (x2, cy), (0, cy).
    let y1 = (hy * (1.0 - cx / hx.max(f32::MIN_POSITIVE))).min(cy).max(0.0);
    let x2 = (hx * (1.0 - cy / hy.max(f32::MIN_POSITIVE))).min(cx).max(0.0);
    let side = segment_sq(x, y, cx, 0.0, cx, y1);
    let slope = segment_sq(x, y, cx, y1, x2, cy);
    let top = segment_sq(x, y, x2, cy, 0.0, cy);
    // The half plane right of and above the slope, from its two corners.
    let beyond = (x - cx) * (cy - y1) + (y - y1) * (cx - x2);
    let outside = x > cx || y > cy || beyond > 0.0;
    let d = side.min(slope).min(top).sqrt();
    if outside { d } else { -d }
}

/// [`truncated_rhombus`] whose corners are rounded with `radius`, limited to the greatest inner disc; it stays inside
/// the sharp one and touches its sides.
#[inline(always)]
pub fn rounded_truncated_rhombus(
    x: f32,
    y: f32,
    hx: f32,
    hy: f32,
    cut_x: f32,
    cut_y: f32,
    radius: f32,
) -> f32 {
    let inner = rhombus_inradius(hx, hy);
    let r = radius.min(inner).min(cut_x.min(cut_y)).max(0.0);
    let k = 1.0 - r / inner.max(f32::MIN_POSITIVE);
    truncated_rhombus(x, y, hx * k, hy * k, cut_x - r, cut_y - r) - r
}

/// Distance to a regular polygon's side x = `apothem`, for a point folded into that side's sector.
#[inline(always)]
fn sector(x: f32, y: f32, apothem: f32, half_side: f32) -> f32 {
    let dx = x - apothem;
    let d = length(dx, (y.abs() - half_side).max(0.0));
    if dx < 0.0 { dx } else { d }
}

/// Regular hexagon with two sides at x = ±`apothem` and corners on the y axis.
#[inline(always)]
pub fn hexagon(x: f32, y: f32, apothem: f32) -> f32 {
    const COS_30: f32 = 0.866_025_4;
    const TAN_30: f32 = 0.577_350_26;
    let (x, y) = (x.abs(), y.abs());
    // Mirror what lies above the sector's border, the line at 30 degrees, into the sector.
    let along = 2.0 * (x * COS_30 + y * 0.5);
    let above = y > x * TAN_30;
    let (fx, fy) = if above { (along * COS_30 - x, along * 0.5 - y) } else { (x, y) };
    sector(fx, fy, apothem, apothem * TAN_30)
}

/// Regular polygon with `n >= 3` sides (a whole number), the first of them at x = `apothem`.
///
/// `half_angle_tan` is tan(180°/n), from [`polygon_tan`], so that a loop need not compute it again.
#[inline(always)]
pub fn polygon(x: f32, y: f32, n: f32, half_angle_tan: f32, apothem: f32) -> f32 {
    // Turn by whole sectors until the point lies in the first.
    let turns = num::atan2_turns(y, x);
    let back = (turns * n + 0.5).floor() / n;
    let (fx, fy) = turn(x, y, num::cos_turns(back), num::sin_turns(back));
    sector(fx, fy, apothem, apothem * half_angle_tan)
}

/// tan(180°/n), n >= 3.
#[inline(always)]
pub fn polygon_tan(n: f32) -> f32 {
    num::sin_turns(0.5 / n) / num::cos_turns(0.5 / n)
}

/// Any convex polygon, corners in order (either way round); fewer than 3 corners enclose nothing.
///
/// For a handful of corners: the loop is unrolled where the slice's length is known.
#[inline(always)]
pub fn convex_polygon(x: f32, y: f32, corners: &[[f32; 2]]) -> f32 {
    let n = corners.len();
    let (mut d, mut left, mut right) = (f32::MAX, true, true);
    for i in 0..n {
        let ([ax, ay], [bx, by]) = (corners[i], corners[if i + 1 == n { 0 } else { i + 1 }]);
        d = d.min(segment_sq(x, y, ax, ay, bx, by));
        let cross = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
        left &= cross >= 0.0;
        right &= cross <= 0.0;
    }
    let inside = n >= 3 && (left || right);
    if inside { -d.sqrt() } else { d.sqrt() }
}

/// Vesica (leaf): the intersection of two equal circles, tips at (0, ±`hy`), widest at (±`hx`, 0).
///
/// `hx > hy` puts the tips on the x axis; `hx = hy` is a disc.
#[inline(always)]
pub fn vesica(x: f32, y: f32, hx: f32, hy: f32) -> f32 {
    let wide = hx > hy;
    let (x, y) = if wide { (y.abs(), x.abs()) } else { (x.abs(), y.abs()) };
    let h = hx.max(hy);
    // Below this width it is a segment to f32, and the circles' radius would overflow.
    let w = hx.min(hy).max(1e-6 * h).max(1e-18);
    let h = h.max(w);
    // The right arc's circle: centre (-c, 0), radius r = c + w, through (0, h).
    let c = (h - w) * (h + w) / (2.0 * w);
    let r = c + w;
    let tip = length(x, y - h);
    // |p - centre| - r without the cancellation of two large lengths.
    let arc = (x * (x + 2.0 * c) + (y - h) * (y + h)) / (length(x + c, y) + r);
    // Beyond the ray from the circle's centre through the tip, the tip is nearest.
    if c * (y - h) > h * x { tip } else { arc }
}

/// [`vesica`] whose tips are rounded with `radius`, limited to the half width; it stays inside the sharp one and
/// touches its sides.
#[inline(always)]
pub fn rounded_vesica(x: f32, y: f32, hx: f32, hy: f32, radius: f32) -> f32 {
    let (w, h) = (hx.min(hy), hx.max(hy));
    let r = radius.min(w).max(0.0);
    // The same circles with radius R - r meet at height sqrt((R - r)^2 - c^2) = sqrt((w - r)(2c + w - r)).
    let c2 = (h - w) * (h + w) / w.max(f32::MIN_POSITIVE);
    let (w, h) = (w - r, num::safe_sqrt((w - r) * (c2 + w - r)).min(h));
    let (hx, hy) = if hx > hy { (h, w) } else { (w, h) };
    vesica(x, y, hx, hy) - r
}

/// Ellipse with half axes `a` (x) and `b` (y).
///
/// Fixed iteration on the centre of curvature (Chatfield, "Simple method for distance to ellipse", 2017). Largest
/// error, relative to the longer half axis, for axis ratios up to 20: 2.2e-5 (test
/// `ellipse_agrees_with_dense_sampling`). Narrower than a thousandth of its length it counts as a thousandth.
#[inline(always)]
pub fn ellipse(x: f32, y: f32, a: f32, b: f32) -> f32 {
    // Seen from a million times its size an ellipse is a point; the squares below would overflow.
    let unit = a.max(b).max(1e-6 * x.abs().max(y.abs())).max(1e-18);
    // A half axis of 0 would divide by zero; a thousandth looks like a segment.
    let (a, b) = ((a / unit).max(1e-3), (b / unit).max(1e-3));
    let (x, y) = (x.abs() / unit, y.abs() / unit);
    let focus = (a - b) * (a + b);
    let step = |[tx, ty]: [f32; 2]| {
        let (ex, ey) = (focus * tx * tx * tx / a, -focus * ty * ty * ty / b);
        let curvature_radius = length(a * tx - ex, b * ty - ey);
        let (qx, qy) = (x - ex, y - ey);
        let k = curvature_radius / length(qx, qy).max(1e-18);
        let tx = num::saturate((qx * k + ex) / a);
        let ty = num::saturate((qy * k + ey) / b);
        let norm = length(tx, ty).max(1e-18);
        [tx / norm, ty / norm]
    };
    // Written out: a loop within the loop over texels would keep that from becoming lanes.
    let [tx, ty] = step(step(step(step(step(step([0.707_106_77; 2]))))));
    let d = length(x - a * tx, y - b * ty) * unit;
    let (fx, fy) = (x / a, y / b);
    if fx * fx + fy * fy < 1.0 { -d } else { d }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::hash;

    /// A shape to test: its name, distance, area, and the half side of a square that holds it.
    type Case = (&'static str, fn(f32, f32) -> f32, f64, f32);

    fn cases() -> Vec<Case> {
        let pi = std::f64::consts::PI;
        let root3 = 3f64.sqrt();
        // Segment of a circle through the tips of vesica(0.6, 1): R = 17/15, c = 8/15.
        let (r, c) = (17.0 / 15.0, 8.0 / 15.0);
        let leaf = 2.0 * (r * r * (1f64 / r).asin() - c);
        vec![
            ("disc", |x, y| disc(x, y, 0.7), pi * 0.49, 1.0),
            ("ring", |x, y| ring(x, y, 0.6, 0.1), pi * (0.49 - 0.25), 1.0),
            ("rectangle", |x, y| rectangle(x, y, 0.8, 0.3), 0.96, 1.0),
            ("rounded_box", |x, y| rounded_box(x, y, 0.8, 0.5, 0.2), 1.6 - 0.04 * (4.0 - pi), 1.0),
            ("capsule", |x, y| capsule(x, y, 0.5, 0.3), 0.6 + pi * 0.09, 1.0),
            ("rhombus", |x, y| rhombus(x, y, 0.5, 0.9), 0.9, 1.0),
            ("truncated_rhombus", |x, y| truncated_rhombus(x, y, 1.0, 0.8, 0.7, 0.6), 1.6 - 0.144 - 0.1, 1.0),
            ("pointed hexagon", |x, y| truncated_rhombus(x, y, 1.0, 0.8, 0.5, 9.0), 1.2, 1.0),
            ("crossed cuts", |x, y| truncated_rhombus(x, y, 1.0, 1.0, 0.4, 0.3), 0.48, 1.0),
            ("hexagon", |x, y| hexagon(x, y, 0.6), 2.0 * root3 * 0.36, 1.0),
            (
                "polygon 5",
                |x, y| polygon(x, y, 5.0, polygon_tan(5.0), 0.6),
                5.0 * 0.36 * (pi / 5.0).tan(),
                1.0,
            ),
            ("triangle", |x, y| polygon(x, y, 3.0, polygon_tan(3.0), 0.4), 3.0 * 0.16 * root3, 1.0),
            (
                "convex",
                |x, y| convex_polygon(x, y, &[[0.5, 0.0], [0.0, 0.9], [-0.5, 0.0], [0.0, -0.9]]),
                0.9,
                1.0,
            ),
            ("vesica", |x, y| vesica(x, y, 0.6, 1.0), leaf, 1.1),
            ("wide vesica", |x, y| vesica(x, y, 1.0, 0.6), leaf, 1.1),
            ("ellipse", |x, y| ellipse(x, y, 0.9, 0.4), pi * 0.36, 1.0),
        ]
    }

    #[test]
    fn areas_are_those_of_the_closed_forms() {
        for (name, d, area, half) in cases() {
            let n = 500;
            let texel = 2.0 * half / n as f32;
            let at = |i: usize| (i as f32 + 0.5) * texel - half;
            let sum: f64 = (0..n * n).map(|i| f64::from(coverage(d(at(i % n), at(i / n)), texel))).sum();
            let got = sum * f64::from(texel) * f64::from(texel);
            // Linear coverage is off by O(texel^2) per texel of the outline.
            assert!((got - area).abs() < 5e-4, "{name}: {got}, not {area}");
        }
    }

    #[test]
    fn stepping_by_the_distance_along_the_gradient_reaches_the_outline() {
        // True of an exact distance away from its medial axis, and of nothing else.
        for (name, d, _, half) in cases() {
            let (mut tried, mut good) = (0, 0);
            for i in 0..2000 {
                let x = 1.5 * half * hash::signed(hash::hash2(1, i, 0));
                let y = 1.5 * half * hash::signed(hash::hash2(1, i, 1));
                let e = 1e-3;
                let (gx, gy) =
                    ((d(x + e, y) - d(x - e, y)) / (2.0 * e), (d(x, y + e) - d(x, y - e)) / (2.0 * e));
                let dist = d(x, y);
                tried += 1;
                if (length(gx, gy) - 1.0).abs() < 5e-3 && d(x - gx * dist, y - gy * dist).abs() < 4e-3 {
                    good += 1;
                }
            }
            assert!(good as f32 > 0.985 * tried as f32, "{name}: {good} of {tried}");
        }
    }

    #[test]
    fn distances_at_known_points() {
        let near = |a: f32, b: f32| assert!((a - b).abs() < 2e-6, "{a}, not {b}");
        near(disc(3.0, 4.0, 1.0), 4.0);
        near(ring(0.0, 0.0, 1.0, 0.25), 0.75);
        near(rectangle(3.0, 4.0, 0.0, 0.0), 5.0);
        near(rectangle(0.25, 0.0, 1.0, 2.0), -0.75);
        near(rounded_box(2.0, 2.0, 1.0, 1.0, 1.0), 8f32.sqrt() - 1.0);
        near(rhombus(0.0, 0.0, 3.0, 4.0), -2.4);
        near(rhombus(0.0, 6.0, 3.0, 4.0), 2.0);
        near(rounded_rhombus(0.0, 0.0, 3.0, 4.0, 1.0), -2.4);
        near(rounded_rhombus(5.0, 0.0, 3.0, 4.0, 9.0), 5.0 - 2.4);
        near(hexagon(0.0, 2.0, 3f32.sqrt() / 2.0), 1.0);
        near(polygon(-2.0, 0.0, 4.0, polygon_tan(4.0), 1.0), 1.0);
        near(vesica(0.0, 0.0, 0.5, 1.0), -0.5);
        near(vesica(0.0, 1.5, 0.5, 1.0), 0.5);
        near(vesica(1.0, 0.0, 0.5, 1.0), 0.5);
        near(vesica(0.3, 0.4, 1.0, 1.0), -0.5);
        near(rounded_vesica(0.0, 0.0, 0.5, 1.0, 0.2), -0.5);
        near(ellipse(0.0, 3.0, 5.0, 2.0), 1.0);
        near(ellipse(6.0, 0.0, 5.0, 2.0), 1.0);
        near(coverage(0.0, 0.1), 0.5);
        near(coverage(0.025, 0.1), 0.25);
        assert_eq!((coverage(-1e-9, 0.0), coverage(1e-9, 0.0)), (1.0, 0.0));
    }

    #[test]
    fn rounded_shapes_stay_inside_the_sharp_ones_and_touch_them() {
        for i in 0..20_000 {
            let x = 1.2 * hash::signed(hash::hash2(2, i, 0));
            let y = 1.2 * hash::signed(hash::hash2(2, i, 1));
            assert!(rounded_vesica(x, y, 0.5, 1.0, 0.2) >= vesica(x, y, 0.5, 1.0) - 1e-5, "{x} {y}");
            assert!(rounded_rhombus(x, y, 0.5, 1.0, 0.2) >= rhombus(x, y, 0.5, 1.0) - 1e-5, "{x} {y}");
            let (round, sharp) = (
                rounded_truncated_rhombus(x, y, 1.0, 0.8, 0.7, 0.6, 0.2),
                truncated_rhombus(x, y, 1.0, 0.8, 0.7, 0.6),
            );
            assert!(round >= sharp - 1e-5, "{x} {y}");
            assert!(rounded_box(x, y, 0.5, 1.0, 0.2) >= rectangle(x, y, 0.5, 1.0) - 1e-5, "{x} {y}");
        }
        assert!(rounded_vesica(0.5, 0.0, 0.5, 1.0, 0.2).abs() < 1e-6);
        assert!(rounded_rhombus(0.25, 0.5, 0.5, 1.0, 0.2).abs() < 1e-6);
        assert!(rounded_truncated_rhombus(0.5, 0.4, 1.0, 0.8, 0.7, 0.6, 0.1).abs() < 1e-6);
    }

    #[test]
    fn ellipse_agrees_with_dense_sampling() {
        for ratio in [1.0, 2.0, 5.0, 20.0f32] {
            let (a, b) = (1.0, 1.0 / ratio);
            for i in 0..300 {
                let x = 1.5 * hash::signed(hash::hash2(3, i, 0));
                let y = 1.5 * b * hash::signed(hash::hash2(3, i, 1));
                let nearest = (0..40_000)
                    .map(|k| {
                        let t = f64::from(k) / 40_000.0 * std::f64::consts::TAU;
                        (f64::from(x) - t.cos()).hypot(f64::from(y) - f64::from(b) * t.sin())
                    })
                    .fold(f64::MAX, f64::min);
                let got = f64::from(ellipse(x, y, a, b)).abs();
                assert!((got - nearest).abs() < 3e-5, "{ratio} {x} {y}: {got}, not {nearest}");
            }
        }
    }

    #[test]
    fn every_shape_is_finite_at_size_zero_and_far_away() {
        for (x, y) in [(0.0, 0.0), (1e15, -1e15), (1e-40, 1e-40), (0.0, 1e15)] {
            for (a, b) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1e15, 1e15), (1e-30, 1e15), (1e-30, 1e-30)] {
                let all = [
                    disc(x, y, a),
                    ring(x, y, a, b),
                    rounded_box(x, y, a, b, 0.1),
                    capsule(x, y, a, b),
                    rounded_rhombus(x, y, a, b, 0.1),
                    truncated_rhombus(x, y, a, b, 0.5 * a, 0.7 * b),
                    rounded_truncated_rhombus(x, y, a, b, 0.5 * a, 0.7 * b, 0.1),
                    hexagon(x, y, a),
                    polygon(x, y, 7.0, polygon_tan(7.0), a),
                    rounded_vesica(x, y, a, b, 0.1),
                    ellipse(x, y, a, b),
                ];
                assert!(all.iter().all(|d| d.is_finite()), "{x} {y} {a} {b}: {all:?}");
            }
        }
    }
}
