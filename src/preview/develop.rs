//! Pictures as a screen shows them, without a way back to memory before: bloom, exposure and tone curve on the device.
//!
//! What they are is said by [`scene::bloom`](crate::scene::bloom) and [`scene::tone`](crate::scene::tone), in f32, which make all
//! files; these passes are the same in halves and for windows, within 1/255 of them where tests look.

use std::collections::BTreeMap;

use wgpu::util::DeviceExt;

use super::program::Slot;
use super::slots::slots;
use super::target::{self, read};
use super::{Gpu, PreviewError, textures, whole};
use crate::scene::tone::ToneMap;

/// What is done to linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Share of the light that a lens spreads: see [`bloom`](crate::scene::bloom::bloom).
    pub bloom: f32,
    /// Power of two before the tone curve, after metering.
    pub exposure_ev: f32,
    /// What the geometric mean of luminances becomes, such as 0.18; `None` where light is not metered.
    pub mean: Option<f32>,
    /// The tone curve.
    pub tone: ToneMap,
}

/// Levels of bloom are not smaller than this many texels a side: `scene::bloom`.
const LEAST_SIDE: u32 = 4;
/// Texels of a side that a step of the meter sums.
const SQUARE: u32 = 8;
const SHOWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const SUMS: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// Passes that were needed before.
#[derive(Debug, Default)]
pub(super) struct Developer {
    /// By the files of their shaders.
    pipelines: BTreeMap<Vec<&'static str>, (wgpu::BindGroupLayout, wgpu::RenderPipeline)>,
}

