//! Triangles with everything that shading needs at their corners.

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
