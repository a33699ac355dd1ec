//! Lights that have a place or a direction. The environment is apart: see [`super::environment`].

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use crate::base::{LinearRgb, num};

/// A light. Radiance is relative to D65: white (1, 1, 1) has that illuminant's spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From far away, like the sun.
    Directional {
        /// Unit vector towards the light.
        direction: Vec3,
        /// Irradiance on a surface that faces it.
        irradiance: LinearRgb,
        /// Half the angle that it fills, radians, in [0, pi/2]; 0 is a point, the sun has 0.00465.
        angular_radius_rad: f32,
    },
    /// A rectangle that shines to the side of `u x v`.
    Area {
        /// Its middle.
        center: Vec3,
        /// From the middle to the middle of one edge.
        u: Vec3,
        /// From the middle to the middle of the next; square to `u`.
        v: Vec3,
        /// Radiance, the same in all directions.
        radiance: LinearRgb,
    },
}

/// A direction in which light comes. What it adds to a surface is `f cos radiance / pdf`, also for a delta light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Distance to it; infinite for a directional light.
    pub distance: f32,
    /// Radiance; for a delta light, irradiance on a surface that faces it.
    pub radiance: LinearRgb,
    /// Probability density per solid angle; 1 for a delta light.
    pub pdf: f32,
    /// Whether it is a point that no other sampling can find.
    pub delta: bool,
}

/// A light that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightHit {
    /// Distance; infinite for a directional light.
    pub distance: f32,
    /// Radiance.
    pub radiance: LinearRgb,
    /// The density with which [`Light::sample`] chooses this direction from the ray's origin, per solid angle.
    pub pdf: f32,
}

impl Light {
    /// A direction towards the light as seen from `point`; `u` is uniform in the unit square. `None` where it shines
    /// not at all.
    ///
    /// A disk is sampled uniformly over its solid angle, and so is a rectangle.
    pub fn sample(&self, point: Vec3, u: [f32; 2]) -> Option<LightSample> {
        match *self {
            Self::Directional { direction, irradiance, angular_radius_rad } => {
                let disk = Disk::new(angular_radius_rad);
                if disk.height <= 0.0 {
                    let distance = f32::INFINITY;
                    return Some(LightSample {
                        direction,
                        distance,
                        radiance: irradiance,
                        pdf: 1.0,
                        delta: true,
                    });
                }
                // Height below the top of the unit sphere: no cancellation, however small the disk.
                let h = u[0] * disk.height;
                let radius = num::safe_sqrt(h * (2.0 - h));
                let (x, y) = direction.any_orthonormal_pair();
                let around = x * num::cos_turns(u[1]) + y * num::sin_turns(u[1]);
                Some(LightSample {
                    direction: (direction * (1.0 - h) + around * radius).normalize(),
                    distance: f32::INFINITY,
                    radiance: disk.radiance(irradiance),
                    pdf: disk.pdf(),
                    delta: false,
                })
            }
            Self::Area { center, u: half_u, v: half_v, radiance } => {
                let seen = SeenRectangle::new(point, center, half_u, half_v)?;
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
        }
    }

    /// What a ray meets of the light, and the density of [`Light::sample`] for its direction. A delta light is met by
    /// none. `direction` is a unit vector.
    pub fn hit(&self, origin: Vec3, direction: Vec3) -> Option<LightHit> {
        match *self {
            Self::Directional { direction: towards, irradiance, angular_radius_rad } => {
                let disk = Disk::new(angular_radius_rad);
                // The chord: |a - b|^2 = 2 (1 - cos).
                let inside = disk.height > 0.0 && (direction - towards).length_squared() <= 2.0 * disk.height;
                inside.then(|| LightHit {
                    distance: f32::INFINITY,
                    radiance: disk.radiance(irradiance),
                    pdf: disk.pdf(),
                })
            }
            Self::Area { center, u, v, radiance } => {
                let seen = SeenRectangle::new(origin, center, u, v)?;
                let to = seen.hit(direction)?;
                Some(LightHit { distance: to.length(), radiance, pdf: seen.pdf(to) })
            }
        }
    }

    /// A measure of how much light it sends, to choose among lights: irradiance, or the flux of a rectangle.
    pub fn power(&self) -> f32 {
        match self {
            Self::Directional { irradiance, .. } => irradiance.luminance(),
            Self::Area { u, v, radiance, .. } => radiance.luminance() * PI * 4.0 * u.cross(*v).length(),
        }
    }
}

/// A disk on the sky.
#[derive(Clone, Copy)]
struct Disk {
    /// 1 - cos of its angular radius.
    height: f32,
}

impl Disk {
    fn new(angular_radius_rad: f32) -> Self {
        let half_sin = num::sin_turns(angular_radius_rad.max(0.0).min(0.5 * PI) * (0.25 / PI));
        Self { height: 2.0 * half_sin * half_sin }
    }

