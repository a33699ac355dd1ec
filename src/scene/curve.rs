//! A smooth centre line with a frame that knows which way is up.

use glam::DVec3;

/// Samples that the spline is built on: 12 to the body diameter of a long coil.
const SAMPLES: usize = 768;
/// Length over which the frame may lag behind the direction of up, scene units.
const RELAXATION: f64 = 0.4;

/// A curve of class C2 by its arc length: a uniform cubic B-spline through points at equal distances.
///
/// Speed is 1 within 1e-4 for curves that bend no more sharply than a snake. Lengths in scene units.
#[derive(Clone, Debug)]
pub struct Curve {
    length: f64,
    positions: Vec<DVec3>,
    ups: Vec<DVec3>,
}

/// Where the curve is, and which way it looks, at one arc length.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Place.
    pub position: DVec3,
    /// Unit tangent, along growing arc length: tail-ward.
    pub tangent: DVec3,
    /// Unit normal away from the belly.
    pub up: DVec3,
    /// `up x tangent`: the right side of an animal that faces against the tangent.
    pub right: DVec3,
    /// How fast the tangent turns towards `up`, 1/length.
    pub bend_up: f64,
    /// How fast the tangent turns towards `right`, 1/length.
    pub bend_right: f64,
    /// How fast `right` turns towards `up`, 1/length.
    pub twist: f64,
}

impl Curve {
    /// The curve through `points`, cut at `length` or at the last point, whichever comes first.
    ///
    /// `None` if there are fewer than two distinct points or one is not finite. Up is +y as far as the tangent allows:
    /// the frame that rotates least (Wang, Juettler, Zheng & Liu 2008, double reflection) is turned towards it, weakly
    /// where the curve is steep and not at all where it is vertical.
    pub fn through(points: &[DVec3], length: f64) -> Option<Self> {
        if !points.iter().all(|p| p.is_finite()) {
            return None;
        }
        let distances = cumulative(points);
        let length = length.min(*distances.last()?);
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let step = length / (SAMPLES - 1) as f64;
        let mut segment = 0;
        let even: Vec<DVec3> = (0..SAMPLES)
            .map(|i| {
                let s = (i as f64 * step).min(length);
                while segment + 2 < points.len() && distances[segment + 1] < s {
                    segment += 1;
                }
                catmull_rom(points, &distances, segment, s)
            })
            .collect();
        let ups = ups(&even, step);
        // Chords are shorter than arcs: measure again what the resampled curve is long.
        let length = length.max(*cumulative(&even).last()?);
        Some(Self { length, positions: interpolating(&even), ups: interpolating(&ups) })
    }

    /// Arc length.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The frame at arc length `s`, which is limited to the curve.
    pub fn at(&self, s: f64) -> Frame {
        let rate = (SAMPLES - 1) as f64 / self.length;
        let [position, velocity, acceleration] = evaluate(&self.positions, s * rate, rate);
        let [raw_up, raw_up_rate, _] = evaluate(&self.ups, s * rate, rate);
        let speed = velocity.length().max(1e-300);
        let tangent = velocity / speed;
        let bend = (acceleration - tangent * acceleration.dot(tangent)) / (speed * speed);
        let across = raw_up - tangent * raw_up.dot(tangent);
        let up = across / across.length().max(1e-300);
        let right = up.cross(tangent);
        let turn = (raw_up_rate / speed).dot(right) - raw_up.dot(tangent) * bend.dot(right);
        Frame {
            position,
            tangent,
            up,
            right,
            bend_up: bend.dot(up),
            bend_right: bend.dot(right),
            twist: -turn / across.length().max(1e-300),
        }
    }
}

/// Distance from the first point to each, along the chords.
pub(super) fn cumulative(points: &[DVec3]) -> Vec<f64> {
    let mut total = 0.0;
    let first = points.first().map(|_| 0.0);
    let rest = points.windows(2).map(|pair| {
        total += pair[0].distance(pair[1]);
        total
    });
    first.into_iter().chain(rest).collect()
}

/// The point at distance `s` on a Catmull-Rom spline over its own chord lengths.
fn catmull_rom(points: &[DVec3], distances: &[f64], segment: usize, s: f64) -> DVec3 {
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(points.len() - 1));
        (points[b] - points[a]) / (distances[b] - distances[a]).max(1e-300)
    };
    let width = distances[segment + 1] - distances[segment];
    let t = ((s - distances[segment]) / width.max(1e-300)).min(1.0);
    let (p, q) = (points[segment], points[segment + 1]);
    let (m, n) = (slope(segment) * width, slope(segment + 1) * width);
    let rest = q - p;
    p + (m + (rest * 3.0 - m * 2.0 - n + (m + n - rest * 2.0) * t) * t) * t
}

