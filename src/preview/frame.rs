//! What is the same for a whole picture: the camera, and how much there is of what.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

use crate::base::num;
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
    /// Suns that are discs.
    pub(super) discs: u32,
    /// From the middle of the picture to its right edge, at distance 1.
    pub(super) right: [f32; 3],
    /// Of the small lights of each rectangle the first that shines in this sample, ...
    pub(super) first_place: u32,
    /// From the middle of the picture to its upper edge, at distance 1.
    pub(super) up: [f32; 3],
    /// ... how many there are from it to the next one, ...
    pub(super) place_step: u32,
    /// Mean radiance of the environment.
    pub(super) even: [f32; 3],
    /// Added to the level of maps that a pixel covers.
    pub(super) sharper: f32,
    /// ... and where within its part of the rectangle it is, from -1/2 to 1/2.
    pub(super) place_shift: [f32; 2],
    /// Which of the pictures that are averaged.
    pub(super) sample: u32,
    /// Depth times distance.
    pub(super) near: f32,
}

/// What is nearer than so much of the way to the target is not seen.
const NEAR: f32 = 1e-3;

impl FrameUniform {
    /// The part of the camera, for a picture of so many pixels in whose middles lies what is `shift` (pixels, right and
    /// down) beside them, as the point of the lens sees it that `lens`, in the unit square, means: see [`Camera::ray`].
    pub(super) fn new(camera: &Camera, size: [usize; 2], shift: [f32; 2], lens: [f32; 2]) -> Self {
        let [width, height] = size.map(|n| n as f32);
        let view = camera.view(width / height);
        // In halves of the picture, right and up.
        let (x, y) = (2.0 * shift[0] / width, -2.0 * shift[1] / height);
        let on_lens = view.lens_point(lens);
        // What is in focus stays where it is: the picture leans by as much as the eye is aside.
        let lean = on_lens / view.focus_distance.max(1e-6);
        let eye = view.origin + view.right * on_lens.x + view.up * on_lens.y;
        let row = |axis: glam::Vec3| axis.extend(-axis.dot(eye));
        let near = NEAR * (camera.target - camera.position).length().max(1e-3);
        let (right, up) = (view.right * view.half_size.x, view.up * view.half_size.y);
        let rows = Mat4::from_cols(
            row(view.right) / view.half_size.x - row(view.forward) * (x - lean.x / view.half_size.x),
            row(view.up) / view.half_size.y - row(view.forward) * (y - lean.y / view.half_size.y),
            Vec4::new(0.0, 0.0, 0.0, near),
            row(view.forward),
        );
        Self {
            clip: rows.transpose().to_cols_array_2d(),
            eye: eye.to_array(),
            forward: (view.forward + right * x + up * y - view.right * lean.x - view.up * lean.y).to_array(),
            right: right.to_array(),
            up: up.to_array(),
            near,
            ..Self::default()
        }
    }
}

/// The point of the lens for one of so many pictures that are averaged: its middle where there is but one.
pub(super) fn lens_of(sample: u32, samples: u32) -> [f32; 2] {
    // Even at any length (Roberts 2018), and unlike the places within pixels.
    let of = |step: f32| num::fract(0.5 + step * sample as f32);
    if samples > 1 { [of(0.754_877_7), of(0.569_840_3)] } else { [0.5; 2] }
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
            aperture: 0.3,
            focus_distance: 4.0,
        };
        let [width, height] = [600, 400];
        let shift = [0.4, -0.3];
        for lens in [[0.5; 2], [0.1, 0.7], [0.9, 0.2]] {
            let frame = FrameUniform::new(&camera, [width, height], shift, lens);
            let clip = Mat4::from_cols_array_2d(&frame.clip);
            let mut last = 1.0;
            for (x, y, depth) in [(0.2, 0.7, 0.1), (0.9, 0.1, 3.0), (0.5, 0.5, 1000.0)] {
                let beside = [x + shift[0] / width as f32, y + shift[1] / height as f32];
                let (o, d) = camera.ray(beside[0], beside[1], 1.5, lens);
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
            assert_eq!(Vec3::from(frame.eye) == camera.position, lens == [0.5; 2]);
        }
    }
}
