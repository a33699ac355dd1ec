//! Rendered pictures: OpenEXR with named channels, and PNG.

use std::path::Path;

use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, LineOrder, SmallVec, WritableImage as _,
};
use ::png::{BitDepth, ColorType, Compression, SrgbRenderingIntent};

use super::atomic::Aside;
use super::{IoError, Problem};
use crate::base::Srgb8;

/// Write planes of f32 aside, as one OpenEXR file of `width` columns. Names are sorted, as the format wants; the file says
/// no time.
///
/// # Errors
/// If it cannot be written, or a plane has not `width * height` values.
pub fn stage_channels(
    path: &Path,
    [width, height]: [usize; 2],
    channels: &[(&str, Vec<f32>)],
) -> Result<Aside, IoError> {
    if width * height == 0 || channels.iter().any(|(_, plane)| plane.len() != width * height) {
        return Err(Problem::Unencodable { width, height }.at(path));
    }
    let list: SmallVec<[_; 4]> = channels
        .iter()
        .map(|(name, plane)| AnyChannel::new(*name, FlatSamples::F32(plane.clone())))
        .collect();
    // Rows of 16 with PIZ: what renders compress best with among the lossless codecs.
    // In order, as else they lie in the file as threads finish them.
    let encoding = Encoding {
        compression: ::exr::prelude::Compression::PIZ,
        line_order: LineOrder::Increasing,
        ..Encoding::FAST_LOSSLESS
    };
    let layer = ::exr::prelude::Layer::new(
        (width, height),
        ::exr::prelude::LayerAttributes::default(),
        encoding,
        AnyChannels::sort(list),
    );
    let image = Image::from_layer(layer);
    Aside::write(path.to_owned(), |out| image.write().to_buffered(out).map_err(super::exr::problem))
}

/// Write a picture as an sRGB PNG of 8 bits, row by row from the top: whole or not at all.
///
/// # Errors
/// As [`stage_picture`].
pub fn write_picture(path: &Path, size: [usize; 2], pixels: &[Srgb8]) -> Result<(), IoError> {
    stage_picture(path, size, pixels)?.commit()
}

/// Write a picture aside, as an sRGB PNG of 8 bits, row by row from the top.
///
/// # Errors
/// If it cannot be written, or there are not `width * height` pixels.
pub fn stage_picture(path: &Path, [width, height]: [usize; 2], pixels: &[Srgb8]) -> Result<Aside, IoError> {
    let side = |n: usize| i32::try_from(n).ok().filter(|n| *n > 0).map(i32::unsigned_abs);
    let (Some(w), Some(h), true) = (side(width), side(height), pixels.len() == width * height) else {
        return Err(Problem::Unencodable { width, height }.at(path));
    };
    Aside::write(path.to_owned(), |out| {
        let mut encoder = ::png::Encoder::new(out, w, h);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Balanced);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(super::png::problem)?;
        let bytes: Vec<u8> = pixels.iter().flat_map(|p| p.0).collect();
        writer.write_image_data(&bytes).map_err(super::png::problem)?;
        writer.finish().map_err(super::png::problem)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_the_same_bytes_each_time() {
        let dir = tempfile::tempdir().expect("a directory");
        let (path, size) = (dir.path().join("a.exr"), [200, 480]);
        // The first rows are hard to compress, the last ones easy: threads end out of order.
        let noise = |i: usize| crate::base::hash::unit(crate::base::hash::hash1(7, i as u32));
        let plane: Vec<f32> =
            (0..size[0] * size[1]).map(|i| if i < 30_000 { noise(i) } else { 0.5 }).collect();
        let write = || {
            stage_channels(&path, size, &[("Y", plane.clone())]).and_then(Aside::commit).expect("written");
            std::fs::read(&path).expect("a file")
        };
        let first = write();
        assert!((0..20).all(|_| write() == first));
    }

    #[test]
    fn planes_and_pixels_read_back_with_another_decoder_and_wrong_sizes_are_refused() {
        let dir = tempfile::tempdir().expect("a directory");
        let (path, size) = (dir.path().join("a.exr"), [3, 2]);
        let plane = |k: f32| (0..6).map(|i| k * i as f32 - 0.3).collect::<Vec<f32>>();
        let channels =
            [("R", plane(1.0)), ("G", plane(1e6)), ("B", plane(-1e-6)), ("variance.R", plane(2.0))];
        let aside = stage_channels(&path, size, &channels).expect("written");
        assert!(!path.exists());
        aside.commit().expect("renamed");
        let image = image::open(&path).expect("read").into_rgb32f();
        assert_eq!(image.dimensions(), (3, 2));
        assert_eq!(image.get_pixel(2, 1).0, [channels[0].1[5], channels[1].1[5], channels[2].1[5]]);
        assert!(stage_channels(&path, [2, 2], &channels).is_err());

        let path = dir.path().join("a.png");
        let pixels: Vec<Srgb8> = (0..6).map(|i| Srgb8([i * 40, 255 - i, 7])).collect();
        write_picture(&path, size, &pixels).expect("written");
        let image = image::open(&path).expect("read").into_rgb8();
        assert_eq!(image.get_pixel(1, 1).0, pixels[4].0);
        assert!(write_picture(&path, [0, 0], &[]).is_err());
        assert!(write_picture(&dir.path().join("no/such/a.png"), size, &pixels).is_err());
    }
}
