//! True displacement: a height map moves the vertices along their normals.

use std::collections::BTreeMap;

use glam::{DVec3, Vec2, Vec3};

use super::mesh::{Mesh, MeshError};
use super::tangents::{self, TangentError};
use crate::base::Plane;

/// Why a mesh was not displaced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DisplaceError {
    /// The mesh is broken.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The result has no tangents.
    #[error(transparent)]
    Tangents(#[from] TangentError),
    /// The map has no texel.
    #[error("the height map is empty")]
    Empty,
    /// A number that is not finite, or a scale that is not positive.
    #[error("displacement needs finite heights, a finite amount and a positive size of the scene unit")]
    NotFinite,
}

/// How finely a grid around a body should be divided for a height map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Density {
    /// Triangles to ask for.
    pub triangles: usize,
    /// Vertices for each texel along one direction: 1 shows all of the map, less leaves out its finest parts.
    pub vertices_per_texel: f64,
}

/// The triangles that put a vertex on each texel of a map of `width` x `height` texels that repeats over `tiles` tiles, but
/// `most` at the utmost.
pub fn density(width: usize, height: usize, tiles: f64, most: usize) -> Density {
    let wanted = 2.0 * width as f64 * height as f64 * tiles.max(0.0);
    let triangles = wanted.min(most as f64).max(1.0);
    Density {
        triangles: triangles as usize,
        vertices_per_texel: (triangles / wanted.max(1.0)).sqrt().min(1.0),
    }
}

/// The mesh with each vertex moved along its normal by `amount` x height; its normals and tangents stay, for normal maps
/// that tell of the same relief.
///
/// `height_mm` is read bilinearly, texel centres at half texels, and repeats. Vertices at one place move as one, by the mean
/// of their shifts, so that a closed mesh stays closed.
pub fn shift(mesh: &Mesh, height_mm: &Plane, amount: f32, mm_per_unit: f32) -> Result<Mesh, DisplaceError> {
    moved(mesh, height_mm, amount, mm_per_unit, &places(mesh))
}

/// The same with normals of the new surface: means of the triangles' at a place, weighted by their angles, where the old
/// normals of the place agree; tangents are new as well.
pub fn displace(
    mesh: &Mesh,
    height_mm: &Plane,
    amount: f32,
    mm_per_unit: f32,
) -> Result<Mesh, DisplaceError> {
    let places = places(mesh);
    let mut out = moved(mesh, height_mm, amount, mm_per_unit, &places)?;
    out.normals = smooth_normals(&out.positions, &out.triangles, &places, Some(&mesh.normals));
    Ok(tangents::generate(&out)?)
}

fn moved(
    mesh: &Mesh,
    height_mm: &Plane,
    amount: f32,
    mm_per_unit: f32,
    places: &[usize],
) -> Result<Mesh, DisplaceError> {
    mesh.check_shape()?;
    if height_mm.data().is_empty() {
        return Err(DisplaceError::Empty);
    }
    let finite = height_mm.data().iter().all(|h| h.is_finite()) && amount.is_finite();
    if !(finite && mm_per_unit > 0.0 && mm_per_unit.is_finite()) {
        return Err(DisplaceError::NotFinite);
    }
    let mut shifts = vec![(DVec3::ZERO, 0u32); mesh.positions.len()];
    for (i, &place) in places.iter().enumerate() {
        let height = sample(height_mm, mesh.uvs[i]) * amount / mm_per_unit;
        let (sum, count) = shifts[place];
        shifts[place] = (sum + (mesh.normals[i] * height).as_dvec3(), count + 1);
    }
    let mut out = mesh.clone();
    for (position, &place) in out.positions.iter_mut().zip(places) {
        let (sum, count) = shifts[place];
        *position += (sum / f64::from(count.max(1))).as_vec3();
    }
    if !out.positions.iter().all(|p| p.is_finite()) {
        return Err(DisplaceError::NotFinite);
    }
    Ok(out)
}

/// The height at a texture coordinate, toroidal.
fn sample(plane: &Plane, uv: Vec2) -> f32 {
    let wrapped = uv - uv.floor();
    plane.rows().bilinear(wrapped.x * plane.width() as f32, wrapped.y * plane.height() as f32)
}