    fn pdf(self) -> f32 {
        1.0 / (2.0 * PI * self.height)
    }

    /// A disk of radiance L gives a surface that faces it `pi sin^2 L`.
    fn radiance(self, irradiance: LinearRgb) -> LinearRgb {
        let scale = 1.0 / (PI * self.height * (2.0 - self.height));
        LinearRgb(irradiance.0.map(|e| e * scale))
    }
}

/// A rectangle as seen from a point on the side to which it shines. In f64: the solid angle is a difference.
///
/// Source: Urena, Fajardo & King, "An area-preserving parametrization for spherical rectangles", Computer Graphics
/// Forum 32(4), 2013; their angles between edge planes are here the four arc tangents of the classical formula of the
/// solid angle, which keep their digits at grazing views.
struct SeenRectangle {
    /// Unit axes of the rectangle, and the one from the point straight to its plane.
    axes: [DVec3; 3],
    /// Distance of its plane.
    height: f64,
    /// Its edges along the first axis, then along the second, from the foot of the point.
    x: [f64; 2],
    y: [f64; 2],
    /// 0 where it is to be sampled by area.
    solid_angle: f64,
    /// `area_angle(x0, y1) - area_angle(x0, y0)`.
    first: f64,
}

/// Below this solid angle, as its middle gives it, a rectangle is sampled by area: over so little of the sky the density
/// hardly varies, and four arc tangents are saved.
const SMALL: f64 = 0.02;

/// The formulas lose their digits below this solid angle.
const LEAST: f64 = 1e-6;

impl SeenRectangle {
    /// `None` where the point sees only its back or its edge, or where it has no area.
    fn new(point: Vec3, center: Vec3, u: Vec3, v: Vec3) -> Option<Self> {
        let (u, v) = (u.as_dvec3(), v.as_dvec3());
        let to = center.as_dvec3() - point.as_dvec3();
        let x_axis = u.try_normalize()?;
        // Square even if the author's vectors are a rounding away from it.
        let y_axis = (v - x_axis * v.dot(x_axis)).try_normalize()?;
        let away = y_axis.cross(x_axis);
        let height = to.dot(away);
        if height.is_nan() || height <= 0.0 {
            return None;
        }
        let (a, b) = (u.length(), v.dot(y_axis));
        let (cx, cy) = (to.dot(x_axis), to.dot(y_axis));
        let (x, y) = ([cx - a, cx + a], [cy - b, cy + b]);
        let near = 4.0 * a * b * height / (to.length_squared() * to.length());
        if near < SMALL && to.length_squared() > 4.0 * (a * a + b * b) {
            return Some(Self { axes: [x_axis, y_axis, away], height, x, y, solid_angle: 0.0, first: 0.0 });
        }
        let angle = |x: f64, y: f64| libm::atan2(x * y, height * (x * x + y * y + height * height).sqrt());
        let first = angle(x[0], y[1]) - angle(x[0], y[0]);
        let solid_angle = angle(x[1], y[1]) - angle(x[1], y[0]) - first;
        Some(Self { axes: [x_axis, y_axis, away], height, x, y, solid_angle, first })
    }

