//! How long passes take on the device.

use super::target::read;
use super::{Gpu, PreviewError};

/// Most passes.
const MOST: u32 = 8;

/// Time stamps at both ends of passes.
#[derive(Debug)]
pub(super) struct Timing {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    /// Of one unit.
    nanoseconds: f64,
}

impl Timing {
    /// `None` where the adapter does not tell.
    pub(super) fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.has_timestamps() {
            return None;
        }
        let stamps = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST,
        });
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: u64::from(2 * MOST * wgpu::QUERY_SIZE),
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            stamps,
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
            nanoseconds: f64::from(gpu.queue.get_timestamp_period()),
        })
    }

    /// Where pass `i` puts its stamps.
    pub(super) fn pair(&self, i: usize) -> wgpu::RenderPassTimestampWrites<'_> {
        let first = 2 * (i as u32).min(MOST - 1);
        wgpu::RenderPassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Copy the stamps of the first passes to where they can be read.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, passes: usize) {
        let stamps = 2 * (passes as u32).min(MOST);
        encoder.resolve_query_set(&self.stamps, 0..stamps, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, self.readable.size());
    }

    /// Milliseconds of the first passes, once everything submitted is done.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn read(&self, gpu: &Gpu, passes: usize) -> Result<Vec<Option<f64>>, PreviewError> {
        let stamps: Vec<u64> = read(gpu, &self.readable, bytemuck::pod_collect_to_vec)?;
        let milliseconds = |i: usize| {
            let (start, end) = (*stamps.get(2 * i)?, *stamps.get(2 * i + 1)?);
            Some(end.saturating_sub(start) as f64 * self.nanoseconds * 1e-6)
        };
        Ok((0..passes).map(milliseconds).collect())
    }
}
