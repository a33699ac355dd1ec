//! Lights that have a place or a direction. The environment is apart: see [`super::environment`].

use glam::Vec3;

use crate::base::LinearRgb;

/// A light. Radiance is relative to D65: white (1, 1, 1) has that illuminant's spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From far away, like the sun.
    Directional {
        /// Unit vector towards the light.
        direction: Vec3,
        /// Irradiance on a surface that faces it.
        irradiance: LinearRgb,
        /// Half the angle that it fills, radians; 0 is a point, the sun has 0.00465.
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
