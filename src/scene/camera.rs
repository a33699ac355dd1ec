//! Where the picture is taken from.

use glam::{Mat4, Vec2, Vec3, Vec4};

use crate::base::num;

/// A perspective camera; with an aperture, a thin lens. Lengths in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye.
    pub position: Vec3,
    /// What is in the middle of the picture.
    pub target: Vec3,
    /// Which way is up; not along the view.
    pub up: Vec3,
    /// Vertical angle of view, radians, in (0, pi).
    pub field_of_view_rad: f32,
    /// Radius of the lens; 0 is a pinhole, all sharp.
    pub aperture: f32,
    /// Distance along the view that is sharp.
    pub focus_distance: f32,
}

/// A camera made ready for one picture: what all its rays share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub origin: Vec3,
    /// Unit vector of the view.
    pub forward: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to its upper edge.
    pub up: Vec3,
    /// Half the width and height of the picture at distance 1.
    pub half_size: Vec2,
    /// Radius of the lens.
    pub aperture: f32,
    /// Distance along the view that is sharp.
    pub focus_distance: f32,
}

impl Camera {
    /// The camera's directions, for a picture `aspect` (width over height) wide. Where position and target are one, or
    /// `up` lies along the view, some direction is chosen; never NaN.
    pub fn view(&self, aspect: f32) -> View {
        let forward = (self.target - self.position).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(self.up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let half = libm::tan(0.5 * f64::from(self.field_of_view_rad)) as f32;
        View {
            origin: self.position,
            forward,
            right,
            up: right.cross(forward),
            half_size: Vec2::new(half * aspect, half),
            aperture: self.aperture,
            focus_distance: self.focus_distance,
        }
    }

    /// One ray: see [`View::ray`]. For many, keep the view.
    pub fn ray(&self, x: f32, y: f32, aspect: f32, lens: [f32; 2]) -> (Vec3, Vec3) {
        self.view(aspect).ray(x, y, lens)
    }

    /// World to view space: the eye at 0, looking along -z, y up.
    pub fn view_matrix(&self) -> Mat4 {
        let v = self.view(1.0);
        let row = |axis: Vec3| axis.extend(-axis.dot(v.origin));
        Mat4::from_cols(row(v.right), row(v.up), row(-v.forward), Vec4::W).transpose()
    }

    /// View to clip space: x to the right, y up, depth 0 at `near` and 1 at `far` (wgpu, Vulkan, Metal, Direct3D).
    pub fn projection_matrix(&self, aspect: f32, near: f32, far: f32) -> Mat4 {
        let half = self.view(aspect).half_size;
        let depth = far / (near - far);
        Mat4::from_cols(
            Vec4::new(1.0 / half.x, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / half.y, 0.0, 0.0),
            Vec4::new(0.0, 0.0, depth, -1.0),
            Vec4::new(0.0, 0.0, depth * near, 0.0),
        )
    }
}

impl View {
    /// The point of the lens that `lens`, uniform in the unit square, means: right and up of its middle.
    #[inline]
    pub fn lens_point(&self, lens: [f32; 2]) -> Vec2 {
        if self.aperture > 0.0 { concentric_disk(lens) * self.aperture } else { Vec2::ZERO }
    }

    /// Origin and unit direction of the ray through (`x`, `y`) of the picture, each in [0, 1] from its top left corner,
    /// and the point of the lens that `lens`, uniform in the unit square, means. All rays of one (x, y) meet where the
    /// picture is sharp.
    #[inline(always)]
    pub fn ray(&self, x: f32, y: f32, lens: [f32; 2]) -> (Vec3, Vec3) {
        let across = self.right * ((2.0 * x - 1.0) * self.half_size.x);
        let through = self.forward + across + self.up * ((1.0 - 2.0 * y) * self.half_size.y);
        if self.aperture <= 0.0 {
            return (self.origin, through.normalize());
        }
        let on_lens = self.lens_point(lens);
        let offset = self.right * on_lens.x + self.up * on_lens.y;
        (self.origin + offset, (through * self.focus_distance - offset).normalize_or(self.forward))
    }

