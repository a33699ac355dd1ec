//! Image files as inputs of a graph.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use ::exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _};
use ::png::{BitDepth, ColorType, Limits, Transformations};

use super::{IoError, Problem, hdr};
use crate::base::Plane;
use crate::node::{Asset, Assets};

/// Most samples (texels times channels) that an input image may have: 1 GiB as f32.
pub const MAX_SAMPLES: u64 = 1 << 28;

const PNG_MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Read a PNG, OpenEXR or Radiance HDR file, told apart by content.
///
/// Values as stored: integers divided by the greatest of their depth, so [0, 1]; floats as they are. Palettes and
/// depths below 8 bits are expanded; no transfer function is undone; PNG's alpha is straight, EXR's premultiplied.
/// Of an OpenEXR file the first layer is read: `R G B`, else `X Y Z`, else `Y`, else its only channel; `A` is alpha.
///
/// # Errors
/// If the file cannot be read, is none of these formats, is damaged, or has more than [`MAX_SAMPLES`].
pub fn read_image(path: &Path) -> Result<Asset, IoError> {
    open(path).map_err(|problem| problem.at(path))
}

/// Read the image files that a graph names, each once, relative to `base_dir`.
///
/// # Errors
/// Every file that could not be read, by the name that the graph gives it.
pub fn load_assets<'a>(
    files: impl Iterator<Item = &'a str>,
    base_dir: &Path,
) -> Result<Assets, Vec<(String, IoError)>> {
    let (mut assets, mut errors) = (Assets::new(), Vec::new());
    for file in files.collect::<BTreeSet<_>>() {
        match read_image(&base_dir.join(file)) {
            Ok(asset) => drop(assets.insert(file.to_owned(), Arc::new(asset))),
            Err(error) => errors.push((file.to_owned(), error)),
        }
    }
    if errors.is_empty() { Ok(assets) } else { Err(errors) }
}

/// The bytes of a file, at most `most`.
///
/// # Errors
/// If it cannot be read, or has more.
pub fn read_bytes(path: &Path, most: usize) -> Result<Vec<u8>, IoError> {
    let read = || -> Result<Vec<u8>, Problem> {
        let file = File::open(path)?;
        if file.metadata()?.is_dir() {
            return Err(Problem::IsADirectory);
        }
        let mut bytes = Vec::new();
        file.take(most as u64 + 1).read_to_end(&mut bytes)?;
        if bytes.len() > most {
            return Err(Problem::Long { most });
        }
        Ok(bytes)
    };
    read().map_err(|problem| problem.at(path))
}

fn open(path: &Path) -> Result<Asset, Problem> {
    let mut file = File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(Problem::IsADirectory);
    }
    let mut magic = Vec::new();
    file.by_ref().take(8).read_to_end(&mut magic)?;
    file.seek(SeekFrom::Start(0))?;
    let file = BufReader::with_capacity(1 << 18, file);
    if magic == PNG_MAGIC {
        read_png(file)
    } else if magic.starts_with(&EXR_MAGIC) {
        read_exr(file)
    } else if hdr::MAGIC.iter().any(|start| magic.starts_with(start)) {
        hdr::read(file)
    } else {
        let format = "PNG, OpenEXR or Radiance HDR";
        Err(Problem::Format { format, message: "it starts like none of them".into() })
    }
}

pub(super) fn limit(width: u64, height: u64, channels: u64) -> Result<(), Problem> {
    let samples = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if samples.is_none_or(|n| n > MAX_SAMPLES) {
        return Err(Problem::TooLarge { width, height, channels, limit: MAX_SAMPLES });
    }
    Ok(())
}

