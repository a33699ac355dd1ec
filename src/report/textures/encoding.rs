//! What integers lose of a map, and the time that they take in a file.

use std::io::Cursor;
use std::time::Instant;

use half::f16;

use super::difference::{Difference, Texels};
use super::resample::averaged;
use super::{Problem, Row};
use crate::base::MapKind;
use crate::eval::MapPlanes;
use crate::io::{ExrOptions, ExrSample, PngCompression, encode_exr, encode_png};
use crate::maps::{Depth, EncodeOptions, MapImage, Quantiser};

/// Texels of a side of the squares whose means are compared: what a viewer further away sees.
const FAR: usize = 8;

/// Rows of one map: in 8 bits, in 8 bits with dither, in 16, and as half floats.
pub(super) fn rows(kind: MapKind, planes: &MapPlanes, rounds: usize) -> Result<Vec<Row>, Problem> {
    let truth = Texels::of(kind, planes);
    let image = MapImage::of(kind, planes.clone());
    let mut rows = Vec::new();
    let option = |depth, dither| EncodeOptions { depths: [(kind, depth)].into(), dither };
    let sixteen = option(Depth::Sixteen, false);
    let exact_ms = time(&image, &sixteen, rounds)?;
    // Ids have 16 bits always.
    let eights =
        [("8 bits", option(Depth::Eight, false)), ("8 bits with dither", option(Depth::Eight, true))];
    for (name, options) in eights.iter().filter(|_| kind != MapKind::ScaleId) {
        let ours = decoded(&image, options);
        let ms = Some(time(&image, options, rounds)?);
        let row = |shortcut: String, difference| Row {
            group: "encoding",
            shortcut,
            truth: "16 bits".into(),
            map: Some((kind, planes.range)),
            difference,
            ms,
            exact_ms: Some(exact_ms),
        };
        rows.push(row((*name).into(), Difference::between(&ours, &truth)));
        let height = truth.len() / truth.width;
        if truth.width >= FAR && height >= FAR {
            let far = Difference::between(&averaged(&ours, FAR), &averaged(&truth, FAR));
            rows.push(row(format!("{name}, means of {FAR} x {FAR}"), far));
        }
    }
    rows.push(Row {
        group: "encoding",
        shortcut: "16 bits".into(),
        truth: "32-bit floats".into(),
        map: Some((kind, planes.range)),
        difference: Difference::between(&decoded(&image, &sixteen), &truth),
        ms: Some(exact_ms),
        exact_ms: None,
    });
    // Ids are 32-bit floats always.
    if kind != MapKind::ScaleId {
        let as_exr = |sample| time_exr(&image, sample, rounds);
        rows.push(Row {
            group: "encoding",
            shortcut: "half floats, OpenEXR".into(),
            truth: "32-bit floats, OpenEXR".into(),
            map: Some((kind, planes.range)),
            difference: Difference::between(&halved(kind, planes), &truth),
            ms: Some(as_exr(ExrSample::Half)?),
            exact_ms: Some(as_exr(ExrSample::Float)?),
        });
    }
    Ok(rows)
}

/// A map whose values are rounded to half floats.
fn halved(kind: MapKind, planes: &MapPlanes) -> Texels {
    let half = |v: &f32| f64::from(f16::from_f32(*v));
    let channels = planes.planes.iter().map(|plane| plane.data().iter().map(half).collect()).collect();
    Texels { kind, width: planes.planes[0].width(), channels }
}

