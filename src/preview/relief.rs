//! The height map on the device, for maps that are looked up where a ray of view meets its relief: see relief.wgsl.

use std::f32::consts::PI;

use half::f16;
use rayon::prelude::*;
use wgpu::util::DeviceExt;

use super::Gpu;
use super::levels::halve;
use super::textures::upload;
use crate::base::num;
use crate::scene::SkinMaps;

/// Heights, and what they stand for.
#[derive(Debug)]
pub(super) struct Relief {
    /// `relief_map`, from the lowest height to the highest.
    pub(super) heights: wgpu::TextureView,
    /// `relief`.
    pub(super) block: wgpu::Buffer,
    /// On the device.
    pub(super) bytes: u64,
}

impl Relief {
    /// Of the height map, `amount` times as high; `None` where there is none, or all of it is one height.
    pub(super) fn new(gpu: &Gpu, maps: &SkinMaps, amount: f32) -> Option<Self> {
        let (levels, block) = levels(maps, amount)?;
        let contents = bytemuck::cast_slice(&block);
        let usage = wgpu::BufferUsages::UNIFORM;
        let descriptor = wgpu::util::BufferInitDescriptor { label: Some("relief"), contents, usage };
        let block = gpu.device.create_buffer_init(&descriptor);
        let data: Vec<u16> = levels.iter().flatten().map(|height| f16::from_f32(*height).to_bits()).collect();
        let bytes = bytemuck::cast_slice(&data);
        let size = [maps.width, maps.height, 1];
        let texture = upload(gpu, "relief", wgpu::TextureFormat::R16Float, size, levels.len(), bytes);
        let heights = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Some(Self { heights, block, bytes: bytes.len() as u64 })
    }
}

/// Levels of heights from 0, the lowest, to 1; and the lowest, with the range above it, in units of the scene. What is not finite
/// is the lowest.
fn levels(maps: &SkinMaps, amount: f32) -> Option<(Vec<Vec<f32>>, [f32; 4])> {
    let scale = amount * PI / maps.size_mm[0];
    let scaled: Vec<f32> = maps.height_mm.as_ref()?.par_iter().map(|h| h * scale).collect();
    let (low, high) = num::min_max(&scaled);
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return None;
    }
    let share = |height: &f32| if height.is_finite() { (height - low) / range } else { 0.0 };
    let mut levels: Vec<Vec<f32>> = vec![scaled.par_iter().map(share).collect()];
    let (mut width, mut height) = (maps.width, maps.height);
    while width.max(height) > 1 {
        let last = &levels[levels.len() - 1];
        let next = halve(width, height, |i| last[i], |sum: &mut f32, value, weight| *sum += weight * value);
        levels.push(next);
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    Some((levels, [low, range, 0.0, 0.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(height_mm: Option<Vec<f32>>) -> SkinMaps {
        SkinMaps { width: 3, height: 2, texels: Vec::new(), height_mm, size_mm: [PI, 2.0] }
    }

    #[test]
    fn heights_are_shares_of_their_range_and_means_of_levels() {
        let (all, block) =
            levels(&maps(Some(vec![-1.0, 0.0, 1.0, 1.0, 0.0, f32::NAN])), 2.0).expect("a relief");
        assert_eq!(block, [-2.0, 4.0, 0.0, 0.0]);
        assert_eq!(all[0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0]);
        assert_eq!((all.len(), all[1].len()), (2, 1));
        assert!((all[1][0] - 0.5).abs() < 1e-6);
        // Turned inside out.
        let (all, block) = levels(&maps(Some(vec![0.0, 1.0, 0.0, 0.0, 0.0, 0.0])), -1.0).expect("a relief");
        assert_eq!((block, &all[0][..]), ([-1.0, 1.0, 0.0, 0.0], &[1.0, 0.0, 1.0, 1.0, 1.0, 1.0][..]));
    }

    #[test]
    fn nothing_and_what_is_even_have_no_relief() {
        let flat = Some(vec![0.3; 6]);
        assert!(levels(&maps(None), 1.0).is_none() && levels(&maps(flat), 1.0).is_none());
        assert!(levels(&maps(Some(vec![f32::NAN; 6])), 1.0).is_none());
        assert!(levels(&maps(Some(vec![0.0, 1.0, 0.0, 0.0, 0.0, 0.0])), 0.0).is_none());
    }
}