    /// The vector from the point to a place on the rectangle.
    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let [u, v] = u.map(f64::from);
        let ([x0, x1], [y0, y1], h) = (self.x, self.y, self.height);
        let (x, y) = if self.solid_angle < LEAST {
            (x0 + (x1 - x0) * u, y0 + (y1 - y0) * v)
        } else {
            // The strip from x0 to x has u of the solid angle.
            let phi = u * self.solid_angle + self.first + std::f64::consts::PI;
            let (b0, b1) = (-y0 / (y0 * y0 + h * h).sqrt(), y1 / (y1 * y1 + h * h).sqrt());
            let f = (libm::cos(phi) * b0 - b1) / libm::sin(phi);
            let c = (1.0 / (f * f + b0 * b0).sqrt()).min(1.0);
            let x = (h * c / ((1.0 - c) * (1.0 + c)).sqrt()).copysign(f).max(x0).min(x1);
            // And in it the height is uniform in the sine.
            let d2 = x * x + h * h;
            let (s0, s1) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
            let s = s0 + v * (s1 - s0);
            (x, (s * (d2 / ((1.0 - s) * (1.0 + s))).sqrt()).max(y0).min(y1))
        };
        let [x_axis, y_axis, away] = self.axes;
        (x_axis * x + y_axis * y + away * h).as_vec3()
    }

    /// Where a ray from the point meets the rectangle, from the point.
    fn hit(&self, direction: Vec3) -> Option<Vec3> {
        let d = direction.as_dvec3();
        let [x_axis, y_axis, away] = self.axes;
        let t = self.height / d.dot(away);
        let (x, y) = (t * d.dot(x_axis), t * d.dot(y_axis));
        let inside = t > 0.0 && x >= self.x[0] && x <= self.x[1] && y >= self.y[0] && y <= self.y[1];
        inside.then(|| (d * t).as_vec3())
    }