/// For each vertex the first one at its place whose normal is near its own: edges stay sharp, seams do not show.
fn places(mesh: &Mesh) -> Vec<usize> {
    let mut known: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
    (0..mesh.positions.len())
        .map(|i| {
            let here = known.entry((mesh.positions[i] + 0.0).to_array().map(f32::to_bits)).or_default();
            let same = here.iter().copied().find(|&j| mesh.normals[i].dot(mesh.normals[j]) > 0.9);
            same.unwrap_or_else(|| {
                here.push(i);
                i
            })
        })
        .collect()
}

/// Normals by the angles of the triangles at a place (Thuermer & Wuethrich 1998); where that is nothing, the former or +y.
pub(super) fn smooth_normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    places: &[usize],
    former: Option<&[Vec3]>,
) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let p = triangle.map(|i| positions[i as usize].as_dvec3());
        let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
        for i in 0..3 {
            let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let angle = libm::atan2(a.cross(b).length(), a.dot(b));
            sums[places[triangle[i] as usize]] += normal * angle;
        }
    }
    let or_else = |i: usize| former.map_or(Vec3::Y, |normals| normals[i]);
    let unit = |(i, &place): (usize, &usize)| {
        sums[place].try_normalize().map_or_else(|| or_else(i), |normal| normal.as_vec3())
    };
    places.iter().enumerate().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::plain;

    const TILE: [f32; 2] = [60.0, 90.0];

    #[test]
    fn a_constant_height_makes_a_greater_sphere() {
        let sphere = plain::capsule(0.0, 4608, TILE).unwrap();
        let middle = Vec3::Y * 0.5;
        let unit = TILE[0] / std::f32::consts::PI;
        let out = displace(&sphere, &Plane::filled(4, 4, 0.2 * unit), 0.5, unit).unwrap();
        out.check().unwrap();
        assert!(out.is_closed());
        for (p, n) in out.positions.iter().zip(&out.normals) {
            let p = *p - middle;
            assert!((p.length() - 0.6).abs() < 1e-4, "{p}");
            assert!(n.dot(p.normalize()) > 0.998);
        }
    }

    #[test]
    fn a_wave_has_the_normals_of_its_slope() {
        // Height a cos(2 pi 2 u) on a tile pi wide: slope 4 a sin by the unit of length.
        let plane = plain::tile(400_000, TILE).unwrap();
        let (unit, a) = (TILE[0] / std::f32::consts::PI, 0.05f32);
        let cosine = |x: f64| (std::f64::consts::TAU * 2.0 * x).cos() as f32;
        let map = Plane::from_fn(512, 2, |x, _| a * unit * cosine((x as f64 + 0.5) / 512.0));
        let out = displace(&plane, &map, 1.0, unit).unwrap();
        let shifted = shift(&plane, &map, 1.0, unit).unwrap();
        assert!(
            shifted.positions.iter().all(|p| (p.z - a).abs() < 2.001 * a) && shifted.normals == plane.normals
        );
        let mut steepest = 0f32;
        for ((p, n), uv) in out.positions.iter().zip(&out.normals).zip(&out.uvs) {
            let phase = 4.0 * std::f32::consts::PI * uv.x;
            assert!((p.z - a * phase.cos()).abs() < 1e-4);
            let slope = 4.0 * a * phase.sin();
            if p.x.abs() < 1.55 {
                assert!((n.x / n.z - slope).abs() < 4e-3, "{} {slope}", n.x / n.z);
                steepest = steepest.max(slope.abs());
            }
        }
        assert!(steepest > 0.19);
    }

    #[test]
    fn density_is_a_vertex_for_each_texel_or_what_the_limit_leaves() {
        assert_eq!(density(64, 32, 2.0, 1 << 20), Density { triangles: 8192, vertices_per_texel: 1.0 });
        assert_eq!(density(64, 32, 2.0, 2048), Density { triangles: 2048, vertices_per_texel: 0.5 });
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let plane = plain::tile(32, TILE).unwrap();
        let zero = Plane::filled(1, 1, 0.0);
        assert_eq!(displace(&plane, &zero, f32::NAN, 1.0), Err(DisplaceError::NotFinite));
        assert_eq!(displace(&plane, &zero, 1.0, 0.0), Err(DisplaceError::NotFinite));
        assert_eq!(
            displace(&plane, &Plane::filled(1, 1, f32::INFINITY), 1.0, 1.0),
            Err(DisplaceError::NotFinite)
        );
        assert_eq!(displace(&plane, &Plane::filled(0, 0, 0.0), 1.0, 1.0), Err(DisplaceError::Empty));
    }
}
