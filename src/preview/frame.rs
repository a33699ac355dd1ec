//! What is the same for a whole picture: the camera, and how much there is of what.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

use crate::scene::Camera;

/// `Frame` of frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct FrameUniform {
    /// World to clip space; depth is 1 at the near plane and 0 at infinity.
    pub(super) clip: [[f32; 4]; 4],
    /// The eye.
    pub(super) eye: [f32; 3],
    /// Layers of the environment with roughness.
    pub(super) sky_layers: f32,
    /// Direction of the middle of the picture.
    pub(super) forward: [f32; 3],
    /// Lights far away.
    pub(super) suns: u32,
    /// From the middle of the picture to its right edge, at distance 1.
    pub(super) right: [f32; 3],
    /// Suns that are discs.
    pub(super) discs: u32,
    /// From the middle of the picture to its upper edge, at distance 1.
    pub(super) up: [f32; 3],
    /// Lights nearby.
    pub(super) rectangles: u32,
    /// Mean radiance of the environment.
    pub(super) even: [f32; 3],
    /// To the next 16 bytes.
    pub(super) padding: f32,
}

/// What is nearer than so much of the way to the target is not seen.
const NEAR: f32 = 1e-3;

impl FrameUniform {
    /// The part of the camera, for a picture `aspect` (width over height) wide. Everything is sharp: lenses do not count.
    pub(super) fn new(camera: &Camera, aspect: f32) -> Self {
        let view = camera.view(aspect);
        let row = |axis: glam::Vec3| axis.extend(-axis.dot(view.origin));
        let near = NEAR * (camera.target - camera.position).length().max(1e-3);
        let rows = Mat4::from_cols(
            row(view.right) / view.half_size.x,
            row(view.up) / view.half_size.y,
            Vec4::new(0.0, 0.0, 0.0, near),
            row(view.forward),
        );
        Self {
            clip: rows.transpose().to_cols_array_2d(),
            eye: view.origin.to_array(),
            forward: view.forward.to_array(),
            right: (view.right * view.half_size.x).to_array(),
            up: (view.up * view.half_size.y).to_array(),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn what_a_ray_meets_is_drawn_where_the_ray_started() {
        let camera = Camera {
            position: Vec3::new(1.0, 2.0, 5.0),
            target: Vec3::new(0.5, 0.3, -1.0),
            up: Vec3::Y,
            field_of_view_rad: 0.7,
            aperture: 0.0,
            focus_distance: 4.0,
        };
        let frame = FrameUniform::new(&camera, 1.5);
        let clip = Mat4::from_cols_array_2d(&frame.clip);
        let mut last = 1.0;
        for (x, y, depth) in [(0.2, 0.7, 0.1), (0.9, 0.1, 3.0), (0.5, 0.5, 1000.0)] {
            let (o, d) = camera.ray(x, y, 1.5, [0.5; 2]);
            let p = clip * (o + d * depth).extend(1.0);
            let p = p / p.w;
            assert!((p.x - (2.0 * x - 1.0)).abs() < 1e-4 && (p.y - (1.0 - 2.0 * y)).abs() < 1e-4, "{p}");
            assert!(p.z > 0.0 && p.z < last, "{p}");
            last = p.z;
            let background = Vec3::from(frame.forward)
                + Vec3::from(frame.right) * (2.0 * x - 1.0)
                + Vec3::from(frame.up) * (1.0 - 2.0 * y);
            assert!((background.normalize() - d).length() < 1e-6);
        }
    }
}