    /// [`View::ray`] of several points at once, as lanes.
    #[inline(always)]
    pub fn rays<const N: usize>(&self, x: &[f32; N], y: &[f32; N], lens: &[[f32; 2]; N]) -> [[Vec3; N]; 2] {
        let (mut origins, mut directions) = ([self.origin; N], [self.forward; N]);
        if self.aperture > 0.0 {
            for i in 0..N {
                (origins[i], directions[i]) = self.ray(x[i], y[i], lens[i]);
            }
            return [origins, directions];
        }
        let [right, up, forward] = [self.right, self.up, self.forward].map(|v| v.to_array());
        let mut through = [[0.0; N]; 3];
        for i in 0..N {
            let across = (2.0 * x[i] - 1.0) * self.half_size.x;
            let above = (1.0 - 2.0 * y[i]) * self.half_size.y;
            for axis in 0..3 {
                through[axis][i] = forward[axis] + right[axis] * across + up[axis] * above;
            }
        }
        let [a, b, c] = &mut through;
        for i in 0..N {
            let over = 1.0 / (a[i] * a[i] + b[i] * b[i] + c[i] * c[i]).sqrt();
            (a[i], b[i], c[i]) = (a[i] * over, b[i] * over, c[i] * over);
        }
        for i in 0..N {
            directions[i] = Vec3::new(through[0][i], through[1][i], through[2][i]);
        }
        [origins, directions]
    }
}

/// The unit square to the unit disk, equal areas to equal areas and neighbours to neighbours.
///
/// Source: Shirley & Chiu, "A low distortion map between disk and square", Journal of Graphics Tools 2(3), 1997.
#[inline]
pub fn concentric_disk(u: [f32; 2]) -> Vec2 {
    let [a, b] = u.map(|u| 2.0 * u - 1.0);
    // Radius, and the angle in turns: an eighth to each side of one of the four axes.
    let (radius, turns) = if a.abs() > b.abs() {
        (a, 0.125 * (b / a))
    } else if b != 0.0 {
        (b, 0.25 - 0.125 * (a / b))
    } else {
        (0.0, 0.0)
    };
    Vec2::new(num::cos_turns(turns), num::sin_turns(turns)) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(aperture: f32) -> Camera {
        Camera {
            position: Vec3::new(1.0, 2.0, 5.0),
            target: Vec3::new(0.5, 0.3, -1.0),
            up: Vec3::Y,
            field_of_view_rad: 0.7,
            aperture,
            focus_distance: 4.0,
        }
    }

    #[test]
    fn the_middle_looks_at_the_target_and_the_edge_is_half_the_angle_away() {
        let c = camera(0.0);
        let to_target = (c.target - c.position).normalize();
        let (origin, direction) = c.ray(0.5, 0.5, 1.5, [0.3, 0.9]);
        assert_eq!(origin, c.position);
        assert!((direction - to_target).length() < 1e-6);
        let (_, top) = c.ray(0.5, 0.0, 1.5, [0.5; 2]);
        assert!((top.dot(to_target) - 0.35_f32.cos()).abs() < 1e-6 && top.y > to_target.y);
        let (_, right) = c.ray(1.0, 0.5, 1.5, [0.5; 2]);
        assert!((right.dot(to_target) - (1.5 * 0.35_f32.tan()).atan().cos()).abs() < 1e-6);
        assert!(right.x > to_target.x);
    }

    #[test]
    fn rays_at_once_are_those_one_by_one() {
        let (x, y) = ([0.0, 0.3, 0.99], [1.0, 0.2, 0.5]);
        let lens = [[0.1, 0.9], [0.5, 0.5], [0.0, 0.3]];
        for aperture in [0.0, 0.2] {
            let view = camera(aperture).view(1.5);
            let [origins, directions] = view.rays(&x, &y, &lens);
            for i in 0..3 {
                let (origin, direction) = view.ray(x[i], y[i], lens[i]);
                assert_eq!(origins[i], origin);
                assert!((directions[i] - direction).length() < 2e-7, "{aperture} {i}");
            }
        }
    }

    /// A thin lens of radius R focused at f blurs a point at depth z to a disk of radius R |z - f| / f on the plane of
    /// focus seen through the middle; at z = f to a point.
    #[test]
    fn all_rays_meet_on_the_plane_of_focus_and_spread_as_the_lens_says_elsewhere() {
        let c = camera(0.25);
        let view = c.view(1.2);
        let at_depth = |lens: [f32; 2], depth: f32| {
            let (o, d) = view.ray(0.2, 0.7, lens);
            o + d * (depth / d.dot(view.forward))
        };
        for depth in [1.0, 4.0, 9.0] {
            let middle = at_depth([0.5, 0.5], depth);
            // The edge of the square is the edge of the lens.
            for edge in [[0.0, 0.3], [1.0, 0.8], [0.4, 0.0], [0.1, 1.0]] {
                let spread = (at_depth(edge, depth) - middle).length();
                let expected = 0.25 * (depth - 4.0).abs() / 4.0;
                assert!((spread - expected).abs() < 3e-6, "{depth}: {spread} for {expected}");
            }
        }
    }

    #[test]
    fn the_disk_map_keeps_areas() {
        let n = 512;
        let (mut within, mut moment) = (0, 0.0);
        for i in 0..n * n {
            let p = concentric_disk([(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32));
            within += usize::from(p.length() < 0.5);
            moment += f64::from(p.length_squared());
        }
        let total = (n * n) as f64;
        assert!((within as f64 / total - 0.25).abs() < 2e-3);
        assert!((moment / total - 0.5).abs() < 1e-4);
        assert_eq!(concentric_disk([0.5; 2]), Vec2::ZERO);
    }

    #[test]
    fn matrices_put_what_a_ray_meets_where_the_ray_started() {
        let c = camera(0.0);
        let clip = c.projection_matrix(1.5, 0.1, 100.0) * c.view_matrix();
        for (x, y, depth) in [(0.2, 0.7, 3.0), (0.9, 0.1, 0.1), (0.5, 0.5, 100.0)] {
            let view = c.view(1.5);
            let (o, d) = view.ray(x, y, [0.5; 2]);
            let p = clip * (o + d * (depth / d.dot(view.forward))).extend(1.0);
            let p = p / p.w;
            assert!((p.x - (2.0 * x - 1.0)).abs() < 1e-4 && (p.y - (1.0 - 2.0 * y)).abs() < 1e-4, "{p}");
            let expected = 100.0 / (100.0 - 0.1) * (1.0 - 0.1 / depth);
            assert!((p.z - expected).abs() < 1e-4, "{p}");
        }
    }

    #[test]
    fn degenerate_cameras_still_look_somewhere() {
        let mut c = camera(0.1);
        c.target = c.position;
        assert!(c.ray(0.1, 0.9, 1.0, [0.2, 0.4]).1.is_finite());
        c.target = c.position + Vec3::Y;
        c.focus_distance = 0.0;
        assert!(c.ray(0.1, 0.9, 1.0, [0.5, 0.5]).1.is_finite());
    }
}
