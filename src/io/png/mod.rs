//! PNG files of maps: integers, tagged with what they are.
//!
//! Colour carries an `sRGB` chunk, data a `gAMA` of 1.0, because untagged grey is taken for sRGB by common readers;
//! never a time or any text. Rows are encoded in strips on all cores of the pool, straight from the planes: no
//! copy of a plane is made, and memory does not grow with the image. The `png` crate writes the container, and reads
//! the file back.

mod filter;
mod huffman;
mod stream;
mod strip;

use std::fs::File;
use std::io::{BufReader, Write};
use std::sync::Arc;

use ::png::{BitDepth, ColorType};
use serde::{Deserialize, Serialize};

pub(super) use self::stream::Stream;
use super::Problem;
use crate::base::watch::Watched;
use crate::maps::{Depth, EncodeOptions, MapImage, MapTold, Quantiser};

/// How much time is spent to make PNG files smaller; all are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PngCompression {
    /// Huffman codes only.
    #[default]
    Fast,
    /// A quick search for repeats, too, where it makes a strip smaller.
    Balanced,
    /// A thorough one, behind several filters.
    Small,
}

impl PngCompression {
    /// Rows that are compressed together at most, of a map of this width.
    pub fn most_strip_rows(self, width: usize) -> usize {
        strip::rows(self, width)
    }
}

fn color_type(channels: usize) -> ColorType {
    if channels == 3 { ColorType::Rgb } else { ColorType::Grayscale }
}

fn bit_depth(depth: Depth) -> BitDepth {
    match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    }
}

/// Write a map as PNG, on the current rayon pool; the bytes do not depend on its threads.
pub(super) fn write(
    map: &MapImage,
    options: &EncodeOptions,
    compression: PngCompression,
    watched: Watched<'_>,
    out: impl Write + Send,
) -> Result<MapTold, Problem> {
    let quantiser = Quantiser::new(map, options);
    let mut stream = Stream::new(&quantiser, map.height(), compression, false, Arc::default(), out)?;
    stream.advance(&quantiser, map.height(), watched)?;
    Ok(stream.finish(watched)?.0)
}

/// Decode what a [`Stream`] wrote, and compare every sample by the hashes of its strips.
pub(super) fn verify_hashes(
    row_bytes: usize,
    compression: PngCompression,
    hashes: &[blake3::Hash],
    file: &mut File,
) -> Result<(), Problem> {
    let differs = |what: String| Problem::ReadBack(what);
    let mut decoder = ::png::Decoder::new(BufReader::with_capacity(1 << 18, file));
    decoder.ignore_checksums(false);
    let mut reader = decoder.read_info().map_err(|e| differs(e.to_string()))?;
    let (height, rows) = (reader.info().height as usize, strip::rows(compression, row_bytes));
    if height.div_ceil(rows) != hashes.len() {
        return Err(differs(format!("the header differs: {height} rows")));
    }
    for (first, hash) in (0..height).step_by(rows).zip(hashes) {
        let mut hasher = blake3::Hasher::new();
        for y in first..(first + rows).min(height) {
            match reader.next_row() {
                Ok(Some(found)) if found.data().len() == row_bytes => hasher.update(found.data()),
                Ok(_) => return Err(differs(format!("row {y} differs"))),
                Err(e) => return Err(differs(format!("row {y}: {e}"))),
            };
        }
        if hasher.finalize() != *hash {
            return Err(differs(format!("one of the rows from {first} on differs")));
        }
    }
    reader.finish().map_err(|e| differs(e.to_string()))
}

