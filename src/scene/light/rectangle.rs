//! Rectangles of light, as seen from points on the side to which they shine.

use glam::{DVec3, Vec3};

use super::{LightHit, LightSample};
use crate::base::LinearRgb;

/// A rectangle that shines, with all that does not depend on where it is seen from. In f64: a solid angle is a difference.
///
/// Source: Urena, Fajardo & King, "An area-preserving parametrization for spherical rectangles", Computer Graphics
/// Forum 32(4), 2013; their angles between edge planes are here the arc tangents of the classical formula of the solid
/// angle, which keep their digits at grazing views. The two of one edge are the argument of one complex number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    center: DVec3,
    /// Unit axes of the rectangle, and the one from its shining side into it.
    axes: [DVec3; 3],
    /// Half of its sides.
    half: [f64; 2],
}

/// What a point sees of a rectangle.
#[derive(Clone, Copy)]
struct Seen<'a> {
    rectangle: &'a Rectangle,
    /// Distance of its plane.
    height: f64,
    /// Its edges along the first axis, then along the second, from the foot of the point.
    x: [f64; 2],
    y: [f64; 2],
    /// Solid angle over `2 pi` sr. 0 where it is to be sampled by area.
    solid_angle: f64,
    /// What the edge at `x[0]` gives of it.
    first: f64,
}

/// Below this solid angle, sr, as its middle gives it, a rectangle is sampled by area: over so little of the sky the density
/// hardly varies.
const SMALL: f64 = 0.02;

/// The formulas lose their digits below this solid angle, sr.
const LEAST: f64 = 1e-6;

const TURN: f64 = 2.0 * std::f64::consts::PI;

impl Rectangle {
    /// From its middle to the middles of two edges; `None` if it has no area.
    #[inline(always)]
    pub(crate) fn new(center: Vec3, u: Vec3, v: Vec3) -> Option<Self> {
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        let x_axis = u.try_normalize()?;
        // Square even if the author's vectors are a rounding away from it.
        let y_axis = (v - x_axis * v.dot(x_axis)).try_normalize()?;
        Some(Self {
            center: center.as_dvec3(),
            axes: [x_axis, y_axis, y_axis.cross(x_axis)],
            half: [u.length(), v.dot(y_axis)],
        })
    }

    /// [`Light::sample`](super::Light::sample) of one of this radiance.
    #[inline(always)]
    pub(crate) fn sample(&self, point: Vec3, radiance: LinearRgb, u: [f32; 2]) -> Option<LightSample> {
        let seen = self.seen(point)?;
        let to = seen.sample(u);
        let distance = to.length();
        (distance > 0.0).then(|| LightSample {
            direction: to / distance,
            distance,
            radiance,
            pdf: seen.pdf(to),
            delta: false,
        })
    }

    /// [`Light::hit`](super::Light::hit) of one of this radiance.
    pub(crate) fn hit(&self, origin: Vec3, direction: Vec3, radiance: LinearRgb) -> Option<LightHit> {
        let seen = self.seen(origin)?;
        let to = seen.hit(direction)?;
        Some(LightHit { distance: to.length(), radiance, pdf: seen.pdf(to) })
    }

    /// What a point sees; `None` if only its back or its edge.
    #[inline(always)]
    fn seen(&self, point: Vec3) -> Option<Seen<'_>> {
        let to = self.center - point.as_dvec3();
        let [cx, cy, height] = self.axes.map(|axis| to.dot(axis));
        if height.is_nan() || height <= 0.0 {
            return None;
        }
        let [a, b] = self.half;
        let (x, y) = ([cx - a, cx + a], [cy - b, cy + b]);
        let mut seen = Seen { rectangle: self, height, x, y, solid_angle: 0.0, first: 0.0 };
        let away = to.length_squared();
        // By its square: a root is saved.
        let near = 4.0 * a * b * height;
        if near * near < SMALL * SMALL * (away * away * away) && away > 4.0 * (a * a + b * b) {
            return Some(seen);
        }
        let edge = |x: f64| {
            let planar = x * x + height * height;
            let [s0, s1] = y.map(|y| (planar + y * y).sqrt());
            // (h s1 + i x y1) (h s0 - i x y0)
            turns(height * x * (y[1] * s0 - y[0] * s1), height * height * s1 * s0 + x * x * (y[1] * y[0]))
        };
        seen.first = edge(x[0]);
        seen.solid_angle = edge(x[1]) - seen.first;
        Some(seen)
    }
}

