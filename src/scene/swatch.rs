//! Plain forms that carry the skin, to look at a material: sphere, plane, cylinder.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};

use super::mesh::Mesh;
use super::snake::check_tile;
use super::tangents::{self, TangentError};

/// A form of diameter or side 1, the scene unit, around the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// A sphere; u once around the z axis, v from its pole at -z to +z. Scales are in proportion at its equator.
    Sphere,
    /// A square that faces +y; v grows towards +z, the viewer. It shows a diameter's share of the girth.
    Plane,
    /// A tube without caps along z, of length 2; v grows towards +z.
    Cylinder,
}

/// Why there is no such swatch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SwatchError {
    /// Too few segments to be the form, or too many for memory.
    #[error("a swatch has 3 to 2000 segments, not {0}")]
    Segments(usize),
    /// A side that is not finite and positive, or a shape beyond 1:1000.
    #[error("a tile of {0} mm by {1} mm cannot be laid on a swatch")]
    Tile(f32, f32),
    /// The surface has no tangents; cannot happen for a valid swatch.
    #[error(transparent)]
    Tangents(#[from] TangentError),
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Sphere, Self::Plane, Self::Cylinder];

    /// Its name in scene texts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
        }
    }

    /// The form of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.name() == name)
    }

    /// The mesh: `segments` in each direction, in [3, 2000], with the texture as on a snake: `tile_mm` is girth and length
    /// of the tile, and the girth is pi scene units. The back, u 0.5, is at +y.
    pub fn mesh(self, segments: usize, tile_mm: [f32; 2]) -> Result<Mesh, SwatchError> {
        if !(3..=2000).contains(&segments) {
            return Err(SwatchError::Segments(segments));
        }
        check_tile(tile_mm).map_err(|[girth, length]| SwatchError::Tile(girth, length))?;
        // Tiles to the scene unit, along the body.
        let rate = f64::from(tile_mm[0]) / f64::from(tile_mm[1]) / PI;
        let mut mesh = Mesh::default();
        for row in 0..=segments {
            let y = row as f64 / segments as f64;
            for column in 0..=segments {
                let x = column as f64 / segments as f64;
                // Exact at the seam and the poles.
                let turn = |share: f64| if share == 1.0 { 0.0 } else { TAU * share };
                let around = DVec3::new(-libm::sin(turn(x)), -libm::cos(turn(x)), 0.0);
                let pole = row == 0 || row == segments;
                let middle = ((column as f64 + 0.5) / segments as f64).min(1.0);
                let (position, normal, uv) = match self {
                    Self::Sphere => {
                        let across = if pole { 0.0 } else { libm::sin(PI * y) };
                        let normal = around * across - DVec3::Z * libm::cos(PI * y);
                        (normal * 0.5, normal, (if pole { middle } else { x }, 0.5 * PI * y * rate))
                    }
                    Self::Plane => {
                        let uv = (0.5 + (x - 0.5) / PI, y * rate);
                        (DVec3::new(x - 0.5, 0.0, y - 0.5), DVec3::Y, uv)
                    }
                    Self::Cylinder => {
                        (around * 0.5 + DVec3::Z * (2.0 * y - 1.0), around, (x, 2.0 * y * rate))
                    }
                };
                mesh.positions.push(position.as_vec3());
                mesh.normals.push(normal.as_vec3());
                mesh.uvs.push(Vec2::new(uv.0 as f32, uv.1 as f32));
            }
        }
        let stride = segments as u32 + 1;
        for row in 0..segments as u32 {
            for column in 0..segments as u32 {
                let (a, b) = (row * stride + column, (row + 1) * stride + column);
                let poles = self == Self::Sphere;
                if !(poles && row == 0) {
                    mesh.triangles.push([a, b, a + 1]);
                }
                if !(poles && row + 1 == segments as u32) {
                    // At the first pole the vertex of this triangle's own middle.
                    mesh.triangles.push([if poles && row == 0 { a } else { a + 1 }, b, b + 1]);
                }
            }
        }
        Ok(tangents::generate(&mesh)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: [f32; 2] = [60.0, 90.0];

    #[test]
    fn areas_are_those_of_the_forms() {
        let area = |form: Form| form.mesh(200, TILE).unwrap().area();
        assert!((area(Form::Sphere) / PI - 1.0).abs() < 3e-4);
        assert!((area(Form::Plane) - 1.0).abs() < 1e-6);
        assert!((area(Form::Cylinder) / TAU - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_sphere_is_closed_and_its_normals_are_its_places() {
        let mesh = Form::Sphere.mesh(24, TILE).unwrap();
        mesh.check().unwrap();
        assert!(mesh.is_closed());
        assert!(!Form::Cylinder.mesh(24, TILE).unwrap().is_closed());
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((*p * 2.0 - *n).length() < 1e-6);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "outward");
        }
    }

    #[test]
    fn texture_keeps_its_proportions_and_its_handedness() {
        for form in Form::ALL {
            let mesh = form.mesh(32, TILE).unwrap();
            mesh.check().unwrap();
            assert!(mesh.tangents.iter().all(|t| t.w == 1.0), "{form:?} is mirrored");
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let [ua, ub, uc] = t.map(|i| mesh.uvs[i as usize]);
                // Only near the sphere's equator, where it is like the cylinder.
                if form == Form::Sphere && a.z.abs().max(b.z.abs()).max(c.z.abs()) > 0.06 {
                    continue;
                }
                // Square mm of texture over square mm of surface.
                let scale = TILE[0] / std::f32::consts::PI;
                let surface = (b - a).cross(c - a).length() * scale * scale;
                let texture = (ub - ua).perp_dot(uc - ua).abs() * TILE[0] * TILE[1];
                assert!((texture / surface - 1.0).abs() < 0.02, "{form:?}: {}", texture / surface);
            }
        }
    }

    #[test]
    fn what_cannot_be_made_is_refused() {
        assert_eq!(Form::Plane.mesh(2, TILE), Err(SwatchError::Segments(2)));
        assert!(matches!(Form::Plane.mesh(9, [f32::NAN, 1.0]), Err(SwatchError::Tile(..))));
        assert!(matches!(Form::Plane.mesh(9, [0.0, 1.0]), Err(SwatchError::Tile(..))));
        assert!(Form::ALL.iter().all(|&form| Form::from_name(form.name()) == Some(form)));
    }
}
