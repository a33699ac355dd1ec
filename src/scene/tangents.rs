//! Tangents by MikkTSpace, the convention that normal maps are baked with.

use std::collections::BTreeMap;

use glam::Vec4;
use mikktspace::Geometry;

use super::mesh::{Mesh, MeshError};

/// Triangles that may meet in one vertex: the algorithm walks around a vertex by recursion.
const MOST_AROUND_A_VERTEX: usize = 10_000;

/// Why a mesh has no tangents.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TangentError {
    /// The mesh itself is broken.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// One vertex has too many triangles.
    #[error("{0} triangles meet in one vertex; tangents can be made for {MOST_AROUND_A_VERTEX}")]
    Fan(usize),
    /// No triangle, or none that has an extent, or one that is not finite.
    #[error("the mesh has no triangle to take a tangent from")]
    Empty,
}

/// The mesh with tangents as [`Mesh::tangents`] describes; those it had are replaced.
///
/// Source: Mikkelsen 2008, Simulation of Wrinkled Surfaces Revisited, in his own implementation, over (u, 1 - v). A vertex
/// whose corners have different tangents is split. Vertices that no triangle uses are dropped. Where texture coordinates
/// are degenerate a tangent square to the normal is chosen.
pub fn generate(mesh: &Mesh) -> Result<Mesh, TangentError> {
    mesh.check_shape()?;
    let mut around = BTreeMap::new();
    for corner in mesh.triangles.iter().flatten() {
        let p = mesh.positions[*corner as usize];
        *around.entry(p.to_array().map(f32::to_bits)).or_insert(0usize) += 1;
    }
    // The algorithm sorts places into cells along the longest axis, which must have a length.
    let places = || around.keys().map(|place| glam::Vec3::from(place.map(f32::from_bits)));
    let (low, high) = places()
        .fold((glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let extent = (high - low).max_element();
    if !(extent > 0.0 && extent < f32::INFINITY) {
        return Err(TangentError::Empty);
    }
    let most = around.into_values().max().ok_or(TangentError::Empty)?;
    if most > MOST_AROUND_A_VERTEX {
        return Err(TangentError::Fan(most));
    }
    let mut corners = Corners { mesh, tangents: vec![[0.0; 4]; mesh.triangles.len() * 3] };
    if !mikktspace::generate_tangents(&mut corners) {
        return Err(TangentError::Empty);
    }
    Ok(split(mesh, &corners.tangents))
}

/// What MikkTSpace asks about the mesh, and what it answers for each corner.
struct Corners<'a> {
    mesh: &'a Mesh,
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.uvs[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }
    fn set_tangent_encoded(&mut self, tangent: [f32; 4], face: usize, corner: usize) {
        self.tangents[face * 3 + corner] = tangent;
    }
}

/// The mesh with a vertex for each pair of an old vertex and a tangent, in the order in which corners name them.
fn split(mesh: &Mesh, corners: &[[f32; 4]]) -> Mesh {
    let mut out = Mesh { triangles: mesh.triangles.clone(), ..Mesh::default() };
    // For each old vertex the new ones made of it; nearly always one.
    let mut made: Vec<Vec<u32>> = vec![vec![]; mesh.positions.len()];
    for (corner, tangent) in out.triangles.iter_mut().flatten().zip(corners) {
        let old = *corner as usize;
        let tangent = orthonormal(mesh, old, *tangent);
        let known = made[old].iter().find(|&&new| out.tangents[new as usize] == tangent);
        *corner = known.copied().unwrap_or_else(|| {
            let new = out.positions.len() as u32;
            out.positions.push(mesh.positions[old]);
            out.normals.push(mesh.normals[old]);
            out.uvs.push(mesh.uvs[old]);
            out.tangents.push(tangent);
            made[old].push(new);
            new
        });
    }
    out
}

/// The tangent, made square to the vertex's normal; any such if it has no direction.
fn orthonormal(mesh: &Mesh, vertex: usize, [x, y, z, w]: [f32; 4]) -> Vec4 {
    let normal = mesh.normals[vertex];
    let raw = glam::Vec3::new(x, y, z);
    let across = raw - normal * raw.dot(normal);
    let unit =
        if across.length_squared() > 1e-12 { across.normalize() } else { normal.any_orthonormal_vector() };
    unit.extend(if w < 0.0 { -1.0 } else { 1.0 })
}
