//! Triangles with everything that shading needs at their corners.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

/// An indexed triangle mesh. All vertex lists have equal length, and every index is below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Places, in scene units.
    pub positions: Vec<Vec3>,
    /// Unit normals, outward.
    pub normals: Vec<Vec3>,
    /// Unit tangents along growing u, and in w the sign of the bitangent: `b = w cross(n, t)`, which is the way that green
    /// of an OpenGL normal map points: up the image, towards smaller v (MikkTSpace over (u, 1 - v), as glTF does).
    pub tangents: Vec<Vec4>,
    /// Texture coordinates in tiles: any real number, the tile repeats; u around the body, v along it, tail-ward.
    pub uvs: Vec<Vec2>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// What is wrong with a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// The lists do not fit each other.
    #[error("{positions} positions, but {found} {list}")]
    Lengths {
        /// Positions.
        positions: usize,
        /// Entries of the other list.
        found: usize,
        /// Which list that is.
        list: &'static str,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    Index {
        /// Which triangle, from 0.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A number is infinite or none.
    #[error("vertex {0} has a number that is not finite")]
    NotFinite(usize),
    /// A normal or tangent is not of unit length.
    #[error("vertex {0} has a normal or tangent whose length is not 1")]
    NotUnit(usize),
}

impl Mesh {
    /// Least and greatest corner; zero for an empty mesh.
    pub fn bounds(&self) -> [Vec3; 2] {
        let Some(&first) = self.positions.first() else { return [Vec3::ZERO; 2] };
        self.positions.iter().fold([first; 2], |[low, high], &p| [low.min(p), high.max(p)])
    }

    /// Sum of the triangles' areas, in square scene units. The mesh must be valid.
    pub fn area(&self) -> f64 {
        let corners = |t: &[u32; 3]| t.map(|i| self.positions[i as usize].as_dvec3());
        self.triangles.iter().map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Checks what the type promises: lists of equal length, indices below it, finite numbers, unit directions.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_shape()?;
        self.check_length(self.tangents.len(), "tangents")?;
        let unit = |t: &Vec4| (t.truncate().length() - 1.0).abs() < 1e-3 && t.w.abs() == 1.0;
        self.tangents.iter().position(|t| !unit(t)).map_or(Ok(()), |i| Err(MeshError::NotUnit(i)))
    }

    /// As [`Mesh::check`], without the tangents.
    pub fn check_shape(&self) -> Result<(), MeshError> {
        self.check_length(self.normals.len(), "normals")?;
        self.check_length(self.uvs.len(), "texture coordinates")?;
        let finite = |i: usize| {
            self.positions[i].is_finite() && self.normals[i].is_finite() && self.uvs[i].is_finite()
        };
        let vertices = self.positions.len();
        if let Some(i) = (0..vertices).find(|&i| !finite(i)) {
            return Err(MeshError::NotFinite(i));
        }
        if let Some(i) = self.normals.iter().position(|n| (n.length() - 1.0).abs() >= 1e-3) {
            return Err(MeshError::NotUnit(i));
        }
        let corners = self.triangles.iter().enumerate().flat_map(|(i, t)| t.map(|vertex| (i, vertex)));
        match corners.into_iter().find(|&(_, vertex)| vertex as usize >= vertices) {
            Some((triangle, vertex)) => Err(MeshError::Index { triangle, vertex, vertices }),
            None => Ok(()),
        }
    }

    fn check_length(&self, found: usize, list: &'static str) -> Result<(), MeshError> {
        let positions = self.positions.len();
        if found == positions { Ok(()) } else { Err(MeshError::Lengths { positions, found, list }) }
    }

    /// Whether the surface has no border: each edge is run through as often one way as the other, vertices of one place
    /// being one.
    pub fn is_closed(&self) -> bool {
        let mut balance = BTreeMap::new();
        for triangle in &self.triangles {
            // Adding 0 makes -0 and 0 one place.
            let place = triangle.map(|i| (self.positions[i as usize] + 0.0).to_array().map(f32::to_bits));
            for i in 0..3 {
                let (a, b) = (place[i], place[(i + 1) % 3]);
                let (edge, way) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                if a != b {
                    *balance.entry(edge).or_insert(0i64) += way;
                }
            }
        }
        balance.into_values().all(|ways| ways == 0)
    }
}
