//! OpenEXR files of maps: floats in physical units, unscaled.
//!
//! Channels are `R G B` for colour (linear), `X Y Z` for normals (unit vectors), `Y` for the rest; a file that holds
//! a whole set prefixes them with the map's name, `height.Y`. Scan lines, PIZ unless asked otherwise: on half samples
//! it is four times faster than ZIP and smaller. No time and no custom attribute, blocks in increasing order whatever
//! the number of threads.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek, Write};

use ::exr::block::reader::ChunksReader as _;
use ::exr::block::writer::ChunksWriter as _;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, attribute};
use half::f16;
use half::slice::HalfFloatSliceExt as _;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Problem;
use crate::base::watch::{Watched, Work};
use crate::base::{MapKind, Plane};
use crate::maps::MapImage;

/// Bits of a float sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExrSample {
    /// 16 bits: 11 significant bits; beyond 65 504 clamped.
    Half,
    /// 32 bits: the values as they are.
    Float,
}

impl ExrSample {
    /// The samples of a map unless asked otherwise: float for height (11 bits show as terraces when displaced) and
    /// ids (half is exact to 2048 only), half for the rest.
    pub fn default_for(kind: MapKind) -> Self {
        match kind {
            MapKind::Height | MapKind::ScaleId => Self::Float,
            _ => Self::Half,
        }
    }
}

/// How blocks are compressed; all are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExrCompression {
    /// Wavelet and Huffman: best for images with grain.
    #[default]
    Piz,
    /// Deflate, 16 lines a block: read by everything.
    Zip,
    /// None: fastest.
    None,
}

impl ExrCompression {
    fn codec(self) -> Compression {
        match self {
            Self::Piz => Compression::PIZ,
            Self::Zip => Compression::ZIP16,
            Self::None => Compression::Uncompressed,
        }
    }
}

/// How maps become OpenEXR files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrOptions {
    /// Samples that differ from [`ExrSample::default_for`]. Ids are always float.
    pub samples: BTreeMap<MapKind, ExrSample>,
    /// Compression of all files.
    pub compression: ExrCompression,
}

impl ExrOptions {
    /// The samples of a map.
    pub fn sample(&self, kind: MapKind) -> ExrSample {
        match (kind, self.samples.get(&kind)) {
            (MapKind::ScaleId, _) => ExrSample::Float,
            (_, Some(&sample)) => sample,
            (_, None) => ExrSample::default_for(kind),
        }
    }
}

/// Channel names of a map, in the order of its planes.
pub(super) fn channel_names(kind: MapKind, layered: bool) -> Vec<String> {
    let names: &[&str] = match kind {
        MapKind::Color => &["R", "G", "B"],
        MapKind::Normal => &["X", "Y", "Z"],
        _ => &["Y"],
    };
    names.iter().map(|n| if layered { format!("{kind}.{n}") } else { (*n).to_owned() }).collect()
}

/// A file in the making: its header, and the plane of each of its channels.
struct Layout<'a> {
    header: Header,
    planes: Vec<(ExrSample, &'a Plane)>,
}

