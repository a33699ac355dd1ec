//! Meshes on the device.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::util::DeviceExt;

use super::{Gpu, PreviewError};
use crate::scene::Mesh;

/// `Vertex` of surface.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    tangent: [f32; 4],
    uv: [f32; 2],
}

/// Its attributes.
const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2];

/// How vertices lie in memory.
pub(super) const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Vertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &ATTRIBUTES,
};

/// Places alone.
pub(super) const PLACES: wgpu::VertexBufferLayout<'static> =
    wgpu::VertexBufferLayout { attributes: ATTRIBUTES.split_at(1).0, ..LAYOUT };

/// How triangles are drawn: all of them, or those that face the eye, where no other is seen.
pub(super) fn sides(hides_backs: bool) -> wgpu::PrimitiveState {
    wgpu::PrimitiveState { cull_mode: hides_backs.then_some(wgpu::Face::Back), ..Default::default() }
}

/// A mesh on the device.
#[derive(Debug)]
pub(super) struct DeviceMesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    /// Least and greatest corner of what is closed.
    body: Option<[Vec3; 2]>,
}

impl DeviceMesh {
    /// Copy a mesh, which must be sound: see [`Mesh::check`]. `None` if it has no triangles.
    ///
    /// # Errors
    /// If it is larger than the adapter can hold.
    pub(super) fn new(gpu: &Gpu, name: &str, mesh: &Mesh) -> Result<Option<Self>, PreviewError> {
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let lists = mesh.positions.iter().zip(&mesh.normals).zip(mesh.tangents.iter().zip(&mesh.uvs));
        let vertices: Vec<Vertex> = lists
            .map(|((position, normal), (tangent, uv))| Vertex {
                position: position.to_array(),
                normal: normal.to_array(),
                tangent: tangent.to_array(),
                uv: uv.to_array(),
            })
            .collect();
        Ok(Some(Self {
            vertices: buffer(gpu, name, bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX)?,
            indices: buffer(gpu, name, bytemuck::cast_slice(&mesh.triangles), wgpu::BufferUsages::INDEX)?,
            count: 3 * mesh.triangles.len() as u32,
            body: is_closed(mesh).then(|| mesh.bounds()),
        }))
    }

    /// Draw all of it with what the pass is set to.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
    }

    /// Whether none of its triangles is seen from behind: it is a closed body, and the eye not near.
    pub(super) fn hides_backs(&self, eye: Vec3) -> bool {
        self.body.is_some_and(|[low, high]| {
            let room = 0.1 * (high - low).max_element();
            (eye.cmplt(low - room) | eye.cmpgt(high + room)).any()
        })
    }

    /// Size on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.vertices.size() + self.indices.size()
    }

    /// Triangles.
    pub(super) fn triangles(&self) -> u32 {
        self.count / 3
    }
}

/// Whether every edge of a mesh is that of another triangle the other way round, and its inside is inside.
fn is_closed(mesh: &Mesh) -> bool {
    let corner = |i: u32| mesh.positions[i as usize];
    // Sums of hashes of edges from one place to another, less those of the way back: of what is closed, all cancel.
    let one = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        let [i, j, k] = [a, b, c].map(hash_of);
        let edge =
            |from: u64, to: u64| mix(from ^ to.rotate_left(32)).wrapping_sub(mix(to ^ from.rotate_left(32)));
        let edges = edge(i, j).wrapping_add(edge(j, k)).wrapping_add(edge(k, i));
        (edges, f64::from(a.dot(b.cross(c))))
    };
    let (edges, volume) = mesh
        .triangles
        .iter()
        .map(one)
        .fold((0_u64, 0.0), |(e, v), (edge, volume)| (e.wrapping_add(edge), v + volume));
    edges == 0 && volume > 0.0
}

/// Scatters bits (Steele et al. 2014, SplitMix).
fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Of a place; 0 and -0 are one.
fn hash_of(place: Vec3) -> u64 {
    let [x, y, z] = (place + 0.0).to_array().map(|c| u64::from(c.to_bits()));
    mix(x ^ mix(y ^ mix(z)))
}

/// A buffer with these bytes.
///
/// # Errors
/// If it is larger than the adapter can hold.
pub(super) fn buffer(
    gpu: &Gpu,
    name: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, PreviewError> {
    gpu.fits("a mesh in bytes", contents.len() as u64, gpu.device.limits().max_buffer_size)?;
    let descriptor = wgpu::util::BufferInitDescriptor { label: Some(name), contents, usage };
    Ok(gpu.device.create_buffer_init(&descriptor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Inputs, Scene, SceneSpec};

    #[test]
    fn snakes_are_closed_and_what_has_a_hole_or_is_turned_inside_out_is_not() {
        let mut spec = SceneSpec::default();
        spec.subject.triangles = 2000;
        let scene = Scene::build(&spec, &Inputs::default()).expect("it can be built");
        let whole = &scene.objects[0].mesh;
        assert!(is_closed(whole));
        let mut open = whole.clone();
        open.triangles.pop();
        let mut inside_out = whole.clone();
        inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let mut one_turned = whole.clone();
        one_turned.triangles[7].swap(0, 1);
        for mesh in [open, inside_out, one_turned, scene.objects[1].mesh.clone(), Mesh::default()] {
            assert!(!is_closed(&mesh));
        }
    }
}