fn read_png(file: BufReader<File>) -> Result<Asset, Problem> {
    let problem = |e: ::png::DecodingError| match e {
        ::png::DecodingError::IoError(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => e.into(),
        e => Problem::Format { format: "PNG", message: e.to_string() },
    };
    // For the decoder's own rows and chunks; the image has its own limit below.
    let mut decoder = ::png::Decoder::new_with_limits(file, Limits { bytes: 1 << 28 });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(problem)?;
    // Four channels, because a palette or a transparent colour may add some.
    limit(info.width.into(), info.height.into(), 4)?;
    let mut reader = decoder.read_info().map_err(problem)?;
    let too_large = || Problem::Format { format: "PNG", message: "its size overflows".into() };
    let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    let frame = reader.next_frame(&mut bytes).map_err(problem)?;
    let (width, height) = (frame.width as usize, frame.height as usize);
    let (lanes, alpha) = match frame.color_type {
        ColorType::Grayscale => (1, false),
        ColorType::GrayscaleAlpha => (1, true),
        ColorType::Rgb => (3, false),
        ColorType::Rgba => (3, true),
        ColorType::Indexed => return Err(Problem::Format { format: "PNG", message: "no palette".into() }),
    };
    let stride = lanes + usize::from(alpha);
    let plane = |c: usize| {
        let values: Vec<f32> = match frame.bit_depth {
            BitDepth::Sixteen => bytes[..frame.buffer_size()]
                .chunks_exact(2)
                .skip(c)
                .step_by(stride)
                .map(|b| f32::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0)
                .collect(),
            _ => bytes[..frame.buffer_size()]
                .iter()
                .skip(c)
                .step_by(stride)
                .map(|&b| f32::from(b) / 255.0)
                .collect(),
        };
        Plane::from_vec(width, height, values)
    };
    Ok(Asset { channels: (0..lanes).map(plane).collect(), alpha: alpha.then(|| plane(lanes)) })
}

/// The channels of the first layer of an OpenEXR file.
pub(super) struct ExrLayer {
    width: usize,
    height: usize,
    channels: Vec<(String, FlatSamples)>,
}

impl ExrLayer {
    /// Read it whole, after a look at its size.
    pub(super) fn read(mut file: BufReader<File>) -> Result<Self, Problem> {
        use super::exr::problem;
        // Look at the size before anything of that size is allocated.
        let meta = ::exr::block::read(&mut file, false).map_err(problem)?.into_meta_data();
        let Some(header) = meta.headers.iter().find(|h| !h.deep) else {
            return Err(refuse("it holds deep data only".into()));
        };
        let size = header.layer_size;
        limit(size.0 as u64, size.1 as u64, header.channels.list.len() as u64)?;
        file.seek(SeekFrom::Start(0))?;

        let image = ::exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(file)
            .map_err(problem)?;
        let layer = image.layer_data;
        let (width, height) = (layer.size.0, layer.size.1);
        let channels =
            layer.channel_data.list.into_iter().map(|c| (c.name.to_string(), c.sample_data)).collect();
        Ok(Self { width, height, channels })
    }

    /// Take out the plane of this name.
    pub(super) fn take(&mut self, wanted: &str) -> Result<Plane, Problem> {
        let at = self.channels.iter().position(|(name, _)| name == wanted);
        let (_, samples) =
            self.channels.swap_remove(at.ok_or_else(|| refuse(format!("no channel {wanted}")))?);
        let values: Vec<f32> = match samples {
            FlatSamples::F16(v) => v.into_iter().map(|h| h.to_f32()).collect(),
            FlatSamples::F32(v) => v,
            FlatSamples::U32(v) => v.into_iter().map(|n| n as f32).collect(),
        };
        if values.len() != self.width * self.height || values.is_empty() {
            return Err(refuse(format!("channel {wanted} is subsampled or empty")));
        }
        Ok(Plane::from_vec(self.width, self.height, values))
    }
}

fn refuse(message: String) -> Problem {
    Problem::Format { format: "OpenEXR", message }
}

fn read_exr(file: BufReader<File>) -> Result<Asset, Problem> {
    let mut layer = ExrLayer::read(file)?;
    let names: Vec<String> = layer.channels.iter().map(|(name, _)| name.clone()).collect();
    let has = |wanted: &str| names.iter().any(|n| n == wanted);
    let opaque: Vec<&String> = names.iter().filter(|n| *n != "A").collect();
    let wanted: Vec<&str> = if ["R", "G", "B"].into_iter().all(has) {
        vec!["R", "G", "B"]
    } else if ["X", "Y", "Z"].into_iter().all(has) {
        vec!["X", "Y", "Z"]
    } else if has("Y") {
        vec!["Y"]
    } else if let [only] = opaque[..] {
        vec![only]
    } else {
        return Err(refuse(format!("which of its channels is meant? It has {}", names.join(", "))));
    };
    let planes = wanted.into_iter().map(|name| layer.take(name)).collect::<Result<_, _>>()?;
    let alpha = if has("A") { Some(layer.take("A")?) } else { None };
    Ok(Asset { channels: planes, alpha })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::MapKind;
    use crate::io::{ExrOptions, ExrSample, exr, png};
    use crate::maps::{EncodeOptions, MapImage};
    use image::{DynamicImage, ImageFormat};
    use std::io::Cursor;

    fn read(name: &str, bytes: &[u8]) -> Result<Asset, IoError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        read_image(&path)
    }

    fn png_of(image: &DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn exr_of(kind: MapKind, size: usize) -> (MapImage, Vec<u8>) {
        let plane = Plane::from_fn(size, size, |x, y| (x * 3 + y * y) as f32 * 0.5 - 2.0);
        let map = MapImage::new(kind, vec![plane; kind.channels()]);
        let mut bytes = Cursor::new(Vec::new());
        let options = ExrOptions { samples: [(kind, ExrSample::Float)].into(), ..ExrOptions::default() };
        exr::write(&[&map], false, &options, crate::base::watch::Watched { name: "", by: None }, &mut bytes)
            .unwrap();
        (map, bytes.into_inner())
    }

    #[test]
    fn grey_rgb_and_alpha_of_8_and_16_bits_are_their_fractions() {
        let rgba8 =
            image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([51, 102, (50 * x) as u8, (100 * y) as u8]));
        let asset = read("a.png", &png_of(&rgba8.clone().into())).unwrap();
        assert_eq!((asset.channels.len(), asset.channels[0].width(), asset.channels[0].height()), (3, 3, 2));
        assert_eq!((asset.channels[0].at(2, 1), asset.channels[1].at(0, 0)), (0.2, 0.4));
        assert_eq!(
            (asset.channels[2].at(2, 1), asset.alpha.unwrap().at(0, 1)),
            (100.0 / 255.0, 100.0 / 255.0)
        );
        let rgb = read("a.png", &png_of(&DynamicImage::from(rgba8).to_rgb8().into())).unwrap();
        assert_eq!((rgb.channels.len(), rgb.alpha), (3, None));
        let grey = image::ImageBuffer::<image::Luma<u16>, _>::from_fn(2, 2, |x, y| {
            image::Luma([(x * 40000 + y) as u16])
        });
        let asset = read("a.png", &png_of(&grey.into())).unwrap();
        assert_eq!((asset.channels.len(), asset.alpha), (1, None));
        assert_eq!(asset.channels[0].data(), &[0.0, 40000.0 / 65535.0, 1.0 / 65535.0, 40001.0 / 65535.0]);
        let alpha = image::GrayAlphaImage::from_pixel(1, 1, image::LumaA([255, 51]));
        let asset = read("a.png", &png_of(&alpha.into())).unwrap();
        assert_eq!((asset.channels[0].at(0, 0), asset.alpha.unwrap().at(0, 0)), (1.0, 0.2));
    }

    #[test]
    fn palettes_and_single_bits_are_expanded() {
        let make = |color, depth, palette: Option<&[u8]>, trns: Option<&[u8]>, data: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = ::png::Encoder::new(&mut bytes, 4, 1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            if let Some(palette) = palette {
                encoder.set_palette(palette);
            }
            if let Some(trns) = trns {
                encoder.set_trns(trns);
            }
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            bytes
        };
        let bits =
            read("a.png", &make(ColorType::Grayscale, BitDepth::One, None, None, &[0b1010_0000])).unwrap();
        assert_eq!(bits.channels[0].data(), &[1.0, 0.0, 1.0, 0.0]);
        let palette = [255, 0, 0, 0, 255, 0];
        let file = make(ColorType::Indexed, BitDepth::Two, Some(&palette), Some(&[0, 255]), &[0b0001_0001]);
        let asset = read("a.png", &file).unwrap();
        assert_eq!(asset.channels[0].data(), &[1.0, 0.0, 1.0, 0.0]);
        assert_eq!(asset.channels[1].data(), &[0.0, 1.0, 0.0, 1.0]);
        assert_eq!(asset.alpha.unwrap().data(), &[0.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn exr_values_are_read_as_they_are_whatever_the_file_is_called() {
        for kind in [MapKind::Height, MapKind::Color, MapKind::Normal] {
            let (map, bytes) = exr_of(kind, 33);
            let asset = read("misnamed.png", &bytes).unwrap();
            assert_eq!((asset.channels, asset.alpha), (map.planes, None), "{kind}");
        }
    }

    #[test]
    fn files_that_are_no_images_give_typed_errors() {
        let problem = |bytes: &[u8]| read("a.png", bytes).unwrap_err().problem;
        assert!(matches!(problem(b""), Problem::Format { .. }));
        assert!(matches!(problem(b"GIF89a, says it"), Problem::Format { .. }));
        assert!(matches!(problem(&PNG_MAGIC), Problem::Format { format: "PNG", .. }));
        assert!(matches!(problem(&EXR_MAGIC), Problem::Format { format: "OpenEXR", .. }));
        let dir = tempfile::tempdir().unwrap();
        assert!(matches!(read_image(&dir.path().join("no")).unwrap_err().problem, Problem::NotFound));
        assert!(matches!(read_image(dir.path()).unwrap_err().problem, Problem::IsADirectory));
    }

    #[test]
    fn huge_sizes_are_refused_before_memory_is_asked_for() {
        // 2^31 - 1 texels a side, by its header alone, with a right checksum.
        let mut header = Vec::new();
        let encoder = ::png::Encoder::new(&mut header, i32::MAX as u32, i32::MAX as u32);
        drop(encoder.write_header().unwrap());
        assert!(matches!(read("a.png", &header).unwrap_err().problem, Problem::TooLarge { .. }));
        let (_, mut bytes) = exr_of(MapKind::Height, 4);
        let at = bytes.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4;
        bytes[at + 8..at + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x3f, 0xff, 0xff, 0xff, 0x3f]);
        let problem = read("a.exr", &bytes).unwrap_err().problem;
        assert!(matches!(problem, Problem::TooLarge { .. } | Problem::Format { .. }), "{problem}");
    }

    /// Every prefix of a file, and hundreds of files with a few bytes changed: an error or an image, never a panic.
    #[test]
    fn damaged_files_never_panic() {
        let (map, exr) = exr_of(MapKind::Height, 24);
        let mut png = Vec::new();
        let nobody = crate::base::watch::Watched { name: "", by: None };
        png::write(&map, &EncodeOptions::default(), png::PngCompression::Fast, nobody, &mut png).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let mut refused = 0;
        let mut try_bytes = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            refused += usize::from(read_image(&path).is_err());
        };
        for file in [&exr, &png] {
            (0..file.len()).step_by(7).for_each(|n| try_bytes(&file[..n]));
            for i in 0..300u32 {
                let mut bytes = file.clone();
                for k in 0..1 + i % 3 {
                    let h = crate::base::hash::hash2(11, i, k);
                    // Half of the changes hit the first 400 bytes: the headers.
                    let end = if h & 1 == 0 { bytes.len() } else { bytes.len().min(400) };
                    let at = (h >> 9) as usize % end;
                    bytes[at] = (h >> 1) as u8;
                }
                try_bytes(&bytes);
            }
        }
        assert!(refused > 300, "{refused}");
    }

    #[test]
    fn assets_are_loaded_once_and_all_bad_files_are_told() {
        let dir = tempfile::tempdir().unwrap();
        let grey = image::GrayImage::from_pixel(2, 1, image::Luma([255]));
        std::fs::write(dir.path().join("a.png"), png_of(&grey.into())).unwrap();
        let assets = load_assets(["a.png", "a.png"].into_iter(), dir.path()).unwrap();
        assert_eq!(assets.len(), 1);
        assert_eq!(assets["a.png"].channels[0].data(), &[1.0, 1.0]);
        let errors = load_assets(["x.png", "a.png", "y.exr"].into_iter(), dir.path()).unwrap_err();
        let files: Vec<_> = errors.iter().map(|(file, _)| file.as_str()).collect();
        assert_eq!(files, ["x.png", "y.exr"]);
    }
}