/// Decode what [`write()`] wrote and compare every sample.
pub(super) fn verify(map: &MapImage, options: &EncodeOptions, file: &mut File) -> Result<(), Problem> {
    let differs = |what: String| Problem::ReadBack(what);
    let quantiser = Quantiser::new(map, options);
    let mut decoder = ::png::Decoder::new(BufReader::with_capacity(1 << 18, file));
    decoder.ignore_checksums(false);
    let mut reader = decoder.read_info().map_err(|e| differs(e.to_string()))?;
    let info = reader.info();
    let found = (info.width as usize, info.height as usize, info.color_type, info.bit_depth);
    if found != (map.width(), map.height(), color_type(map.planes.len()), bit_depth(quantiser.depth())) {
        return Err(differs(format!("the header differs: {found:?}")));
    }
    let (mut scratch, mut row) = (Vec::new(), vec![0; quantiser.row_bytes()]);
    for y in 0..map.height() {
        quantiser.row(y, &mut scratch, &mut row);
        match reader.next_row() {
            Ok(Some(found)) if found.data() == row => {}
            Ok(_) => return Err(differs(format!("row {y} differs"))),
            Err(e) => return Err(differs(format!("row {y}: {e}"))),
        }
    }
    reader.finish().map_err(|e| differs(e.to_string()))
}