/// Pixels of a picture in linear light, row by row from the top: red, green, blue and 255.
///
/// # Errors
/// If the device fails.
pub(super) fn develop(
    gpu: &Gpu,
    developer: &mut Developer,
    light: &wgpu::Texture,
    development: &Development,
) -> Result<Vec<u8>, PreviewError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut passes = Passes { gpu, developer, encoder: &mut encoder };
    let size = [light.width(), light.height()];
    let whole = view(light);
    let light = passes.bloom(whole, size, development.bloom);
    let meter = development.mean.map(|_| passes.meter(&light, size));
    let shown = passes.texture(size, SHOWN, wgpu::TextureUsages::COPY_SRC);
    passes.tone(&light, meter.as_ref(), &view(&shown), development);
    let row_bytes = (4 * size[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("shown"),
        size: u64::from(row_bytes) * u64::from(size[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
    let onto = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(shown.as_image_copy(), onto, shown.size());
    gpu.queue.submit([encoder.finish()]);
    read(gpu, &buffer, |bytes| {
        let rows = bytes.chunks_exact(row_bytes as usize);
        rows.flat_map(|row| &row[..4 * size[0] as usize]).copied().collect()
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// What a pass reads.
enum Source<'a> {
    Texture(&'a wgpu::TextureView),
    Block(&'a wgpu::Buffer),
}

impl Source<'_> {
    fn entry(&self, binding: u32) -> wgpu::BindGroupLayoutEntry {
        match self {
            Self::Block(_) => textures::uniform_entry(binding),
            Self::Texture(_) => textures::entry(
                binding,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ),
        }
    }

    fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Block(block) => block.as_entire_binding(),
        }
    }
}

struct Passes<'a> {
    gpu: &'a Gpu,
    developer: &'a mut Developer,
    encoder: &'a mut wgpu::CommandEncoder,
}

impl Passes<'_> {
    fn texture(
        &self,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        more: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("development"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | more,
            view_formats: &[],
        })
    }

    fn block(&self, numbers: [f32; 4]) -> wgpu::Buffer {
        self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("development"),
            contents: bytemuck::cast_slice(&numbers),
            usage: wgpu::BufferUsages::UNIFORM,
        })
    }

    /// Light as a lens spreads it.
    fn bloom(&mut self, light: wgpu::TextureView, size: [u32; 2], share: f32) -> wgpu::TextureView {
        // Not of a NaN, either.
        if share.is_nan() || share <= 0.0 {
            return light;
        }
        let mut levels = vec![(light.clone(), size)];
        while let Some((last, [width, height])) =
            levels.last().filter(|(_, size)| size[0].min(size[1]) >= 2 * LEAST_SIDE)
        {
            let half = [width.div_ceil(2), height.div_ceil(2)];
            let smaller = view(&self.texture(half, target::FORMAT, wgpu::TextureUsages::empty()));
            self.draw(&slots!["bloom_down"], "halve", target::FORMAT, &smaller, &[Source::Texture(last)]);
            levels.push((smaller, half));
        }
        // From the smallest up: each is the mean of itself and all below.
        let count = levels.len() - 1;
        let mut levels = levels.into_iter().rev();
        let Some((mut spread, _)) = levels.next() else { return light };
        for (below, (level, size)) in levels.enumerate() {
            let own = if below + 1 == count { 1.0 - share.min(1.0) } else { 1.0 / (below + 2) as f32 };
            let mixed = view(&self.texture(size, target::FORMAT, wgpu::TextureUsages::empty()));
            let block = self.block([own, 0.0, 0.0, 0.0]);
            let sources = [Source::Texture(&level), Source::Texture(&spread), Source::Block(&block)];
            self.draw(&slots!["bloom_up"], "mixed", target::FORMAT, &mixed, &sources);
            spread = mixed;
        }
        spread
    }

    /// Sum of the logarithms of luminances, and how many there are: one texel.
    fn meter(&mut self, light: &wgpu::TextureView, mut size: [u32; 2]) -> wgpu::TextureView {
        let mut sums: Option<wgpu::TextureView> = None;
        let [first, next, meter] = slots!["meter_first", "meter_next", "meter"];
        loop {
            size = size.map(|n| n.div_ceil(SQUARE));
            let onto = view(&self.texture(size, SUMS, wgpu::TextureUsages::empty()));
            let (file, source) = match &sums {
                None => (first, light),
                Some(sums) => (next, sums),
            };
            self.draw(&[meter, file], "sum", SUMS, &onto, &[Source::Texture(source)]);
            if size == [1, 1] {
                return onto;
            }
            sums = Some(onto);
        }
    }

    fn tone(
        &mut self,
        light: &wgpu::TextureView,
        meter: Option<&wgpu::TextureView>,
        onto: &wgpu::TextureView,
        development: &Development,
    ) {
        let [fixed, mean] = slots!["exposure_fixed", "exposure_mean"];
        let [clamp, reinhard, aces, agx, neutral] =
            slots!["tone_clamp", "tone_reinhard", "tone_aces", "tone_agx", "tone_neutral"];
        let curve = match development.tone {
            ToneMap::Clamp => clamp,
            ToneMap::Reinhard => reinhard,
            ToneMap::Aces => aces,
            ToneMap::Agx => agx,
            ToneMap::Neutral => neutral,
        };
        let target = development.mean.unwrap_or(1.0).max(f32::MIN_POSITIVE);
        let block = self.block([development.exposure_ev, libm::log2f(target), 0.0, 0.0]);
        let mut sources = vec![Source::Texture(light), Source::Block(&block)];
        sources.extend(meter.map(Source::Texture));
        let files = [slots!["develop"][0], if meter.is_some() { mean } else { fixed }, curve];
        self.draw(&files, "developed", SHOWN, onto, &sources);
    }

    /// A pass over all texels of `onto`.
    fn draw(
        &mut self,
        files: &[Slot],
        entry: &str,
        format: wgpu::TextureFormat,
        onto: &wgpu::TextureView,
        sources: &[Source<'_>],
    ) {
        let key = files.iter().map(|f| f.name).collect();
        let (layout, pipeline) = self.developer.pipelines.entry(key).or_insert_with(|| {
            let described: Vec<_> =
                (0..).zip(sources).map(|(binding, source)| source.entry(binding)).collect();
            pipeline(self.gpu, files, entry, format, &described)
        });
        let group = textures::group(self.gpu, "development", layout, sources.iter().map(Source::resource));
        let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("development"),
            color_attachments: &[Some(target::onto(onto, None, wgpu::StoreOp::Store))],
            ..Default::default()
        });
        whole::draw(&mut pass, pipeline, &[&group]);
    }
}