impl<'a> Layout<'a> {
    /// # Errors
    /// If the maps' size does not fit the format.
    fn new(maps: &[&'a MapImage], layered: bool, options: &ExrOptions) -> Result<Self, Problem> {
        let (width, height) = (maps[0].width(), maps[0].height());
        if width.max(height) > i32::MAX as usize / 2 {
            return Err(Problem::Unencodable { width, height });
        }
        // The format wants channels in alphabetical order.
        let mut channels: Vec<(String, ExrSample, &Plane)> = Vec::new();
        let mut notes = Vec::new();
        for map in maps {
            let sample = options.sample(map.kind);
            let names = channel_names(map.kind, layered);
            channels.extend(names.into_iter().zip(&map.planes).map(|(name, plane)| (name, sample, plane)));
            if !map.kind.unit().is_empty() {
                notes.push(format!("{} in {}", map.kind, map.kind.unit()));
            }
        }
        channels.sort_by(|a, b| a.0.cmp(&b.0));
        let list = channels.iter().map(|(name, sample, _)| {
            let kind = match sample {
                ExrSample::Half => attribute::SampleType::F16,
                ExrSample::Float => attribute::SampleType::F32,
            };
            attribute::ChannelDescription::new(name.as_str(), kind, false)
        });
        let text = |s: &str| attribute::Text::from(s);
        let attributes = LayerAttributes {
            comments: (!notes.is_empty()).then(|| text(&notes.join(", "))),
            wrap_mode_name: Some(text("periodic")),
            ..LayerAttributes::default()
        };
        let header =
            Header::new(text(""), (width, height), list.collect()).with_attributes(attributes).with_encoding(
                options.compression.codec(),
                BlockDescription::ScanLines,
                attribute::LineOrder::Increasing,
            );
        let planes = channels.into_iter().map(|(_, sample, plane)| (sample, plane)).collect();
        Ok(Self { header, planes })
    }

    /// The samples of one block of lines.
    fn block(&self, index: BlockIndex) -> UncompressedBlock {
        let mut halves = vec![f16::ZERO; index.pixel_size.0];
        let mut clamped = vec![0.0; index.pixel_size.0];
        UncompressedBlock::from_lines(&self.header.channels, index, |line| {
            let (sample, plane) = self.planes[line.location.channel];
            let row = plane.row(line.location.position.1 as i64);
            let written = match sample {
                ExrSample::Float => line.write_samples_from_slice(row),
                ExrSample::Half => {
                    let max = f16::MAX.to_f32();
                    for (c, v) in clamped.iter_mut().zip(row) {
                        // `clamp` keeps NaN, so that it is seen and not hidden.
                        *c = v.clamp(-max, max);
                    }
                    halves.convert_from_f32_slice(&clamped);
                    line.write_samples_from_slice(&halves)
                }
            };
            written.expect("a line of a block is as wide as the image");
        })
    }
}

/// Write maps of one size as one OpenEXR file; `layered` prefixes channels with the maps' names.
///
/// Blocks are compressed on the current rayon pool, a batch at a time, and written in order.
pub(super) fn write(
    maps: &[&MapImage],
    layered: bool,
    options: &ExrOptions,
    watched: Watched<'_>,
    out: impl Write + Seek,
) -> Result<(), Problem> {
    let layout = Layout::new(maps, layered, options)?;
    let batch = 4 * rayon::current_num_threads().max(1);
    ::exr::block::write(out, std::iter::once(layout.header.clone()).collect(), true, |meta, writer| {
        let indices: Vec<_> = ::exr::block::enumerate_ordered_header_block_indices(&meta.headers).collect();
        for indices in indices.chunks(batch) {
            let chunks: Vec<_> = indices
                .par_iter()
                .map(|&(i, index)| {
                    let chunk = || layout.block(index).compress_to_chunk(&meta.headers);
                    watched.piece(Work::Encode, chunk).map(|chunk| (i, chunk))
                })
                .collect();
            for chunk in chunks {
                let (i, chunk) = chunk?;
                watched.piece(Work::Write, || writer.write_chunk(i, chunk))?;
            }
        }
        Ok(())
    })
    .map_err(problem)
}

/// Decode what [`write()`] wrote and compare every sample, bit for bit.
pub(super) fn verify(
    maps: &[&MapImage],
    layered: bool,
    options: &ExrOptions,
    file: &mut File,
) -> Result<(), Problem> {
    let layout = Layout::new(maps, layered, options)?;
    let differs = |what: String| Problem::ReadBack(what);
    let decoded = |e: ::exr::error::Error| Problem::ReadBack(e.to_string());
    let reader = ::exr::block::read(BufReader::with_capacity(1 << 18, file), true).map_err(decoded)?;
    let same = |h: &Header| {
        h.channels == layout.header.channels
            && h.layer_size == layout.header.layer_size
            && h.chunk_count == layout.header.chunk_count
    };
    if reader.headers().len() != 1 || !same(&reader.headers()[0]) {
        return Err(differs("the header differs".into()));
    }
    let mut chunks = reader.all_chunks(true).map_err(decoded)?;
    let meta = chunks.meta_data().clone();
    let batch = 4 * rayon::current_num_threads().max(1);
    let mut rows = 0;
    loop {
        let read: Vec<_> = chunks.by_ref().take(batch).collect::<Result<_, _>>().map_err(decoded)?;
        if read.is_empty() {
            break;
        }
        let checked: Vec<Result<usize, Problem>> = read
            .into_par_iter()
            .map(|chunk| {
                let block = UncompressedBlock::decompress_chunk(chunk, &meta, true).map_err(decoded)?;
                let Vec2(_, y) = block.index.pixel_position;
                if block.data == layout.block(block.index).data {
                    Ok(block.index.pixel_size.1)
                } else {
                    Err(differs(format!("the block at row {y} differs")))
                }
            })
            .collect();
        for checked in checked {
            rows += checked?;
        }
    }
    if rows == maps[0].height() { Ok(()) } else { Err(differs(format!("{rows} rows were found"))) }
}

pub(super) fn problem(error: ::exr::error::Error) -> Problem {
    match error {
        ::exr::error::Error::Io(e) => e.into(),
        e => Problem::Format { format: "OpenEXR", message: e.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::{Cursor, SeekFrom};

    fn wavy(kind: MapKind, w: usize, h: usize) -> MapImage {
        let plane =
            |c: usize| Plane::from_fn(w, h, |x, y| ((x * x + 3 * y + 7 * c) % 1009) as f32 * 0.37 - 5.0);
        MapImage::new(kind, (0..kind.channels()).map(plane).collect())
    }

    fn encode(maps: &[&MapImage], layered: bool, options: &ExrOptions) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        write(maps, layered, options, Watched { name: "", by: None }, &mut bytes).unwrap();
        bytes.into_inner()
    }

    /// Channels by name, as f32 (half samples are exact in f32).
    type Channels = BTreeMap<String, Vec<f32>>;

    /// The planes as their samples hold them.
    fn expected(maps: &[&MapImage], layered: bool, options: &ExrOptions) -> Channels {
        let mut channels = Channels::new();
        for map in maps {
            for (name, plane) in channel_names(map.kind, layered).into_iter().zip(&map.planes) {
                let sample = |v: &f32| match options.sample(map.kind) {
                    ExrSample::Half => f16::from_f32(v.clamp(-65504.0, 65504.0)).to_f32(),
                    ExrSample::Float => *v,
                };
                channels.insert(name, plane.data().iter().map(sample).collect());
            }
        }
        channels
    }

    /// An OpenEXR reader for uncompressed scan lines, written from the format's description, sharing no code with
    /// the encoder: attribute names and values, and the channels.
    fn decode_uncompressed(file: &[u8]) -> (BTreeMap<String, Vec<u8>>, Channels) {
        struct Bytes<'a>(&'a [u8]);
        impl<'a> Bytes<'a> {
            fn take(&mut self, n: usize) -> &'a [u8] {
                let (head, tail) = self.0.split_at(n);
                self.0 = tail;
                head
            }
            fn i32(&mut self) -> i32 {
                i32::from_le_bytes(self.take(4).try_into().unwrap())
            }
            fn text(&mut self) -> String {
                let n = self.0.iter().position(|&b| b == 0).unwrap();
                let text = String::from_utf8(self.take(n).to_vec()).unwrap();
                self.take(1);
                text
            }
        }
        let mut b = Bytes(file);
        assert_eq!((b.i32(), b.i32()), (20_000_630, 2), "magic number, and version 2 without flags");
        let mut attributes = BTreeMap::new();
        while b.0[0] != 0 {
            let (name, _kind) = (b.text(), b.text());
            let size = b.i32() as usize;
            attributes.insert(name, b.take(size).to_vec());
        }
        b.take(1);
        assert_eq!((&attributes["compression"][..], &attributes["lineOrder"][..]), (&[0][..], &[0][..]));
        let mut window = Bytes(&attributes["dataWindow"]);
        let corners = [window.i32(), window.i32(), window.i32(), window.i32()];
        assert_eq!(corners[..2], [0, 0]);
        let (w, h) = (corners[2] as usize + 1, corners[3] as usize + 1);
        let mut list = Bytes(&attributes["channels"]);
        let mut names = Vec::new();
        while list.0[0] != 0 {
            let (name, half) = (list.text(), list.i32() == 1);
            list.take(12);
            names.push((name, half));
        }
        assert!(names.is_sorted(), "channels are in alphabetical order");
        b.take(8 * h);
        let mut channels = Channels::new();
        for y in 0..h {
            assert_eq!(b.i32(), y as i32);
            let mut line = Bytes({
                let size = b.i32() as usize;
                b.take(size)
            });
            for (name, half) in &names {
                let values = channels.entry(name.clone()).or_default();
                for _ in 0..w {
                    values.push(if *half {
                        f16::from_le_bytes(line.take(2).try_into().unwrap()).to_f32()
                    } else {
                        f32::from_le_bytes(line.take(4).try_into().unwrap())
                    });
                }
            }
        }
        assert!(b.0.is_empty());
        (attributes, channels)
    }

