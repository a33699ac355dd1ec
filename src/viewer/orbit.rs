//! A camera that the mouse moves.

use glam::Vec3;

use crate::scene::sky::towards;
use crate::scene::{Camera, View};

/// A camera that looks at a target from around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orbit {
    /// In the middle of the picture.
    pub(super) target: Vec3,
    /// From there to the eye.
    pub(super) distance: f32,
    /// Around the vertical: 0 is in front, 90 to the right.
    pub(super) azimuth_deg: f32,
    /// Above the horizon.
    pub(super) elevation_deg: f32,
    /// Vertical angle of view, radians.
    pub(super) field_of_view_rad: f32,
}

/// Degrees for a drag over the whole height of the picture.
const DEGREES_PER_HEIGHT: f32 = 220.0;

/// Nearest and farthest eye, body diameters.
const DISTANCES: [f32; 2] = [0.05, 2000.0];

impl Orbit {
    /// The one that sees what a camera sees; its lens is a pinhole.
    pub(super) fn of(camera: &Camera) -> Self {
        let from = camera.position - camera.target;
        let distance = from.length().max(DISTANCES[0]);
        let up = (from.y / distance).clamp(-1.0, 1.0);
        let elevation_deg = libm::asin(f64::from(up)).to_degrees() as f32;
        let mut azimuth_deg = libm::atan2(f64::from(from.x), f64::from(from.z)).to_degrees() as f32;
        // Straight down, only the camera's own up tells where in front is.
        if from.x.hypot(from.z) < 1e-4 * distance {
            let ahead = camera.up * -up.signum();
            azimuth_deg = libm::atan2(f64::from(ahead.x), f64::from(ahead.z)).to_degrees() as f32;
        }
        Self {
            target: camera.target,
            distance,
            azimuth_deg,
            elevation_deg,
            field_of_view_rad: camera.field_of_view_rad,
        }
    }

    /// The camera.
    pub(super) fn camera(&self) -> Camera {
        Camera {
            position: self.target + towards(self.elevation_deg, self.azimuth_deg) * self.distance,
            target: self.target,
            up: towards(self.elevation_deg + 90.0, self.azimuth_deg),
            field_of_view_rad: self.field_of_view_rad,
            aperture: 0.0,
            focus_distance: self.distance,
        }
    }

    /// Turn by a drag, in shares of the picture's height: the subject follows the hand.
    pub(super) fn turn(&mut self, [x, y]: [f32; 2]) {
        let azimuth = self.azimuth_deg - x * DEGREES_PER_HEIGHT;
        self.azimuth_deg = (azimuth + 180.0).rem_euclid(360.0) - 180.0;
        self.elevation_deg = (self.elevation_deg + y * DEGREES_PER_HEIGHT).clamp(-89.9, 89.9);
    }

    /// Move sideways by a drag, in shares of the picture's height: what is at the target follows the hand.
    pub(super) fn pan(&mut self, [x, y]: [f32; 2]) {
        let View { right, up, half_size, .. } = self.camera().view(1.0);
        let height = 2.0 * half_size.y * self.distance;
        self.target += (up * y - right * x) * height;
    }

    /// Come nearer by so many times; below 1 goes away.
    pub(super) fn zoom(&mut self, nearer: f32) {
        if nearer > 0.0 && nearer.is_finite() {
            self.distance = (self.distance / nearer).clamp(DISTANCES[0], DISTANCES[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orbit() -> Orbit {
        Orbit {
            target: Vec3::new(0.3, 0.5, -0.2),
            distance: 12.0,
            azimuth_deg: 15.0,
            elevation_deg: 38.0,
            field_of_view_rad: 0.3,
        }
    }

    #[test]
    fn a_scene_camera_and_its_orbit_see_the_same() {
        for elevation in [-90.0, -30.0, 0.0, 38.0, 90.0] {
            for azimuth in [-170.0, -90.0, 0.0, 15.0, 135.0] {
                let start = Orbit { azimuth_deg: azimuth, elevation_deg: elevation, ..orbit() }.camera();
                let same = Orbit::of(&start).camera();
                assert!((same.position - start.position).length() < 1e-4, "{elevation} {azimuth}");
                let (a, b) = (start.view(1.5), same.view(1.5));
                assert!(
                    (a.right - b.right).length() < 1e-3,
                    "{elevation} {azimuth}: {} {}",
                    a.right,
                    b.right
                );
            }
        }
    }

    /// Where a place of the scene is in the picture, in shares of its height from the middle, right and down.
    fn seen(orbit: &Orbit, place: Vec3) -> [f32; 2] {
        let view = orbit.camera().view(1.0);
        let to = place - view.origin;
        let depth = to.dot(view.forward) * 2.0 * view.half_size.y;
        [to.dot(view.right) / depth, -to.dot(view.up) / depth]
    }

    #[test]
    fn a_pan_moves_the_target_with_the_hand() {
        let mut moved = orbit();
        moved.pan([0.2, -0.1]);
        let [x, y] = seen(&moved, orbit().target);
        assert!((x - 0.2).abs() < 1e-5 && (y + 0.1).abs() < 1e-5, "{x} {y}");
        assert_eq!(moved.distance, orbit().distance);
    }

    #[test]
    fn a_turn_to_the_right_moves_the_front_to_the_right_and_stops_at_the_poles() {
        let mut turned = orbit();
        turned.elevation_deg = 0.0;
        let front = turned.target + towards(0.0, turned.azimuth_deg);
        turned.turn([0.1, 0.0]);
        assert!(seen(&turned, front)[0] > 0.0);
        turned.turn([0.0, 50.0]);
        assert_eq!(turned.elevation_deg, 89.9);
        turned.turn([1e6, -100.0]);
        assert_eq!(turned.elevation_deg, -89.9);
        assert!((-180.0..=180.0).contains(&turned.azimuth_deg));
    }

    #[test]
    fn zoom_stays_within_limits_whatever_is_asked() {
        let mut near = orbit();
        near.zoom(2.0);
        assert_eq!(near.distance, 6.0);
        for odd in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            near.zoom(odd);
            assert_eq!(near.distance, 6.0);
        }
        near.zoom(1e30);
        assert_eq!(near.distance, DISTANCES[0]);
        near.zoom(1e-30);
        assert_eq!(near.distance, DISTANCES[1]);
    }
}