/// The fastest of so many OpenEXR files of a map that go nowhere, ms.
fn time_exr(image: &MapImage, sample: ExrSample, rounds: usize) -> Result<f64, Problem> {
    let options = ExrOptions { samples: [(image.kind, sample)].into(), ..ExrOptions::default() };
    let mut best = f64::INFINITY;
    for _ in 0..rounds.max(1) {
        let start = Instant::now();
        encode_exr(image, &options, Cursor::new(Vec::new()))?;
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(best)
}

/// The fastest of so many PNG files of a map that go nowhere, ms.
fn time(image: &MapImage, options: &EncodeOptions, rounds: usize) -> Result<f64, Problem> {
    let mut best = f64::INFINITY;
    for _ in 0..rounds.max(1) {
        let start = Instant::now();
        encode_png(image, options, PngCompression::default(), std::io::sink())?;
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(best)
}

/// What a reader makes of the samples of a map.
fn decoded(image: &MapImage, options: &EncodeOptions) -> Texels {
    let quantiser = Quantiser::new(image, options);
    let (count, depth) = (image.planes.len(), quantiser.depth());
    let (mut codes, mut row) = (Vec::new(), vec![0; quantiser.row_bytes()]);
    let mut channels = vec![Vec::with_capacity(image.width() * image.height()); count];
    let [low, high] = image.range.map(f64::from);
    let value = |sample: u16| {
        let share = f64::from(sample) / f64::from(depth.max());
        match image.kind {
            MapKind::ScaleId => f64::from(sample),
            MapKind::Color if share <= 0.04045 => share / 12.92,
            MapKind::Color => libm::pow((share + 0.055) / 1.055, 2.4),
            _ => low + share * (high - low),
        }
    };
    for y in 0..image.height() {
        quantiser.row(y, &mut codes, &mut row);
        for (i, bytes) in row.chunks_exact(depth.bytes()).enumerate() {
            let sample = bytes.iter().fold(0u16, |all, b| all << 8 | u16::from(*b));
            channels[i % count].push(value(sample));
        }
    }
    Texels { kind: image.kind, width: image.width(), channels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Plane, hash};

    /// Rounding to steps of `s` is at most s / 2 off, with an RMS of s / sqrt(12); dither adds as much noise again and
    /// keeps the mean.
    #[test]
    fn errors_of_integers_are_those_of_rounding() {
        let noise = |x, y| 2.0 * hash::unit(hash::hash2(1, x as u32, y as u32));
        let planes = MapPlanes { planes: vec![Plane::from_fn(256, 256, noise)], range: [0.0, 2.0] };
        let rows = rows(MapKind::Height, &planes, 1).expect("integers");
        let of = |name: &str| rows.iter().find(|r| r.shortcut == name).expect("a row").difference;
        let near = |a: f64, b: f64, share: f64| assert!((a / b - 1.0).abs() < share, "{a} {b}");
        for (name, step) in [("8 bits", 2.0 / 255.0), ("16 bits", 2.0 / 65_535.0)] {
            near(of(name).max, 0.5 * step, 0.02);
            near(of(name).rms, step / 12f64.sqrt(), 0.02);
        }
        assert!(of("8 bits with dither").rms > 1.2 * of("8 bits").rms);
        near(of("8 bits, means of 8 x 8").rms, of("8 bits").rms / 8.0, 0.05);
        // Between 1 and 2 halves are 2^-10 apart, below as much closer as numbers are smaller: at 1/2^k to 2/2^k by 2^-k.
        let half = of("half floats, OpenEXR");
        near(half.max, 0.5 / 1024.0, 0.02);
        let step_2: f64 = (0..12).map(|k| 0.5f64.powi(k + 1) * 0.25f64.powi(k)).sum();
        near(half.rms, (step_2 / 12.0).sqrt() / 1024.0, 0.02);
        // A flat map shows what dither is for: without it the mean is off by as much as each texel.
        let flat = MapPlanes { planes: vec![Plane::filled(64, 64, 100.3 / 255.0)], range: [0.0, 1.0] };
        let rows = super::rows(MapKind::Roughness, &flat, 1).expect("integers");
        let of = |name: &str| rows.iter().find(|r| r.shortcut == name).expect("a row").difference.rms;
        near(of("8 bits, means of 8 x 8"), 0.3 / 255.0, 1e-3);
        assert!(of("8 bits with dither, means of 8 x 8") < 0.25 * of("8 bits, means of 8 x 8"));
    }

    #[test]
    fn colours_decode_by_the_transfer_function() {
        let value = 0.2f32;
        let planes = MapPlanes { planes: vec![Plane::filled(8, 8, value); 3], range: [0.0, 1.0] };
        let rows = rows(MapKind::Color, &planes, 1).expect("integers");
        // 0.2 encodes to 0.4845 (IEC 61966-2-1), 123.55 of 255: sample 124 is 0.20156.
        assert!((rows[0].difference.max - 0.001_56).abs() < 2e-5, "{:?}", rows[0].difference);
    }
}
