//! Plain forms to look at a skin: a capsule, which without a straight part is a sphere, and a flat tile.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use super::mesh::Mesh;
use super::tangents::{self, TangentError};

/// A lying capsule of diameter 1 with a straight part of this length, along x, resting on y = 0; `triangles` or a little
/// more.
///
/// Texture coordinates as on a snake whose head is at -x: u from the belly over the side of the viewer; v along the
/// surface's meridian, in tiles of `size_mm` (girth, length) on a body of that girth.
pub(super) fn capsule(straight: f32, triangles: usize, size_mm: [f32; 2]) -> Result<Mesh, TangentError> {
    let straight = f64::from(straight);
    let meridian = straight + FRAC_PI_2;
    let tile = f64::from(size_mm[1]) / (f64::from(size_mm[0]) / PI);
    let around = ((triangles as f64 * 0.5 * PI / meridian).sqrt() as usize).max(8);
    let along = triangles.div_ceil(2 * around).max(3) + 1;
    let grid = Grid { across: around, down: along, poles: true };
    tangents::generate(&grid.mesh(|u, t| {
        let s = t * meridian;
        // Angle from the nearer end's pole, and the middle of that end's half sphere.
        let (angle, middle) = if s < 0.5 * FRAC_PI_2 {
            (2.0 * s, -0.5 * straight)
        } else if s > meridian - 0.5 * FRAC_PI_2 {
            (PI - 2.0 * (meridian - s), 0.5 * straight)
        } else {
            (FRAC_PI_2, s - 0.5 * meridian)
        };
        let (sin, turn) = (libm::sin(angle), TAU * u);
        let normal = DVec3::new(-libm::cos(angle), -libm::cos(turn) * sin, libm::sin(turn) * sin);
        let position = normal * 0.5 + DVec3::new(middle, 0.5, 0.0);
        (position.as_vec3(), normal.as_vec3(), Vec2::new(u as f32, (s / tile) as f32))
    }))
}

/// One tile as large as on the body, upright on y = 0, facing +z: v = 0 at its upper edge.
pub(super) fn tile(triangles: usize, size_mm: [f32; 2]) -> Result<Mesh, TangentError> {
    let [width, height] = size_mm.map(|side| f64::from(side) * PI / f64::from(size_mm[0]));
    let across = ((triangles as f64 * 0.5 * width / height).sqrt() as usize).max(1);
    let grid = Grid { across, down: triangles.div_ceil(2 * across).max(1), poles: false };
    tangents::generate(&grid.mesh(|u, v| {
        let position = DVec3::new((u - 0.5) * width, (1.0 - v) * height, 0.0);
        (position.as_vec3(), Vec3::Z, Vec2::new(u as f32, v as f32))
    }))
}

/// Quads over (u, v) in [0, 1]^2; with poles the first and the last row are triangles.
struct Grid {
    across: usize,
    down: usize,
    poles: bool,
}

impl Grid {
    /// Place, normal and texture coordinates from (u, v); growing u times growing v points inward.
    fn mesh(&self, surface: impl Fn(f64, f64) -> (Vec3, Vec3, Vec2)) -> Mesh {
        let mut mesh = Mesh::default();
        for j in 0..=self.down {
            let pole = self.poles && (j == 0 || j == self.down);
            for i in 0..=self.across {
                // The seam's two vertices are one place, to the bit; a pole's have the u of their triangle's middle.
                let turn = if self.poles && i == self.across { 0 } else { i };
                let (u, v) = (turn as f64 / self.across as f64, j as f64 / self.down as f64);
                let (position, normal, mut uv) = surface(if pole { 0.0 } else { u }, v);
                uv.x = (i as f32 + if pole { 0.5 } else { 0.0 }) / self.across as f32;
                mesh.positions.push(position);
                mesh.normals.push(normal);
                mesh.uvs.push(uv);
            }
        }
        let row = self.across as u32 + 1;
        for j in 0..self.down as u32 {
            for i in 0..self.across as u32 {
                let (a, b) = (j * row + i, (j + 1) * row + i);
                let (first, last) = (self.poles && j == 0, self.poles && j + 1 == self.down as u32);
                if !first {
                    mesh.triangles.push([a, b, a + 1]);
                }
                if !last {
                    mesh.triangles.push([a + u32::from(!first), b, b + 1]);
                }
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE_MM: [f32; 2] = [62.8, 92.4];

    fn volume(mesh: &Mesh) -> f64 {
        let part = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        mesh.triangles.iter().map(part).sum()
    }

    #[test]
    fn a_capsule_has_its_volume_faces_outward_and_lies_on_the_ground() {
        for straight in [0.0, 3.0] {
            let mesh = capsule(straight, 20_000, SIZE_MM).expect("it has tangents");
            let expected = PI / 6.0 + PI / 4.0 * f64::from(straight);
            assert!((volume(&mesh) / expected - 1.0).abs() < 3e-3, "{}", volume(&mesh));
            assert!((20_000..21_000).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
            let lowest = mesh.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
            assert!(lowest.abs() < 1e-6);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let n = mesh.normals[t[1] as usize];
                assert!((b - a).cross(c - a).dot(n) > 0.0, "{t:?} faces inward");
            }
        }
    }

    /// Along and around, a millimetre of skin is a millimetre of surface.
    #[test]
    fn scales_keep_their_proportions() {
        let mesh = capsule(3.0, 20_000, SIZE_MM).expect("it has tangents");
        let mm_per_unit = SIZE_MM[0] / PI as f32;
        let mut seen = 0;
        for t in &mesh.triangles {
            let [a, b] = [t[0], t[1]].map(|i| i as usize);
            let moved = mesh.positions[a].distance(mesh.positions[b]) * mm_per_unit;
            let d = mesh.uvs[b] - mesh.uvs[a];
            if mesh.positions[a].x.abs() < 1.0 && d.x == 0.0 {
                assert!((d.y.abs() * SIZE_MM[1] / moved - 1.0).abs() < 1e-3);
                seen += 1;
            }
        }
        assert!(seen > 1000);
        let flat = tile(1000, SIZE_MM).expect("it has tangents");
        let most = flat.positions.iter().fold(Vec3::ZERO, |most, p| most.max(p.abs()));
        assert!(
            (most.x * 2.0 * mm_per_unit - 62.8).abs() < 1e-3 && (most.y * mm_per_unit - 92.4).abs() < 1e-3
        );
        // Green of a normal map is up.
        for (n, t) in flat.normals.iter().zip(&flat.tangents) {
            assert!(
                (t.truncate() - Vec3::X).length() < 1e-5
                    && (t.w * n.cross(t.truncate()) - Vec3::Y).length() < 1e-5
            );
        }
    }
}