pub(super) fn problem(error: ::png::EncodingError) -> Problem {
    match error {
        ::png::EncodingError::IoError(e) => e.into(),
        e => Problem::Format { format: "PNG", message: e.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::MapKind;
    use crate::base::Plane;
    use proptest::prelude::*;
    use std::io::{Seek as _, SeekFrom};
    use zune_png::zune_core::{bytestream::ZCursor, result::DecodingResult};

    const NOBODY: Watched<'_> = Watched { name: "", by: None };
    const LEVELS: [PngCompression; 3] =
        [PngCompression::Fast, PngCompression::Balanced, PngCompression::Small];

    fn encode_at(level: PngCompression, map: &MapImage, options: &EncodeOptions) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(map, options, level, NOBODY, &mut bytes).unwrap();
        bytes
    }

    fn encode(map: &MapImage, options: &EncodeOptions) -> Vec<u8> {
        encode_at(PngCompression::Fast, map, options)
    }

    /// What the quantiser says, as numbers.
    fn samples(map: &MapImage, options: &EncodeOptions) -> Vec<u16> {
        let q = Quantiser::new(map, options);
        let (mut scratch, mut row) = (Vec::new(), vec![0; q.row_bytes()]);
        let mut all = Vec::new();
        for y in 0..map.height() {
            q.row(y, &mut scratch, &mut row);
            match q.depth() {
                Depth::Eight => all.extend(row.iter().map(|&b| u16::from(b))),
                Depth::Sixteen => all.extend(row.chunks(2).map(|b| u16::from_be_bytes([b[0], b[1]]))),
            }
        }
        all
    }

    /// Size and samples by another decoder, zune-png, which shares no code with the encoder.
    fn decode(bytes: &[u8]) -> (usize, usize, Vec<u16>) {
        let mut decoder = zune_png::PngDecoder::new(ZCursor::new(bytes));
        let pixels = decoder.decode().unwrap();
        let (w, h) = decoder.dimensions().unwrap();
        let samples = match pixels {
            DecodingResult::U8(v) => v.into_iter().map(u16::from).collect(),
            DecodingResult::U16(v) => v,
            _ => panic!("neither 8 nor 16 bits"),
        };
        (w, h, samples)
    }

    /// Names and contents of the chunks, by the format's own description.
    fn chunks(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
        let mut rest = &bytes[8..];
        let mut list = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            list.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + length].to_vec()));
            rest = &rest[12 + length..];
        }
        list
    }

    fn wavy(kind: MapKind, w: usize, h: usize) -> MapImage {
        let plane = |c: usize| Plane::from_fn(w, h, |x, y| ((x * x + 3 * y + 7 * c) % 1009) as f32 / 1008.0);
        MapImage::new(kind, (0..kind.channels()).map(plane).collect())
    }

    #[test]
    fn every_kind_at_every_depth_reads_back_with_another_decoder() {
        for kind in MapKind::ALL {
            for depth in [Depth::Eight, Depth::Sixteen] {
                for (w, h) in [(1, 1), (37, 19), (3, 130)] {
                    let options = EncodeOptions { depths: [(kind, depth)].into(), dither: false };
                    let map = wavy(kind, w, h);
                    assert_eq!(
                        decode(&encode(&map, &options)),
                        (w, h, samples(&map, &options)),
                        "{kind} {depth:?} {w}x{h}"
                    );
                }
            }
        }
    }

    /// The samples by the `png` crate, checksums included.
    fn decode_by_png(bytes: &[u8]) -> Vec<u16> {
        let mut decoder = ::png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.ignore_checksums(false);
        let mut reader = decoder.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let depth = reader.next_frame(&mut samples).unwrap().bit_depth;
        reader.finish().unwrap();
        match depth {
            BitDepth::Eight => samples.into_iter().map(u16::from).collect(),
            _ => samples.chunks(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect(),
        }
    }

    #[test]
    fn every_level_and_number_of_strips_reads_back_with_two_decoders() {
        // The last one has five strips where no repeats are sought, and two where they are.
        for (w, h) in [(1, 1), (1, 77), (200, 1), (41, 9), (500, 400)] {
            for kind in [MapKind::Color, MapKind::Height, MapKind::Normal, MapKind::Roughness] {
                let depths = if w > 400 { vec![Depth::Eight] } else { vec![Depth::Eight, Depth::Sixteen] };
                for depth in depths {
                    let options = EncodeOptions { depths: [(kind, depth)].into(), dither: false };
                    let map = wavy(kind, w, h);
                    let expected = samples(&map, &options);
                    for level in LEVELS {
                        let bytes = encode_at(level, &map, &options);
                        assert_eq!(
                            decode(&bytes),
                            (w, h, expected.clone()),
                            "{kind} {depth:?} {level:?} {w}x{h}"
                        );
                        assert_eq!(decode_by_png(&bytes), expected, "{kind} {depth:?} {level:?} {w}x{h}");
                    }
                }
            }
        }
    }

    #[test]
    fn strips_are_one_zlib_stream_with_a_true_checksum() {
        let map = wavy(MapKind::Color, 500, 400);
        for level in LEVELS {
            let chunks = chunks(&encode_at(level, &map, &EncodeOptions::default()));
            let stream: Vec<u8> = chunks.iter().filter(|c| c.0 == "IDAT").flat_map(|c| c.1.clone()).collect();
            assert!(chunks.len() > 4, "several strips");
            let mut filtered = vec![0; 400 * 1501];
            let mut inflate = zlib_rs::Inflate::new(true, 15);
            let status = inflate.decompress(&stream, &mut filtered, zlib_rs::InflateFlush::Finish);
            assert_eq!(status, Ok(zlib_rs::Status::StreamEnd), "{level:?}");
            assert_eq!((inflate.total_in(), inflate.total_out()), (stream.len() as u64, 400 * 1501));
        }
    }

    #[test]
    fn one_two_and_seven_threads_write_the_same_bytes() {
        let map = wavy(MapKind::Color, 700, 600);
        for level in LEVELS {
            let at = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| encode_at(level, &map, &EncodeOptions::default()))
            };
            let one = at(1);
            assert!(one == at(2) && one == at(7), "{level:?}");
        }
    }

    #[test]
    fn more_time_makes_a_pattern_of_flat_colours_smaller() {
        let plane = Plane::from_fn(600, 600, |x, y| ((x / 9 * 7 + y / 9 * 13) % 11) as f32 / 10.0);
        let map = MapImage::new(MapKind::Color, vec![plane; 3]);
        let sizes = LEVELS.map(|level| encode_at(level, &map, &EncodeOptions::default()).len());
        assert!(sizes[0] > sizes[1] && sizes[1] >= sizes[2], "{sizes:?}");
    }

    #[test]
    fn what_is_found_out_in_passing_is_what_a_pass_of_its_own_finds() {
        let map = wavy(MapKind::Height, 333, 222).with_range([0.2, 0.7]);
        let options = EncodeOptions::default();
        let told = write(&map, &options, PngCompression::Fast, NOBODY, std::io::sink()).unwrap();
        assert_eq!(told.error, crate::maps::quantisation_error(&map, &options));
        assert_eq!(told.extremes, <[f32; 2]>::from(crate::base::num::min_max(map.planes[0].data())));
    }

    #[test]
    fn colour_says_srgb_and_data_says_linear_and_nothing_else_is_said() {
        for kind in MapKind::ALL {
            let chunks = chunks(&encode(&wavy(kind, 8, 8), &EncodeOptions::default()));
            let names: Vec<&str> = chunks.iter().map(|(name, _)| name.as_str()).collect();
            let (tag, content) = match kind {
                MapKind::Color => ("sRGB", vec![0]),
                _ => ("gAMA", 100_000u32.to_be_bytes().to_vec()),
            };
            assert_eq!(names, ["IHDR", tag, "IDAT", "IEND"], "{kind}");
            assert_eq!(chunks[1].1, content, "{kind}");
        }
    }

    #[test]
    fn sixteen_bit_height_has_more_than_256_levels_and_eight_bit_has_not() {
        let map = MapImage::new(MapKind::Height, vec![Plane::from_fn(64, 64, |x, y| (64 * y + x) as f32)]);
        let levels = |depth| {
            let options = EncodeOptions { depths: [(MapKind::Height, depth)].into(), dither: false };
            let (_, _, mut samples) = decode(&encode(&map, &options));
            samples.sort_unstable();
            samples.dedup();
            samples.len()
        };
        assert_eq!(levels(Depth::Sixteen), 4096);
        assert_eq!(levels(Depth::Eight), 256);
        assert_eq!(EncodeOptions::default().depth(MapKind::Height), Depth::Sixteen);
    }

    #[test]
    fn verify_accepts_the_file_and_refuses_another_map_or_a_flipped_bit() {
        let map = wavy(MapKind::Roughness, 40, 40);
        let options = EncodeOptions::default();
        let mut file = tempfile::tempfile().unwrap();
        let bytes = encode(&map, &options);
        file.write_all(&bytes).unwrap();
        let check = |map: &MapImage, file: &mut File| {
            file.seek(SeekFrom::Start(0)).unwrap();
            verify(map, &options, file)
        };
        check(&map, &mut file).unwrap();
        let mut other = map.clone();
        other.planes[0].data_mut()[1599] += 0.01;
        assert!(matches!(check(&other, &mut file), Err(Problem::ReadBack(_))));
        // Any bit of the compressed image: the decoder's checksums or the samples tell.
        file.seek(SeekFrom::Start(bytes.len() as u64 / 2)).unwrap();
        file.write_all(&[bytes[bytes.len() / 2] ^ 4]).unwrap();
        assert!(matches!(check(&map, &mut file), Err(Problem::ReadBack(_))));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn any_finite_plane_reads_back(
            w in 1usize..40, values in proptest::collection::vec(proptest::num::f32::NORMAL | proptest::num::f32::SUBNORMAL | proptest::num::f32::ZERO, 1..600),
            kind in 0usize..10, sixteen: bool, dither: bool,
        ) {
            let kind = MapKind::ALL[kind];
            let w = w.min(values.len());
            let h = values.len() / w;
            let plane = Plane::from_vec(w, h, values[..w * h].to_vec());
            let map = MapImage::new(kind, vec![plane; kind.channels()]);
            let depth = if sixteen { Depth::Sixteen } else { Depth::Eight };
            let options = EncodeOptions { depths: [(kind, depth)].into(), dither };
            prop_assert_eq!(decode(&encode(&map, &options)), (w, h, samples(&map, &options)));
        }
    }
}
