//! A photographer's studio as an environment: soft boxes on a backdrop that fades from floor to ceiling.
//!
//! Gloss shows what is reflected, so a glossy skin needs large lights with clear forms; a thin film shows its colours
//! where a light is reflected, so it needs some of them at grazing angles, and darkness between them.

use glam::Vec3;

use super::environment::EnvironmentImage;
use super::sky::towards;
use crate::base::{LinearRgb, num};

/// Texels of a studio.
const SIZE: (usize, usize) = (1024, 512);

/// A soft box far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftBox {
    /// Its middle above the horizon, degrees.
    pub elevation_deg: f32,
    /// Its middle around the vertical, degrees: 0 is behind a viewer on +z, 90 to the right.
    pub azimuth_deg: f32,
    /// Width over distance.
    pub width: f32,
    /// Height over distance.
    pub height: f32,
    /// Radiance in its middle; a third less at its edges, as cloth before a lamp.
    pub radiance: LinearRgb,
}

/// Soft boxes before a backdrop.
#[derive(Clone, Debug, PartialEq)]
pub struct Studio {
    /// Radiance of the backdrop straight up.
    pub ceiling: LinearRgb,
    /// Radiance of the backdrop straight down.
    pub floor: LinearRgb,
    /// Lights.
    pub boxes: Vec<SoftBox>,
}

const fn soft_box(elevation_deg: f32, azimuth_deg: f32, size: [f32; 2], radiance: f32) -> SoftBox {
    let [width, height] = size;
    SoftBox { elevation_deg, azimuth_deg, width, height, radiance: LinearRgb([radiance; 3]) }
}

impl Studio {
    /// A light grey studio: a large key from the upper left, a weaker fill from the right, and two strips behind for the
    /// rims.
    pub fn gray() -> Self {
        Self {
            ceiling: LinearRgb([0.5; 3]),
            floor: LinearRgb([0.2; 3]),
            boxes: vec![
                soft_box(55.0, -45.0, [1.1, 0.9], 7.0),
                soft_box(30.0, 65.0, [0.9, 1.2], 2.0),
                soft_box(35.0, 150.0, [0.25, 1.4], 6.0),
                soft_box(35.0, -150.0, [0.25, 1.4], 6.0),
            ],
        }
    }

    /// A dark studio for films: a long strip overhead and strips low around, whose reflections cross the scales at many
    /// angles, and black between.
    pub fn dark() -> Self {
        Self {
            ceiling: LinearRgb([0.02; 3]),
            floor: LinearRgb([0.01; 3]),
            boxes: vec![
                soft_box(78.0, 180.0, [2.2, 0.7], 8.0),
                soft_box(35.0, -75.0, [0.5, 1.5], 9.0),
                soft_box(20.0, 165.0, [2.4, 0.35], 10.0),
                soft_box(30.0, 95.0, [0.35, 1.5], 5.0),
            ],
        }
    }

    /// The picture of the studio.
    pub fn image(&self) -> EnvironmentImage {
        let frames: Vec<(Vec3, Vec3, Vec3, &SoftBox)> = self
            .boxes
            .iter()
            .map(|b| {
                let middle = towards(b.elevation_deg, b.azimuth_deg);
                let across = towards(0.0, b.azimuth_deg + 90.0);
                (middle, across, middle.cross(across), b)
            })
            .collect();
        EnvironmentImage::from_fn(SIZE.0, SIZE.1, |d| {
            let t = num::smoothstep(-1.0, 1.0, d.y);
            let mut out: [f32; 3] = std::array::from_fn(|c| num::lerp(self.floor.0[c], self.ceiling.0[c], t));
            for (middle, across, up, b) in &frames {
                let depth = d.dot(*middle);
                if depth > 0.0 {
                    let (x, y) = (2.0 * d.dot(*across) / depth, 2.0 * d.dot(*up) / depth);
                    let inside = edge(x.abs(), b.width) * edge(y.abs(), b.height);
                    // From 0 in the middle to 1 at a corner.
                    let rim = 0.5 * ((x / b.width) * (x / b.width) + (y / b.height) * (y / b.height));
                    let strength = inside * (1.0 - num::saturate(rim) / 3.0);
                    (0..3).for_each(|c| out[c] += strength * b.radiance.0[c]);
                }
            }
            LinearRgb(out)
        })
    }
}

/// 1 within `size`, 0 beyond, over some texels.
fn edge(x: f32, size: f32) -> f32 {
    let soft = 3.0 * 2.0 * std::f32::consts::PI / SIZE.0 as f32;
    1.0 - num::smoothstep(size - soft, size + soft, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_where_they_are_put_as_large_as_they_are_told() {
        let studio = Studio {
            ceiling: LinearRgb::default(),
            floor: LinearRgb::default(),
            boxes: vec![soft_box(30.0, 40.0, [0.5, 1.0], 2.0)],
        };
        let image = studio.image();
        let at = |e, a| image.radiance(towards(e, a)).0[0];
        assert!((at(30.0, 40.0) - 2.0).abs() < 1e-3);
        // Half a width of 0.5 is 14.0 degrees, half a height of 1 is 26.6 degrees.
        assert!(at(30.0 + 25.0, 40.0) > 1.0 && at(30.0 - 25.0, 40.0) > 1.0);
        assert_eq!((at(30.0 + 29.0, 40.0), at(30.0 - 29.0, 40.0)), (0.0, 0.0));
        assert_eq!((at(30.0, 40.0 + 25.0), at(30.0, 40.0 - 25.0), at(-30.0, 220.0)), (0.0, 0.0, 0.0));
        // Mean radiance: solid angle of the rectangle over the sphere, times about 1.8.
        let solid_angle = 4.0 * (0.25_f64 * 0.5 / ((1.0 + 0.0625) * (1.0 + 0.25_f64)).sqrt()).asin();
        let mean = f64::from(image.mean_radiance().0[0]) * 4.0 * std::f64::consts::PI / solid_angle;
        assert!((1.6..1.95).contains(&mean), "{mean}");
    }

    #[test]
    fn the_gray_studio_is_lit_from_the_left_and_the_dark_one_is_mostly_dark() {
        let gray = Studio::gray().image();
        assert!(gray.radiance(towards(55.0, -45.0)).0[1] > 3.0 * gray.radiance(towards(30.0, 65.0)).0[1]);
        let dark = Studio::dark().image();
        let lit = dark.texels.iter().filter(|t| t[1] > 0.1).count();
        assert!(lit * 4 < dark.texels.len(), "{lit}");
        assert!(dark.radiance(Vec3::NEG_Y).0[1] < 0.02);
    }
}