    const UNCOMPRESSED: ExrOptions =
        ExrOptions { samples: BTreeMap::new(), compression: ExrCompression::None };

    #[test]
    fn every_kind_in_either_sample_reads_back_with_another_decoder() {
        for kind in MapKind::ALL {
            for sample in [ExrSample::Half, ExrSample::Float] {
                let options = ExrOptions { samples: [(kind, sample)].into(), ..UNCOMPRESSED };
                for (w, h) in [(1, 1), (37, 19), (3, 130)] {
                    let map = wavy(kind, w, h);
                    let (_, found) = decode_uncompressed(&encode(&[&map], false, &options));
                    assert_eq!(found, expected(&[&map], false, &options), "{kind} {sample:?} {w}x{h}");
                }
            }
        }
    }

    #[test]
    fn a_set_in_one_file_has_a_layer_per_map() {
        let maps = MapKind::ALL.map(|kind| wavy(kind, 9, 70));
        let maps: Vec<&MapImage> = maps.iter().collect();
        let (_, found) = decode_uncompressed(&encode(&maps, true, &UNCOMPRESSED));
        assert!(
            found.contains_key("height.Y") && found.contains_key("color.G") && found.contains_key("normal.Z")
        );
        assert_eq!(found, expected(&maps, true, &UNCOMPRESSED));
    }