impl Seen<'_> {
    /// The vector from the point to a place on the rectangle, by two uniform numbers.
    #[inline(always)]
    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let [u, v] = u.map(f64::from);
        let ([x0, x1], [y0, y1], h) = (self.x, self.y, self.height);
        let (x, y) = if self.solid_angle * TURN < LEAST {
            (x0 + (x1 - x0) * u, y0 + (y1 - y0) * v)
        } else {
            // The strip from x0 to x has u of the solid angle.
            let phi = u * self.solid_angle + self.first + 0.5;
            let (b0, b1) = (-y0 / (y0 * y0 + h * h).sqrt(), y1 / (y1 * y1 + h * h).sqrt());
            let f = (sine(phi + 0.25) * b0 - b1) / sine(phi);
            let c = (1.0 / (f * f + b0 * b0).sqrt()).min(1.0);
            let x = (h * c / ((1.0 - c) * (1.0 + c)).sqrt()).copysign(f).max(x0).min(x1);
            // And in it the height is uniform in the sine.
            let d2 = x * x + h * h;
            let (s0, s1) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
            let s = s0 + v * (s1 - s0);
            (x, (s * (d2 / ((1.0 - s) * (1.0 + s))).sqrt()).max(y0).min(y1))
        };
        let [x_axis, y_axis, away] = self.rectangle.axes;
        (x_axis * x + y_axis * y + away * h).as_vec3()
    }

    /// Where a ray from the point meets the rectangle, from the point.
    fn hit(&self, direction: Vec3) -> Option<Vec3> {
        let d = direction.as_dvec3();
        let [x_axis, y_axis, away] = self.rectangle.axes;
        let t = self.height / d.dot(away);
        let (x, y) = (t * d.dot(x_axis), t * d.dot(y_axis));
        let inside = t > 0.0 && x >= self.x[0] && x <= self.x[1] && y >= self.y[0] && y <= self.y[1];
        inside.then(|| (d * t).as_vec3())
    }

    /// The density of [`Self::sample`] at the place that `to` leads to, per solid angle.
    #[inline(always)]
    fn pdf(&self, to: Vec3) -> f32 {
        let solid_angle = self.solid_angle * TURN;
        if solid_angle >= LEAST {
            return (1.0 / solid_angle) as f32;
        }
        let [a, b] = self.rectangle.half;
        let r2 = to.as_dvec3().length_squared();
        (r2 * r2.sqrt() / (4.0 * a * b * self.height)) as f32
    }
}

/// The argument of `x + i y`, turns, in [-1/2, 1/2], within 1e-13.
#[inline(always)]
fn turns(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let (low, high) = (ax.min(ay), ax.max(ay).max(f64::MIN_POSITIVE));
    // atan(t) = pi/4 + atan((t - 1)/(t + 1)), where t = low/high is above tan(pi/8).
    let far = low > 0.414_213_562_373_095 * high;
    let z = if far { low - high } else { low } / if far { low + high } else { high };
    let s = z * z;
    // Chebyshev's polynomial of atan(z)/z up to tan(pi/8).
    let p = -0.037_652_957_355_642_57;
    let p = p * s + 0.069_740_745_865_864_36;
    let p = p * s - 0.089_925_251_315_493_9;
    let p = p * s + 0.111_034_537_869_097_31;
    let p = p * s - 0.142_853_863_721_250_56;
    let p = p * s + 0.199_999_930_484_542_5;
    let p = p * s - 0.333_333_332_768_674_4;
    let p = p * s + 0.999_999_999_999_243_8;
    let a = z * p * (1.0 / TURN) + if far { 0.125 } else { 0.0 };
    let a = if ay > ax { 0.25 - a } else { a };
    let a = if x < 0.0 { 0.5 - a } else { a };
    a.copysign(y)
}

/// `sin(2 pi t)` for t in [-1/2, 3/2] turns, within 1e-13.
#[inline(always)]
fn sine(t: f64) -> f64 {
    // Once around, then into [-1/4, 1/4]: sin(pi - a) = sin(a).
    let t = if t > 0.5 { t - 1.0 } else { t };
    let t = if t > 0.25 { 0.5 - t } else { t };
    let t = if t < -0.25 { -0.5 - t } else { t };
    let a = t * TURN;
    let s = a * a;
    // Chebyshev's polynomial of sin(a)/a up to pi/2.
    let p = 1.541_131_029_415_144e-10;
    let p = p * s - 2.503_027_532_765_773_3e-8;
    let p = p * s + 2.755_695_312_526_354_4e-6;
    let p = p * s - 1.984_126_668_608_186e-4;
    let p = p * s + 8.333_333_320_377_336e-3;
    let p = p * s - 0.166_666_666_664_671_42;
    a * (p * s + 0.999_999_999_999_949_8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_sines_are_those_of_libm() {
        for i in -4000..=12_000 {
            let t = f64::from(i) / 8000.0;
            let (sin, cos) = libm::sincos(t * TURN);
            assert!((sine(t) - sin).abs() < 2e-13, "{t}");
            let there = libm::atan2(sin, cos) / TURN;
            let apart = (turns(3.0 * sin, 3.0 * cos) - there).abs();
            assert!(apart < 1e-13 || (apart - 1.0).abs() < 1e-13, "{t} {apart}");
        }
        assert_eq!(turns(0.0, 0.0), 0.0);
    }

    /// The solid angle of a rectangle from above its middle has a closed form: `4 asin(ab/sqrt((a^2+h^2)(b^2+h^2)))`.
    #[test]
    fn the_solid_angle_is_that_of_the_closed_form() {
        for (a, b, h) in [(1.0, 1.0, 1.0), (0.5, 2.0, 0.01), (30.0, 20.0, 1e-3), (0.2, 0.1, 0.3)] {
            let center = Vec3::new(0.0, h, 0.0);
            let rectangle = Rectangle::new(center, Vec3::X * a, Vec3::Z * b).expect("an area");
            let seen = rectangle.seen(Vec3::ZERO).expect("its shining side");
            let [a, b, h] = [a, b, h].map(f64::from);
            let exact = 4.0 * libm::asin(a * b / ((a * a + h * h) * (b * b + h * h)).sqrt());
            assert!((seen.solid_angle * TURN / exact - 1.0).abs() < 1e-10, "{a} {b} {h}");
            assert!(rectangle.seen(2.0 * center).is_none() && rectangle.seen(Vec3::NAN).is_none());
        }
        assert!(Rectangle::new(Vec3::Y, Vec3::X, Vec3::ZERO).is_none());
    }
}
