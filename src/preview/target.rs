//! What is drawn into, and how it comes back.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use rayon::prelude::*;

use super::deferred::{self, Recorded};
use super::{Gpu, PreviewError};

/// Linear light.
pub(super) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel's edges.
const SAMPLES: u32 = 4;

/// Where colours of objects are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shading {
    /// Once for each triangle that a pixel shows, into its samples.
    Triangles,
    /// Once for each pixel, beforehand; samples take these colours.
    Pixels,
    /// Once for each pixel, without samples: pictures are averaged.
    Middles,
}

impl Shading {
    /// For pixels that are shaded once, or not, and of which so many pictures are averaged.
    pub(super) fn of(once: bool, pictures: u32) -> Self {
        match once {
            _ if pictures >= SAMPLES => Self::Middles,
            true => Self::Pixels,
            false => Self::Triangles,
        }
    }

    /// Samples of what is shaded.
    fn samples(self) -> u32 {
        if self == Self::Triangles { SAMPLES } else { 1 }
    }

    /// How pipelines treat edges.
    pub(super) fn multisample(self) -> wgpu::MultisampleState {
        wgpu::MultisampleState { count: self.samples(), ..Default::default() }
    }
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
    pub(super) shading: Shading,
    /// What is shaded: samples, or pixels.
    pub(super) color: wgpu::TextureView,
    /// Of what is shaded.
    pub(super) depth: wgpu::TextureView,
    /// Depths of samples, where pixels are shaded.
    pub(super) samples: Option<wgpu::TextureView>,
    /// What is recorded before it is shaded.
    pub(super) recorded: Option<Recorded>,
    /// The picture.
    pub(super) pixels: wgpu::Texture,
    whole: wgpu::TextureView,
    buffer: wgpu::Buffer,
    row_bytes: u32,
}

impl Target {
    /// A target of this many columns and rows, shaded like this, with a record of triangles or not.
    ///
    /// # Errors
    /// If there are none, or more than the adapter holds.
    pub(super) fn new(
        gpu: &Gpu,
        [width, height]: [usize; 2],
        shading: Shading,
        recorded: bool,
    ) -> Result<Self, PreviewError> {
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
        let read = attachment | wgpu::TextureUsages::TEXTURE_BINDING;
        let pixels = texture("picture", 1, FORMAT, read | wgpu::TextureUsages::COPY_SRC);
        let used = if shading == Shading::Pixels { read } else { attachment };
        let depth_use = if shading == Shading::Triangles { attachment } else { read };
        let depth = view(&texture("depths", shading.samples(), DEPTH, depth_use));
        let samples = || view(&texture("depths of samples", SAMPLES, DEPTH, read));
        Ok(Self {
            size: [width, height],
            shading,
            color: match shading {
                Shading::Middles => view(&pixels),
                _ => view(&texture("colors", shading.samples(), FORMAT, used)),
            },
            recorded: recorded.then(|| Recorded::new(gpu, [width, height], &depth)),
            depth,
            samples: (shading == Shading::Pixels).then(samples),
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
        let texel = match self.shading {
            Shading::Triangles => SAMPLES * (8 + 4) + 8,
            Shading::Pixels => (8 + 4) + SAMPLES * 4 + 8,
            Shading::Middles => 8 + 4,
        };
        let recorded = if self.recorded.is_some() { deferred::BYTES } else { 0 };
        pixels * u64::from(texel + recorded) + self.buffer.size()
    }

    /// Begin to shade samples, which become the picture, or pixels: on black, or on what was recorded; on the depths that are there
    /// if `measured` or recorded.
    pub(super) fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        measured: bool,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        let (resolved, store) = match self.shading {
            Shading::Triangles => (Some(&self.whole), wgpu::StoreOp::Discard),
            Shading::Pixels | Shading::Middles => (None, wgpu::StoreOp::Store),
        };
        let there = self.recorded.is_some();
        let mut color = onto(&self.color, resolved, store);
        if there {
            color.ops.load = wgpu::LoadOp::Load;
        }
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(color)],
            depth_stencil_attachment: Some(before(&self.depth, measured || there, store)),
            timestamp_writes: times,
            ..Default::default()
        })
    }

    /// Begin to shade what was recorded, on black.
    pub(super) fn begin_deferred<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        let read =
            wgpu::RenderPassDepthStencilAttachment { view: &self.depth, depth_ops: None, stencil_ops: None };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("deferred"),
            color_attachments: &[Some(onto(&self.color, None, wgpu::StoreOp::Store))],
            depth_stencil_attachment: Some(read),
            timestamp_writes: times,
            ..Default::default()
        })
    }

    /// Begin to draw depths of samples.
    pub(super) fn begin_depths<'e>(
        samples: &wgpu::TextureView,
        encoder: &'e mut wgpu::CommandEncoder,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depths of samples"),
            depth_stencil_attachment: Some(before(samples, false, wgpu::StoreOp::Store)),
            timestamp_writes: times,
            ..Default::default()
        })
    }

    /// Begin to draw the picture itself.
    pub(super) fn begin_whole<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        times: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("edges"),
            color_attachments: &[Some(onto(&self.whole, None, wgpu::StoreOp::Store))],
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

    /// Add the picture to a sum, which may be empty, once everything submitted is done.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn add_to(&self, gpu: &Gpu, sum: &mut Vec<[f32; 3]>) -> Result<(), PreviewError> {
        let [width, height] = self.size;
        sum.resize(width * height, [0.0; 3]);
        let lines = sum.par_chunks_exact_mut(width);
        read(gpu, &self.buffer, |bytes| {
            let halves: &[u16] = bytemuck::cast_slice(bytes);
            let rows = halves.par_chunks_exact(self.row_bytes as usize / 2);
            lines.zip(rows).for_each_init(
                || vec![0.0; 4 * width],
                |row, (line, halves)| {
                    halves[..4 * width].reinterpret_cast::<f16>().convert_to_f32_slice(row);
                    for (sum, texel) in line.iter_mut().zip(row.chunks_exact(4)) {
                        for c in 0..3 {
                            sum[c] += texel[c];
                        }
                    }
                },
            );
        })
    }
}

/// Colours onto black.
pub(super) fn onto<'v>(
    view: &'v wgpu::TextureView,
    resolve_target: Option<&'v wgpu::TextureView>,
    store: wgpu::StoreOp,
) -> wgpu::RenderPassColorAttachment<'v> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops }
}

/// Depths before what is at the far end, or those that are there.
pub(super) fn before(
    view: &wgpu::TextureView,
    there: bool,
    store: wgpu::StoreOp,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    let load = if there { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(0.0) };
    let depth_ops = Some(wgpu::Operations { load, store });
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
}

/// What becomes of the bytes of a buffer that can be read, once everything submitted is done.
///
/// # Errors
/// If the device fails.
pub(super) fn read<T>(
    gpu: &Gpu,
    buffer: &wgpu::Buffer,
    use_bytes: impl FnOnce(&[u8]) -> T,
) -> Result<T, PreviewError> {
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.wait()?;
    let range = buffer.get_mapped_range(..).map_err(|e| PreviewError::Lost(e.to_string()))?;
    let made = use_bytes(&range);
    drop(range);
    buffer.unmap();
    Ok(made)
}