    /// The density of [`Self::sample`] at the place that `to` leads to, per solid angle.
    fn pdf(&self, to: Vec3) -> f32 {
        if self.solid_angle >= LEAST {
            return (1.0 / self.solid_angle) as f32;
        }
        let area = (self.x[1] - self.x[0]) * (self.y[1] - self.y[0]);
        let r2 = to.as_dvec3().length_squared();
        (r2 * r2.sqrt() / (area * self.height)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: LinearRgb = LinearRgb([1.0, 0.5, 0.25]);

    fn grid(n: usize) -> impl Iterator<Item = [f32; 2]> {
        (0..n * n).map(move |i| [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32))
    }

    /// Mean of `f(sample) / pdf` over a grid: the integral of f over the light's directions.
    fn integral(light: &Light, point: Vec3, f: impl Fn(&LightSample) -> f32) -> f64 {
        let n = 256;
        let sum: f64 =
            grid(n).filter_map(|u| light.sample(point, u)).map(|s| f64::from(f(&s)) / f64::from(s.pdf)).sum();
        sum / (n * n) as f64
    }

    #[test]
    fn a_disk_gives_its_irradiance_at_any_size() {
        for angular_radius_rad in [1e-4, 0.00465, 0.3, 0.5 * PI] {
            let direction = Vec3::new(0.3, 0.8, -0.2).normalize();
            let light = Light::Directional { direction, irradiance: WHITE, angular_radius_rad };
            let e = integral(&light, Vec3::ZERO, |s| s.radiance.0[0] * s.direction.dot(direction));
            assert!((e - 1.0).abs() < 1e-4, "{angular_radius_rad}: {e}");
            let solid_angle = integral(&light, Vec3::ZERO, |_| 1.0);
            let expected = 4.0 * std::f64::consts::PI * (0.5 * f64::from(angular_radius_rad)).sin().powi(2);
            assert!((solid_angle / expected - 1.0).abs() < 1e-4, "{solid_angle} {expected}");
            for u in grid(9) {
                let s = light.sample(Vec3::ZERO, u).expect("it shines everywhere");
                let hit = light.hit(Vec3::ZERO, s.direction).expect("sampled directions are met");
                assert_eq!((hit.pdf, hit.radiance), (s.pdf, s.radiance));
            }
            assert_eq!(light.hit(Vec3::ZERO, -direction), None);
        }
    }

    #[test]
    fn a_point_is_a_delta_that_no_ray_meets() {
        let light = Light::Directional { direction: Vec3::Y, irradiance: WHITE, angular_radius_rad: 0.0 };
        let s = light.sample(Vec3::ONE, [0.3, 0.4]).expect("it shines everywhere");
        assert!(s.delta && s.pdf == 1.0 && s.direction == Vec3::Y && s.radiance == WHITE);
        assert_eq!(light.hit(Vec3::ONE, Vec3::Y), None);
    }

    fn rectangle() -> Light {
        Light::Area {
            center: Vec3::new(0.0, 2.0, 0.0),
            u: Vec3::new(1.0, 0.0, 0.0),
            v: Vec3::new(0.0, 0.0, 0.5),
            radiance: WHITE,
        }
    }

    /// Irradiance and solid angle by brute force over the rectangle's area.
    fn by_area(point: Vec3, normal: Vec3) -> (f64, f64) {
        let n = 400;
        let (mut e, mut omega) = (0.0, 0.0);
        for u in grid(n) {
            let to = Vec3::new(2.0 * u[0] - 1.0, 2.0, u[1] - 0.5) - point;
            let d = to.normalize();
            // It shines along u x v = -y.
            let w = f64::from(d.y.max(0.0)) / f64::from(to.length_squared()) * 2.0 / (n * n) as f64;
            omega += w;
            e += w * f64::from(d.dot(normal).max(0.0));
        }
        (e, omega)
    }

    #[test]
    fn a_rectangle_is_sampled_by_solid_angle_without_bias() {
        for point in
            [Vec3::ZERO, Vec3::new(0.9, 1.7, 0.1), Vec3::new(3.0, -1.0, 2.0), Vec3::new(0.0, 1.2, 4.0)]
        {
            let light = rectangle();
            let normal = Vec3::new(0.2, 0.9, -0.1).normalize();
            let (e, omega) = by_area(point, normal);
            let sampled = integral(&light, point, |s| s.direction.dot(normal).max(0.0));
            assert!((sampled / e - 1.0).abs() < 2e-3, "{point}: {sampled} for {e}");
            let solid_angle = integral(&light, point, |_| 1.0);
            assert!((solid_angle / omega - 1.0).abs() < 2e-3, "{point}: {solid_angle} for {omega}");
            let pdf = light.sample(point, [0.1, 0.8]).expect("in front").pdf;
            for u in grid(7) {
                let s = light.sample(point, u).expect("in front");
                let hit = light.hit(point, s.direction).expect("sampled directions are met");
                let near = |a: f32, b: f32, tolerance: f32| (a / b - 1.0).abs() < tolerance;
                assert!(near(hit.distance, s.distance, 1e-5) && near(hit.pdf, s.pdf, 1e-5));
                // The same everywhere, or nearly so where the rectangle is small.
                assert!(near(s.pdf, pdf, if omega > 0.02 { 1e-6 } else { 0.5 }), "{point} {} {pdf}", s.pdf);
            }
        }
    }

    /// The solid angle of a rectangle 2a x 2b seen from height h above its middle: 4 asin(ab / sqrt((a^2 + h^2)(b^2 + h^2))).
    #[test]
    fn the_solid_angle_is_the_closed_form_and_small_ones_keep_their_digits() {
        for h in [1e-3_f32, 0.1, 1.0, 30.0, 3000.0] {
            let solid_angle = integral(&rectangle(), Vec3::new(0.0, 2.0 - h, 0.0), |_| 1.0);
            let h = f64::from(2.0 - (2.0 - h));
            let expected = 4.0 * (0.5 / ((1.0 + h * h) * (0.25 + h * h)).sqrt()).asin();
            assert!((solid_angle / expected - 1.0).abs() < 1e-5, "{h}: {solid_angle} {expected}");
        }
    }

    #[test]
    fn nobody_sees_the_back_the_edge_or_nothing() {
        let light = rectangle();
        for point in [Vec3::new(0.0, 2.1, 0.0), Vec3::new(5.0, 2.0, 0.0), Vec3::NAN] {
            assert_eq!(light.sample(point, [0.5; 2]), None);
            assert_eq!(light.hit(point, Vec3::Y), None);
        }
        assert_eq!(light.hit(Vec3::ZERO, Vec3::X), None);
        let none = Light::Area { center: Vec3::Y, u: Vec3::ZERO, v: Vec3::Z, radiance: WHITE };
        assert_eq!(none.sample(Vec3::ZERO, [0.5; 2]), None);
        // Far away, grazing and at the corners of the square: finite all the same.
        for point in [Vec3::new(1e4, 1.999, 1e4), Vec3::new(1.0, 1.9999, 0.5), Vec3::new(0.0, -1e5, 0.0)] {
            for u in [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0]] {
                let s = light.sample(point, u).expect("in front");
                assert!(s.direction.is_finite() && s.pdf.is_finite() && s.pdf > 0.0, "{point} {s:?}");
            }
        }
    }
}