/// Control points whose uniform cubic B-spline passes the points within the fourth power of their distance: each less a
/// sixth of the second difference. The ends are continued straight.
fn interpolating(points: &[DVec3]) -> Vec<DVec3> {
    let last = points.len() - 1;
    let inner = |i: usize| {
        let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(last)]);
        if i == 0 || i == last { points[i] } else { points[i] - (a - points[i] * 2.0 + b) / 6.0 }
    };
    let mut control: Vec<DVec3> = (0..=last).map(inner).collect();
    control.insert(0, control[0] * 2.0 - control[1]);
    control.push(control[last + 1] * 2.0 - control[last]);
    control
}

/// Value, first and second derivative of a uniform cubic B-spline at `x` samples, with `rate` samples to the unit.
fn evaluate(control: &[DVec3], x: f64, rate: f64) -> [DVec3; 3] {
    let segments = control.len() - 3;
    let x = x.max(0.0).min(segments as f64);
    let i = (x as usize).min(segments - 1);
    let t = x - i as f64;
    let [a, b, c, d] = [control[i], control[i + 1], control[i + 2], control[i + 3]];
    let (r, t2) = (1.0 - t, t * t);
    let value = (a * (r * r * r)
        + b * (4.0 - 6.0 * t2 + 3.0 * t2 * t)
        + c * (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t2 * t)
        + d * (t2 * t))
        / 6.0;
    let first = ((b - a) * (r * r) + (c - b) * (1.0 + 2.0 * t - 2.0 * t2) + (d - c) * t2) * (0.5 * rate);
    let second = ((a - b * 2.0 + c) * r + (b - c * 2.0 + d) * t) * (rate * rate);
    [value, first, second]
}

/// Unit normals of the polyline: of least rotation, then turned towards +y.
fn ups(points: &[DVec3], step: f64) -> Vec<DVec3> {
    let last = points.len() - 1;
    let tangents: Vec<DVec3> = (0..=last)
        .map(|i| (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalize_or_zero())
        .collect();
    let mut normal = across(DVec3::Y, tangents[0]).unwrap_or_else(|| tangents[0].any_orthonormal_vector());
    let mut normals = vec![normal];
    for i in 0..last {
        normal = transported(points[i + 1] - points[i], tangents[i], tangents[i + 1], normal);
        normals.push(normal);
    }
    // Up in the moving plane, as a vector of two numbers, short where the curve is steep; smoothed along the curve, so
    // that where up has no direction its neighbours give it one.
    let targets: Vec<[f64; 2]> =
        (0..=last).map(|i| [DVec3::Y.dot(normals[i]), DVec3::Y.dot(tangents[i].cross(normals[i]))]).collect();
    let smooth = relaxed(&targets, (RELAXATION / step) * (RELAXATION / step));
    (0..=last)
        .map(|i| {
            let turned = normals[i] * smooth[i][0] + tangents[i].cross(normals[i]) * smooth[i][1];
            turned.try_normalize().unwrap_or(normals[i])
        })
        .collect()
}

/// The part of `v` square to `tangent`, of unit length.
fn across(v: DVec3, tangent: DVec3) -> Option<DVec3> {
    let part = v - tangent * v.dot(tangent);
    (part.length_squared() > 1e-6).then(|| part.normalize())
}

/// A normal carried one step without rotation about the tangent: reflected twice (Wang et al. 2008, table I).
fn transported(step: DVec3, tangent: DVec3, next: DVec3, normal: DVec3) -> DVec3 {
    let reflected = |v: DVec3, axis: DVec3| {
        let square = axis.length_squared();
        if square > 1e-24 { v - axis * (2.0 * axis.dot(v) / square) } else { v }
    };
    let (half, left) = (reflected(normal, step), reflected(tangent, step));
    across(reflected(half, next - left), next).unwrap_or(normal)
}

/// Minimises `sum |x - target|^2 + stiffness sum |x[i + 1] - x[i]|^2`: a tridiagonal system, by Thomas's algorithm.
fn relaxed(targets: &[[f64; 2]], stiffness: f64) -> Vec<[f64; 2]> {
    let last = targets.len() - 1;
    let mut upper = vec![0.0; targets.len()];
    let mut out = targets.to_vec();
    for i in 0..=last {
        let neighbours = f64::from(u8::from(i > 0) + u8::from(i < last));
        let (carry, before) = if i > 0 { (upper[i - 1], out[i - 1]) } else { (0.0, [0.0; 2]) };
        let pivot = 1.0 + neighbours * stiffness + if i > 0 { stiffness * carry } else { 0.0 };
        upper[i] = -stiffness / pivot;
        for k in 0..2 {
            out[i][k] = (targets[i][k] + stiffness * before[k]) / pivot;
        }
    }
    for i in (0..last).rev() {
        for k in 0..2 {
            out[i][k] -= upper[i] * out[i + 1][k];
        }
    }
    out
}
