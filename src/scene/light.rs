//! Lights that have a place or a direction. The environment is apart: see [`super::environment`].

pub(crate) mod rectangle;

use std::f32::consts::PI;

use glam::Vec3;

use self::rectangle::Rectangle;
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
                Rectangle::new(center, half_u, half_v)?.sample(point, radiance, u)
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
                Rectangle::new(center, u, v)?.hit(origin, direction, radiance)
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