    #[test]
    fn the_header_says_the_unit_and_periodic_and_no_time() {
        let (attributes, _) =
            decode_uncompressed(&encode(&[&wavy(MapKind::Iridescence, 2, 2)], false, &UNCOMPRESSED));
        assert_eq!(attributes["comments"], b"iridescence in nm");
        assert_eq!(attributes["wrapmodes"], b"periodic");
        let expected = "channels chunkCount comments compression dataWindow displayWindow lineOrder \
            pixelAspectRatio screenWindowCenter screenWindowWidth type wrapmodes";
        assert_eq!(attributes.into_keys().collect::<Vec<_>>().join(" "), expected);
    }

    #[test]
    fn verify_accepts_every_codec_and_refuses_another_map_or_a_flipped_bit() {
        for compression in [ExrCompression::Piz, ExrCompression::Zip, ExrCompression::None] {
            let options = ExrOptions { compression, ..ExrOptions::default() };
            for kind in [MapKind::Height, MapKind::Normal] {
                let map = wavy(kind, 70, 90);
                let bytes = encode(&[&map], false, &options);
                let mut file = tempfile::tempfile().unwrap();
                file.write_all(&bytes).unwrap();
                let check = |map: &MapImage, file: &mut File| {
                    file.seek(SeekFrom::Start(0)).unwrap();
                    verify(&[map], false, &options, file)
                };
                check(&map, &mut file).unwrap();
                let mut other = map.clone();
                other.planes[0].data_mut()[70 * 90 - 1] += 1.0;
                assert!(matches!(check(&other, &mut file), Err(Problem::ReadBack(_))));
                // The last byte belongs to a sample in every codec here.
                let last = bytes.len() as u64 - 1;
                file.seek(SeekFrom::Start(last)).unwrap();
                file.write_all(&[bytes[bytes.len() - 1] ^ 0x40]).unwrap();
                assert!(
                    matches!(check(&map, &mut file), Err(Problem::ReadBack(_))),
                    "{compression:?} {kind}"
                );
            }
        }
    }

