//! Radiance pictures (`.hdr`), the usual form of environments: three bytes of colour with an exponent in common.
//!
//! Source: Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's `picture_format`. The forms that are written today are
//! read: RGB, rows from the top, columns from the left, plain or in either of the two run-length codes.

use std::io::{BufRead, ErrorKind, Read};

use super::Problem;
use super::read::limit;
use crate::base::Plane;
use crate::node::Asset;

/// How such a file begins.
pub(super) const MAGIC: [&[u8]; 2] = [b"#?RADIAN", b"#?RGBE"];

/// Longest line of a header, and most of them.
const MAX_LINE: u64 = 4096;
const MAX_LINES: usize = 256;

fn refuse(message: impl Into<String>) -> Problem {
    Problem::Format { format: "Radiance HDR", message: message.into() }
}

fn problem(error: std::io::Error) -> Problem {
    if error.kind() == ErrorKind::UnexpectedEof { refuse("it ends too early") } else { error.into() }
}

/// Read a picture: three planes of linear RGB as they are stored, divided by the file's exposures.
pub(super) fn read(mut file: impl BufRead) -> Result<Asset, Problem> {
    let mut exposure = 1.0_f32;
    let mut lines = 0;
    loop {
        let text = line(&mut file)?;
        lines += 1;
        if text.is_empty() {
            break;
        }
        if lines > MAX_LINES {
            return Err(refuse("its header has no end"));
        }
        match text.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("FORMAT", format)) if format != "32-bit_rle_rgbe" => {
                return Err(refuse(format!("its format is {}", format.escape_debug())));
            }
            // Several ones multiply.
            Some(("EXPOSURE", value)) => exposure *= value.parse().unwrap_or(f32::NAN),
            _ => {}
        }
    }
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(refuse("its exposure is no positive number"));
    }
    let size = line(&mut file)?;
    let words: Vec<&str> = size.split_whitespace().collect();
    let number = |word: &str| word.parse::<u32>().ok().filter(|n| *n > 0);
    let (width, height) = match words[..] {
        ["-Y", height, "+X", width] => number(width).zip(number(height)),
        _ => None,
    }
    .ok_or_else(|| refuse("its size is not written as `-Y height +X width`"))?;
    limit(width.into(), height.into(), 3)?;
    let (width, height) = (width as usize, height as usize);
    let mut channels = [(); 3].map(|()| Vec::new());
    let mut row = vec![[0; 4]; width];
    for _ in 0..height {
        read_row(&mut file, &mut row)?;
        for [r, g, b, exponent] in &row {
            let scale = power_of_two(i32::from(*exponent) - 136) / exposure;
            for (channel, value) in channels.iter_mut().zip([r, g, b]) {
                channel.push(if *exponent == 0 { 0.0 } else { f32::from(*value) * scale });
            }
        }
    }
    let channels = channels.into_iter().map(|values| Plane::from_vec(width, height, values)).collect();
    Ok(Asset { channels, alpha: None })
}

/// 2^n as f32, n in [-136, 119]: exact, with subnormals.
fn power_of_two(n: i32) -> f32 {
    libm::ldexp(1.0, n) as f32
}

/// A line without its end.
fn line(file: &mut impl BufRead) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    file.take(MAX_LINE).read_until(b'\n', &mut bytes)?;
    if bytes.pop() != Some(b'\n') {
        return Err(refuse("its header is damaged"));
    }
    Ok(String::from_utf8_lossy(&bytes).trim_end_matches('\r').to_owned())
}

fn read_row(file: &mut impl Read, row: &mut [[u8; 4]]) -> Result<(), Problem> {
    let mut first = [0; 4];
    file.read_exact(&mut first).map_err(problem)?;
    let length = usize::from(first[2]) << 8 | usize::from(first[3]);
    if first[..2] == [2, 2] && first[2] < 128 && row.len() >= 8 {
        if length != row.len() {
            return Err(refuse("a row has another length than the picture"));
        }
        return read_channels(file, row);
    }
    // Plain texels; (1, 1, 1, n) repeats the one before, and directly after another such one n counts 256 times.
    let (mut at, mut shift, mut texel) = (0_usize, 0_u32, first);
    loop {
        if texel[..3] == [1, 1, 1] {
            let count = usize::from(texel[3]).checked_shl(shift).unwrap_or(usize::MAX);
            let before =
                at.checked_sub(1).map(|i| row[i]).ok_or_else(|| refuse("a row begins with a run"))?;
            let end = at.checked_add(count).filter(|end| *end <= row.len());
            row[at..end.ok_or_else(|| refuse("a run leaves its row"))?].fill(before);
            (at, shift) = (at + count, shift + 8);
            if shift > 24 {
                return Err(refuse("a run has no end"));
            }
        } else {
            row[at] = texel;
            (at, shift) = (at + 1, 0);
        }
        if at == row.len() {
            return Ok(());
        }
        file.read_exact(&mut texel).map_err(problem)?;
    }
}

