//! Meshes on the device.

use bytemuck::{Pod, Zeroable};
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

/// A mesh on the device.
#[derive(Debug)]
pub(super) struct DeviceMesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
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
        }))
    }

    /// Draw all of it with what the pass is set to.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
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