    /// The OpenEXR project's own decoder, through its Python module, reads every codec; where it is not installed the
    /// compressed files are read by their own crate only (`verify`).
    #[test]
    fn the_openexr_library_reads_every_codec() {
        let script = "import OpenEXR, numpy, sys\n\
            channels = OpenEXR.File(sys.argv[1], separate_channels=True).channels()\n\
            for name in sorted(channels):\n\
            \x20   values = channels[name].pixels.astype('<f4').tobytes().hex()\n\
            \x20   print(name, values)\n";
        let python = |args: &[&std::ffi::OsStr]| {
            std::process::Command::new("python3")
                .arg("-c")
                .args(args)
                .output()
                .ok()
                .filter(|o| o.status.success())
        };
        if python(&["import OpenEXR, numpy".as_ref()]).is_none() {
            println!("SKIPPED: python3 with the modules OpenEXR and numpy is not installed");
            return;
        }
        let dir = tempfile::tempdir().unwrap();
        let maps = [MapKind::Color, MapKind::Height, MapKind::Normal].map(|kind| wavy(kind, 61, 75));
        let maps: Vec<&MapImage> = maps.iter().collect();
        for compression in [ExrCompression::Piz, ExrCompression::Zip, ExrCompression::None] {
            let options = ExrOptions { compression, ..ExrOptions::default() };
            let path = dir.path().join("a.exr");
            std::fs::write(&path, encode(&maps, true, &options)).unwrap();
            let output = python(&[script.as_ref(), path.as_os_str()]).expect("OpenEXR reads the file");
            let found: Channels = String::from_utf8(output.stdout)
                .unwrap()
                .lines()
                .map(|line| {
                    let (name, hex) = line.split_once(' ').unwrap();
                    let word =
                        |i: usize| u32::from_str_radix(&hex[8 * i..8 * i + 8], 16).unwrap().swap_bytes();
                    (name.to_owned(), (0..hex.len() / 8).map(|i| f32::from_bits(word(i))).collect())
                })
                .collect();
            assert_eq!(found, expected(&maps, true, &options), "{compression:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn any_finite_plane_reads_back(
            w in 1usize..40,
            values in proptest::collection::vec(
                proptest::num::f32::NORMAL | proptest::num::f32::SUBNORMAL | proptest::num::f32::ZERO, 1..600),
            kind in 0usize..10, half: bool,
        ) {
            let kind = MapKind::ALL[kind];
            let w = w.min(values.len());
            let plane = Plane::from_vec(w, values.len() / w, values[..values.len() / w * w].to_vec());
            let map = MapImage::new(kind, vec![plane; kind.channels()]);
            let sample = if half { ExrSample::Half } else { ExrSample::Float };
            let options = ExrOptions { samples: [(kind, sample)].into(), ..UNCOMPRESSED };
            let (_, found) = decode_uncompressed(&encode(&[&map], false, &options));
            prop_assert_eq!(found, expected(&[&map], false, &options));
            // The compressed forms hold the same samples.
            for compression in [ExrCompression::Piz, ExrCompression::Zip] {
                let options = ExrOptions { compression, ..options.clone() };
                let mut file = tempfile::tempfile().unwrap();
                file.write_all(&encode(&[&map], false, &options)).unwrap();
                file.seek(SeekFrom::Start(0)).unwrap();
                verify(&[&map], false, &options, &mut file).unwrap();
            }
        }
    }
}
