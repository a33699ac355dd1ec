//! PNG files of maps: integers, tagged with what they are.
//!
//! Colour carries an `sRGB` chunk, data a `gAMA` of 1.0, because untagged grey is taken for sRGB by common readers;
//! never a time or any text. `Fast` with the Paeth filter is 12 to 40 times faster than the codec's default at
//! about 1.25 times the size, and adaptive filtering does not make these files smaller.

use std::fs::File;
use std::io::{BufReader, Write};

use ::png::{BitDepth, ColorType, Compression, Filter, ScaledFloat, SrgbRenderingIntent};

use super::Problem;
use crate::base::MapKind;
use crate::maps::{Depth, EncodeOptions, MapImage, Quantiser};

/// Compressed bytes in one IDAT chunk.
const CHUNK: usize = 1 << 18;

fn color_type(map: &MapImage) -> ColorType {
    if map.planes.len() == 3 { ColorType::Rgb } else { ColorType::Grayscale }
}

fn bit_depth(depth: Depth) -> BitDepth {
    match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    }
}

/// Write a map as PNG, row by row: memory does not grow with the image.
pub(super) fn write(map: &MapImage, options: &EncodeOptions, out: impl Write) -> Result<(), Problem> {
    let (width, height) = (map.width(), map.height());
    let side = |n: usize| {
        i32::try_from(n).map(i32::unsigned_abs).map_err(|_| Problem::Unencodable { width, height })
    };
    let quantiser = Quantiser::new(map, options);
    let mut encoder = ::png::Encoder::new(out, side(width)?, side(height)?);
    encoder.set_color(color_type(map));
    encoder.set_depth(bit_depth(quantiser.depth()));
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Paeth);
    if map.kind == MapKind::Color {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    } else {
        encoder.set_source_gamma(ScaledFloat::new(1.0));
    }
    let mut writer = encoder.write_header().map_err(problem)?;
    let mut rows = writer.stream_writer_with_size(CHUNK).map_err(problem)?;
    let (mut scratch, mut row) = (Vec::new(), vec![0; quantiser.row_bytes()]);
    for y in 0..height {
        quantiser.row(y, &mut scratch, &mut row);
        rows.write_all(&row)?;
    }
    rows.finish().map_err(problem)?;
    writer.finish().map_err(problem)
}

/// Decode what [`write()`] wrote and compare every sample.
pub(super) fn verify(map: &MapImage, options: &EncodeOptions, file: &mut File) -> Result<(), Problem> {
    let differs = |what: String| Problem::ReadBack(what);
    let quantiser = Quantiser::new(map, options);
    let decoder = ::png::Decoder::new(BufReader::with_capacity(1 << 18, file));
    let mut reader = decoder.read_info().map_err(|e| differs(e.to_string()))?;
    let info = reader.info();
    let found = (info.width as usize, info.height as usize, info.color_type, info.bit_depth);
    if found != (map.width(), map.height(), color_type(map), bit_depth(quantiser.depth())) {
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
    use crate::base::Plane;
    use proptest::prelude::*;
    use std::io::{Seek as _, SeekFrom};
    use zune_png::zune_core::{bytestream::ZCursor, result::DecodingResult};

    fn encode(map: &MapImage, options: &EncodeOptions) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(map, options, &mut bytes).unwrap();
        bytes
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
