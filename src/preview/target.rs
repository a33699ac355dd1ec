//! What is drawn into, and how it comes back.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};

use super::{Gpu, PreviewError};

/// Linear light.
pub(super) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel's edges.
const SAMPLES: u32 = 4;

/// How pipelines that draw into a target treat edges.
pub(super) fn multisample() -> wgpu::MultisampleState {
    wgpu::MultisampleState { count: SAMPLES, ..Default::default() }
}

/// How pipelines that draw into a target treat depth: 1 is near, 0 is far.
pub(super) fn depth(compare: wgpu::CompareFunction, write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// A picture in the making.
#[derive(Debug)]
pub(super) struct Target {
    size: [usize; 2],
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    pixels: wgpu::Texture,
    whole: wgpu::TextureView,
    buffer: wgpu::Buffer,
    row_bytes: u32,
}

impl Target {
    /// A target of this many columns and rows.
    ///
    /// # Errors
    /// If there are none, or more than the adapter holds.
    pub(super) fn new(gpu: &Gpu, [width, height]: [usize; 2]) -> Result<Self, PreviewError> {
        if width == 0 || height == 0 {
            return Err(PreviewError::Empty(width, height));
        }
        let limits = gpu.device.limits();
        let side = width.max(height) as u64;
        gpu.fits("a side of the picture in pixels", side, u64::from(limits.max_texture_dimension_2d))?;
        let row_bytes = (8 * width as u32).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * height as u64;
        gpu.fits("the picture in bytes", bytes, limits.max_buffer_size)?;
        let texture = |label, sample_count, format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let pixels = texture("picture", 1, FORMAT, attachment | wgpu::TextureUsages::COPY_SRC);
        Ok(Self {
            size: [width, height],
            samples: view(&texture("samples", SAMPLES, FORMAT, attachment)),
            depth: view(&texture("depth", SAMPLES, DEPTH, attachment)),
            whole: view(&pixels),
            pixels,
            buffer: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
            row_bytes,
        })
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Size on the device.
    pub(super) fn bytes(&self) -> u64 {
        let pixels = (self.size[0] * self.size[1]) as u64;
        pixels * u64::from(SAMPLES * (8 + 4) + 8) + self.buffer.size()
    }

    /// Begin to draw on a black picture.
    pub(super) fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.samples,
                depth_slice: None,
                resolve_target: Some(&self.whole),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: times,
            ..Default::default()
        })
    }

    /// Copy the picture to where it can be read.
    pub(super) fn copy(&self, encoder: &mut wgpu::CommandEncoder) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.row_bytes),
            rows_per_image: None,
        };
        encoder.copy_texture_to_buffer(
            self.pixels.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout },
            self.pixels.size(),
        );
    }

    /// The picture, once everything submitted is done.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn read(&self, gpu: &Gpu) -> Result<Vec<[f32; 3]>, PreviewError> {
        let bytes = read(gpu, &self.buffer)?;
        let mut row = vec![0.0; 4 * self.size[0]];
        let mut texels = Vec::with_capacity(self.size[0] * self.size[1]);
        for line in bytes.chunks_exact(self.row_bytes as usize) {
            let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&line[..8 * self.size[0]]);
            halves.reinterpret_cast::<f16>().convert_to_f32_slice(&mut row);
            texels.extend(row.chunks_exact(4).map(|t| [t[0], t[1], t[2]]));
        }
        Ok(texels)
    }
}

/// The bytes of a buffer that can be read, once everything submitted is done.
///
/// # Errors
/// If the device fails.
pub(super) fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, PreviewError> {
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.wait()?;
    let range = buffer.get_mapped_range(..).map_err(|e| PreviewError::Lost(e.to_string()))?;
    let bytes = range.to_vec();
    drop(range);
    buffer.unmap();
    Ok(bytes)
}