/// Draws a pass that reads so much.
fn pipeline(
    gpu: &Gpu,
    files: &[Slot],
    entry: &str,
    format: wgpu::TextureFormat,
    described: &[wgpu::BindGroupLayoutEntry],
) -> (wgpu::BindGroupLayout, wgpu::RenderPipeline) {
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("development"),
        entries: described,
    });
    let pipeline = whole::pipeline(gpu, "development", (files, entry), &[&layout], format, &[]);
    (layout, pipeline)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{LinearRgb, hash};
    use crate::preview::device::tests::gpu;
    use crate::scene::bloom::bloom;
    use crate::scene::tone::Metering;
    use half::f16;

    const SIZE: [usize; 2] = [61, 43];

    /// Light of many colours, as the target holds it; black, and so bright that it spreads, but not over all.
    fn light() -> Vec<[f32; 3]> {
        let unit = |i: usize| (hash::pcg(hash::pcg(i as u32)) >> 8) as f32 / (1 << 24) as f32;
        let texel = |i: usize| match i % 17 {
            0 => [0.0; 3],
            1 => [30.0; 3],
            _ => {
                let brightness = libm::exp2f(10.0 * unit(4 * i) - 8.0);
                [1, 2, 3].map(|c| f16::from_f32(brightness * unit(4 * i + c)).to_f32())
            }
        };
        (0..SIZE[0] * SIZE[1]).map(texel).collect()
    }

    fn texture(gpu: &Gpu, texels: &[[f32; 3]]) -> wgpu::Texture {
        let halves: Vec<[u16; 4]> =
            texels.iter().map(|t| [t[0], t[1], t[2], 1.0].map(|c| f16::from_f32(c).to_bits())).collect();
        let bytes = bytemuck::cast_slice(&halves);
        textures::upload(gpu, "light", target::FORMAT, [SIZE[0], SIZE[1], 1], 1, bytes)
    }

    /// The same by the functions that make files.
    fn expected(texels: &[[f32; 3]], d: &Development) -> Vec<[u8; 3]> {
        let mut texels = texels.to_vec();
        bloom(&mut texels, SIZE[0], d.bloom);
        let metered = d.mean.map_or(0.0, |mean| Metering::LogAverage(mean).exposure_ev(&texels));
        let shown = |t: &[f32; 3]| d.tone.encode(LinearRgb(*t), metered + d.exposure_ev);
        texels.iter().map(|t| shown(t).map(|c| (255.0 * c + 0.5) as u8)).collect()
    }

    /// Within 1/255 at each pixel; twice the light is not.
    #[test]
    fn windows_show_what_files_hold() {
        let Some(gpu) = gpu() else { return };
        let (light, mut developer) = (light(), Developer::default());
        let texture = texture(&gpu, &light);
        for tone in ToneMap::ALL {
            for (bloom, mean) in [(0.0, None), (0.2, None), (0.0, Some(0.18)), (1.0, Some(0.3))] {
                let d = Development { bloom, exposure_ev: -0.7, mean, tone };
                let pixels = develop(&gpu, &mut developer, &texture, &d).expect("a picture");
                let apart = |d: &Development| {
                    let pairs = pixels.chunks_exact(4).zip(expected(&light, d));
                    pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| a[c].abs_diff(b[c]))).max()
                };
                let worst = apart(&d);
                assert!(worst <= Some(1), "{d:?}: {worst:?}");
                let brighter = apart(&Development { exposure_ev: 0.3, ..d });
                assert!(brighter > Some(10), "{d:?}: {brighter:?}");
                assert!(pixels.chunks_exact(4).all(|p| p[3] == 255));
            }
        }
        // One for each shader.
        assert!(developer.pipelines.len() <= 14, "{}", developer.pipelines.len());
    }

    /// Nothing lit: no meter can tell, and black stays black.
    #[test]
    fn darkness_is_black() {
        let Some(gpu) = gpu() else { return };
        let texture = texture(&gpu, &vec![[0.0; 3]; SIZE[0] * SIZE[1]]);
        let d = Development { bloom: 0.5, exposure_ev: 20.0, mean: Some(0.18), tone: ToneMap::Neutral };
        let pixels = develop(&gpu, &mut Developer::default(), &texture, &d).expect("a picture");
        assert!(pixels.chunks_exact(4).all(|p| p == [0, 0, 0, 255]));
    }
}
