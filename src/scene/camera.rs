//! Where the picture is taken from.

use glam::Vec3;

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