/// A row channel by channel: a count up to 128 and as many bytes, or 128 + count and the byte that is repeated.
fn read_channels(file: &mut impl Read, row: &mut [[u8; 4]]) -> Result<(), Problem> {
    for channel in 0..4 {
        let mut at = 0;
        while at < row.len() {
            let mut code = [0; 2];
            file.read_exact(&mut code).map_err(problem)?;
            let [count, value] = code;
            let run = count > 128;
            let count = usize::from(if run { count - 128 } else { count });
            if count == 0 || at + count > row.len() {
                return Err(refuse("a run leaves its row"));
            }
            row[at][channel] = value;
            if run {
                row[at..at + count].iter_mut().for_each(|texel| texel[channel] = value);
            } else {
                let mut rest = [0; 128];
                file.read_exact(&mut rest[..count - 1]).map_err(problem)?;
                for (texel, value) in row[at + 1..at + count].iter_mut().zip(rest) {
                    texel[channel] = value;
                }
            }
            at += count;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::hdr::HdrEncoder;

    fn texel(i: usize) -> [f32; 3] {
        let x = i as f32;
        [(x * 0.37).sin().abs() * 1e-3, if i % 40 < 25 { 7.0 } else { x }, 1e4 / (1.0 + x)]
    }

    /// Written by another library: narrow pictures are plain, wide ones in runs.
    #[test]
    fn what_another_library_writes_is_read_within_its_eight_bits() {
        for (width, height) in [(5, 3), (200, 7)] {
            let texels: Vec<_> = (0..width * height).map(|i| image::Rgb(texel(i))).collect();
            let mut bytes = Vec::new();
            HdrEncoder::new(&mut bytes).encode(&texels, width, height).expect("it writes");
            let asset = read(&bytes[..]).expect("a picture");
            assert_eq!((asset.channels.len(), asset.channels[0].width()), (3, width));
            for i in 0..width * height {
                let most = texel(i).into_iter().fold(0.0, f32::max);
                for (c, plane) in asset.channels.iter().enumerate() {
                    let error = (plane.data()[i] - texel(i)[c]).abs();
                    assert!(error <= most / 128.0, "{i} {c}: {error} of {most}");
                }
            }
        }
    }

    fn picture(header: &str, size: &str, data: &[u8]) -> Result<Asset, Problem> {
        let mut bytes = format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
        bytes.extend(data);
        read(&bytes[..])
    }

    #[test]
    fn values_runs_and_exposures_are_as_the_format_says() {
        // 128 * 2^(129 - 136) = 1; a run of old: the texel again, 1 + 256 times.
        let one = [128, 64, 0, 129];
        let asset = picture("", "-Y 1 +X 3", &[one, [1, 1, 1, 2], [0; 4]].concat()).expect("a picture");
        assert_eq!(asset.channels[0].data(), [1.0; 3]);
        assert_eq!((asset.channels[1].at(2, 0), asset.channels[2].at(2, 0)), (0.5, 0.0));
        let wide = [one, [1, 1, 1, 1], [1, 1, 1, 1]].concat();
        assert_eq!(picture("", "-Y 1 +X 258", &wide).expect("a picture").channels[0].at(257, 0), 1.0);
        let twice = picture("EXPOSURE=4\r\nEXPOSURE=0.5\n", "-Y 1 +X 1", &one).expect("a picture");
        assert_eq!(twice.channels[0].data(), [0.5]);
        assert_eq!(picture("", "-Y 1 +X 1", &[255, 3, 9, 0]).expect("a picture").channels[0].data(), [0.0]);
    }

    #[test]
    fn damaged_pictures_are_refused() {
        let told = |header: &str, size: &str, data: &[u8]| match picture(header, size, data) {
            Err(Problem::Format { message, .. }) => message,
            other => panic!("{other:?}"),
        };
        assert_eq!(told("FORMAT=32-bit_rle_xyze\n", "-Y 1 +X 1", &[]), "its format is 32-bit_rle_xyze");
        assert_eq!(told("EXPOSURE=0\n", "-Y 1 +X 1", &[]), "its exposure is no positive number");
        assert!(told("", "+X 1 -Y 1", &[0; 4]).starts_with("its size"));
        assert_eq!(told("", "-Y 2 +X 1", &[0; 4]), "it ends too early");
        assert_eq!(told("", "-Y 1 +X 1", &[1, 1, 1, 1]), "a row begins with a run");
        assert_eq!(told("", "-Y 1 +X 2", &[9, 9, 9, 9, 1, 1, 1, 2]), "a run leaves its row");
        assert!(told("", "-Y 1 +X 9", &[2, 2, 0, 8]).starts_with("a row has another length"));
        assert_eq!(told("", "-Y 1 +X 8", &[2, 2, 0, 8, 0, 0]), "a run leaves its row");
        assert!(matches!(picture("", "-Y 1000000 +X 1000000", &[]), Err(Problem::TooLarge { .. })));
        let runs = [9, 9, 9, 9].into_iter().chain([1, 1, 1, 0].into_iter().cycle().take(400));
        assert_eq!(told("", "-Y 1 +X 5", &runs.collect::<Vec<u8>>()), "a run has no end");
    }
}
