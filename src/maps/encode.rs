//! Values to integers: transfer, range, rounding, dither, and the error of it.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::MapImage;
use super::samples::{self, RowError};
use super::srgb::{self, Codes};
use crate::base::{MapKind, Plane, Rows, hash};

/// Bits of an integer sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depth {
    /// 8 bits: 256 levels.
    Eight,
    /// 16 bits: 65 536 levels.
    Sixteen,
}

impl Depth {
    /// The depth in which a map is written unless asked otherwise: 16 bits for what is displaced, differentiated
    /// or looked up (height, film thickness, curvature, ids), 8 for the rest.
    pub fn default_for(kind: MapKind) -> Self {
        match kind {
            MapKind::Height | MapKind::Iridescence | MapKind::Curvature | MapKind::ScaleId => Self::Sixteen,
            _ => Self::Eight,
        }
    }

    /// The greatest sample.
    pub fn max(self) -> u16 {
        match self {
            Self::Eight => u16::from(u8::MAX),
            Self::Sixteen => u16::MAX,
        }
    }

    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::Eight => 1,
            Self::Sixteen => 2,
        }
    }
}

/// How maps become integers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EncodeOptions {
    /// Depths that differ from [`Depth::default_for`]. Ids are always 16 bits.
    pub depths: BTreeMap<MapKind, Depth>,
    /// Break the bands of 8-bit maps by noise of one step, a hash of the texel's coordinates: the mean of an area
    /// is kept, the error of a texel at most doubles. 16-bit maps are never dithered.
    pub dither: bool,
}

impl EncodeOptions {
    /// The depth of a map.
    pub fn depth(&self, kind: MapKind) -> Depth {
        match (kind, self.depths.get(&kind)) {
            (MapKind::ScaleId, _) => Depth::Sixteen,
            (_, Some(&depth)) => depth,
            (_, None) => Depth::default_for(kind),
        }
    }
}

/// How far a map's samples are from its values.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuantError {
    /// Largest absolute error, in the map's unit (linear light for colour), clamping included.
    pub max: f32,
    /// Root mean square error, in the same unit.
    pub rms: f32,
}

/// How a value becomes a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// Linear light through the sRGB transfer function.
    Srgb,
    /// `(v - offset) * scale`.
    Linear { offset: f32, scale: f32 },
    /// The low 16 bits of a whole number.
    Id,
}

/// Turns the rows of one map into samples.
#[derive(Debug)]
pub struct Quantiser<'a> {
    kind: MapKind,
    range: [f32; 2],
    lanes: Vec<Rows<'a>>,
    depth: Depth,
    dither: bool,
    rule: Rule,
}

impl<'a> Quantiser<'a> {
    /// The quantiser of a map.
    pub fn new(map: &'a MapImage, options: &EncodeOptions) -> Self {
        Self::of_rows(map.kind, map.range, map.planes.iter().map(Plane::rows).collect(), options)
    }

    /// The quantiser of some rows of a map in this range, a lane for each channel.
    pub fn of_rows(kind: MapKind, range: [f32; 2], lanes: Vec<Rows<'a>>, options: &EncodeOptions) -> Self {
        let depth = options.depth(kind);
        let rule = match kind {
            MapKind::Color => Rule::Srgb,
            MapKind::ScaleId => Rule::Id,
            _ => {
                let [lo, hi] = range;
                let span = hi - lo;
                let usable = lo.is_finite() && span.is_finite() && span > 0.0 && (1.0 / span).is_finite();
                Rule::Linear {
                    offset: if usable { lo } else { 0.0 },
                    scale: if usable { 1.0 / span } else { 0.0 },
                }
            }
        };
        Self { kind, range, lanes, depth, dither: options.dither && depth == Depth::Eight, rule }
    }

    /// Bits of a sample.
    pub fn depth(&self) -> Depth {
        self.depth
    }

    /// What the map is.
    pub fn kind(&self) -> MapKind {
        self.kind
    }

    /// Channels.
    pub fn channels(&self) -> usize {
        self.lanes.len()
    }

    /// Bytes of a row of samples.
    pub fn row_bytes(&self) -> usize {
        self.width() * self.lanes.len() * self.depth.bytes()
    }

    /// Texels of a row.
    pub fn width(&self) -> usize {
        self.lanes[0].width()
    }

    /// Row `y` as interleaved samples, big-endian where they have 16 bits, into `out` ([`Self::row_bytes`] long).
    ///
    /// NaN becomes 0. `codes` holds the samples channel by channel afterwards.
    pub fn row(&self, y: usize, codes: &mut Vec<u16>, out: &mut [u8]) {
        debug_assert_eq!(out.len(), self.row_bytes());
        self.codes(y, codes);
        let width = self.width();
        match (self.depth, self.lanes.len()) {
            (Depth::Eight, 1) => samples::pack_grey8(codes, out),
            (Depth::Sixteen, 1) => samples::pack_grey16(codes, out),
            (depth, _) => {
                let (r, gb) = codes.split_at(width);
                let (g, b) = gb.split_at(width);
                match depth {
                    Depth::Eight => samples::pack_rgb8(r, g, b, out),
                    Depth::Sixteen => samples::pack_rgb16(r, g, b, out),
                }
            }
        }
    }

    /// What is to be told of row `y`, from the codes that [`Self::row`] left.
    pub fn told(&self, y: usize, codes: &[u16]) -> RowTold {
        let mut told = RowTold { extremes: [f32::INFINITY, f32::NEG_INFINITY], ..RowTold::default() };
        for (plane, codes) in self.lanes.iter().zip(codes.chunks(self.width())) {
            let row = plane.row(y as i64);
            let (max, sum) = self.error(row, codes);
            told.max = told.max.max(max);
            told.sum += sum;
            told.extremes = union(told.extremes, samples::extremes(row));
        }
        told
    }

    /// The samples of row `y`, channel by channel.
    fn codes(&self, y: usize, codes: &mut Vec<u16>) {
        let width = self.width();
        codes.resize(width * self.lanes.len(), 0);
        let max = f32::from(self.depth.max());
        for (c, (plane, out)) in self.lanes.iter().zip(codes.chunks_mut(width)).enumerate() {
            let row = plane.row(y as i64);
            let seed = hash::hash2(0x0d17_4e12, self.kind as u32, c as u32);
            match self.rule {
                Rule::Srgb if self.dither => samples::srgb_dithered(row, max, seed, y as u32, out),
                Rule::Srgb if self.depth == Depth::Eight => srgb::codes(Codes::get(), row, out),
                Rule::Srgb => samples::srgb(row, max, out),
                Rule::Linear { offset, scale } if self.dither => {
                    samples::linear_dithered(row, offset, scale, max, seed, y as u32, out);
                }
                Rule::Linear { offset, scale } => samples::linear(row, offset, scale, max, out),
                Rule::Id => samples::ids(row, out),
            }
        }
    }

    /// Largest and summed squared error of one channel of a row.
    fn error(&self, row: &[f32], codes: &[u16]) -> RowError {
        let step = 1.0 / f32::from(self.depth.max());
        match self.rule {
            Rule::Srgb if self.depth == Depth::Eight => samples::srgb8_error(row, codes, Codes::get()),
            Rule::Srgb => samples::srgb_error(row, codes, step),
            Rule::Linear { offset, .. } => {
                samples::linear_error(row, codes, offset, (self.range[1] - offset) * step)
            }
            Rule::Id => samples::linear_error(row, codes, 0.0, 1.0),
        }
    }
}

/// What encoding finds out about a row, in passing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowTold {
    /// Largest absolute error.
    max: f32,
    /// Sum of squared errors.
    sum: f64,
    /// Least and greatest finite value.
    extremes: [f32; 2],
}

/// What encoding finds out about a map, in passing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapTold {
    /// The error that the samples carry.
    pub error: QuantError,
    /// Least and greatest finite value of all channels, in the map's unit; 0 and 0 where there is none.
    pub extremes: [f32; 2],
}

impl MapTold {
    /// Of all rows of a map of so many values, in order: the sum depends on it.
    pub fn of_rows(values: usize, rows: impl IntoIterator<Item = RowTold>) -> Self {
        let start = RowTold { extremes: [f32::INFINITY, f32::NEG_INFINITY], ..RowTold::default() };
        let all = rows.into_iter().fold(start, |all, row| RowTold {
            max: all.max.max(row.max),
            sum: all.sum + row.sum,
            extremes: union(all.extremes, row.extremes),
        });
        let count = values as f64;
        let [least, most] = all.extremes;
        Self {
            error: QuantError { max: all.max, rms: (all.sum / count).sqrt() as f32 },
            extremes: if least <= most { all.extremes } else { [0.0; 2] },
        }
    }

    /// Whether a map of ids has one that needs more than 16 bits, so that samples hold its low 16 bits only.
    pub fn wraps_ids(&self) -> bool {
        self.extremes[1] > 65_535.0
    }
}

fn union([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a.min(c), b.max(d)]
}

/// The error that the samples of a map carry; rows in parallel, summed in order.
pub fn quantisation_error(map: &MapImage, options: &EncodeOptions) -> QuantError {
    let quantiser = Quantiser::new(map, options);
    let row = |codes: &mut Vec<u16>, y| {
        quantiser.codes(y, codes);
        quantiser.told(y, codes)
    };
    let rows: Vec<_> = (0..map.height()).into_par_iter().map_init(Vec::new, row).collect();
    MapTold::of_rows(map.width() * map.height() * map.planes.len(), rows).error
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{LinearRgb, Srgb8};
    use proptest::prelude::*;

    fn samples(map: &MapImage, options: &EncodeOptions) -> Vec<u16> {
        let q = Quantiser::new(map, options);
        let (mut scratch, mut out) = (Vec::new(), vec![0; q.row_bytes()]);
        let mut all = Vec::new();
        for y in 0..map.height() {
            q.row(y, &mut scratch, &mut out);
            match q.depth() {
                Depth::Eight => all.extend(out.iter().map(|&b| u16::from(b))),
                Depth::Sixteen => all.extend(out.chunks(2).map(|b| u16::from_be_bytes([b[0], b[1]]))),
            }
        }
        all
    }

    fn grey(kind: MapKind, values: &[f32]) -> MapImage {
        MapImage::new(kind, vec![Plane::from_vec(values.len(), 1, values.to_vec())])
    }

    fn wraps(map: &MapImage) -> bool {
        let quantiser = Quantiser::new(map, &EncodeOptions::default());
        let mut codes = Vec::new();
        quantiser.codes(0, &mut codes);
        MapTold::of_rows(map.width(), [quantiser.told(0, &codes)]).wraps_ids()
    }

    fn with_depth(kind: MapKind, depth: Depth) -> EncodeOptions {
        EncodeOptions { depths: [(kind, depth)].into(), dither: false }
    }

    #[test]
    fn the_ends_of_the_range_are_the_ends_of_the_samples_and_the_outside_is_clamped() {
        let map = grey(MapKind::Height, &[-1.0, 0.5, 1.5, 2.5, 1e30, -1e30, f32::MAX, f32::MIN]);
        let map = map.with_range([0.5, 2.5]);
        let all = samples(&map, &EncodeOptions::default());
        assert_eq!(all, [0, 0, 32768, 65535, 65535, 0, 65535, 0]);
    }

    #[test]
    fn an_empty_or_infinite_range_gives_zeros_and_never_panics() {
        for range in [
            [1.0, 1.0],
            [2.0, 1.0],
            [f32::MIN, f32::MAX],
            [0.0, f32::INFINITY],
            [f32::NAN, 1.0],
            [0.0, 1e-45],
        ] {
            let map = grey(MapKind::Height, &[0.0, 1.0, f32::MAX, f32::NAN]).with_range(range);
            assert_eq!(samples(&map, &EncodeOptions::default()), [0; 4], "{range:?}");
            let _ = quantisation_error(&map, &EncodeOptions::default());
        }
    }

    #[test]
    fn colour_is_the_srgb_of_the_colour_type() {
        let bytes: Vec<u8> = (0..=255).collect();
        let linear: Vec<f32> = bytes.iter().map(|&b| LinearRgb::from(Srgb8([b; 3])).0[0]).collect();
        let map = MapImage::new(MapKind::Color, vec![Plane::from_vec(256, 1, linear); 3]);
        let all = samples(&map, &EncodeOptions::default());
        assert!(all.chunks(3).zip(bytes).all(|(rgb, b)| rgb == [u16::from(b); 3]));
    }

    #[test]
    fn normals_are_half_of_n_plus_one_interleaved() {
        let flat = [0.0, 0.0, 1.0].map(|v| Plane::filled(2, 1, v)).to_vec();
        let map = MapImage::new(MapKind::Normal, flat);
        assert_eq!(samples(&map, &EncodeOptions::default()), [128, 128, 255, 128, 128, 255]);
    }

    #[test]
    fn ids_are_exact_and_beyond_16_bits_keep_their_low_bits() {
        let map = grey(MapKind::ScaleId, &[0.0, 1.0, 65535.0]);
        let q = EncodeOptions::default();
        assert_eq!(samples(&map, &q), [0, 1, 65535]);
        assert!(!wraps(&map));
        assert_eq!(quantisation_error(&map, &q), QuantError::default());
        let map = grey(MapKind::ScaleId, &[65536.0, 65539.0, 1_000_000.0]);
        assert_eq!(samples(&map, &q), [0, 3, (1_000_000 % 65536) as u16]);
        assert!(wraps(&map));
        assert_eq!(with_depth(MapKind::ScaleId, Depth::Eight).depth(MapKind::ScaleId), Depth::Sixteen);
    }

    #[test]
    fn dither_keeps_the_mean_and_exact_samples() {
        let options = EncodeOptions { dither: true, ..EncodeOptions::default() };
        let value = 100.3 / 255.0;
        let map = MapImage::new(MapKind::Roughness, vec![Plane::filled(256, 256, value)]);
        let all = samples(&map, &options);
        let mean = all.iter().map(|&s| f64::from(s)).sum::<f64>() / all.len() as f64;
        // Standard error of a Bernoulli(0.3) mean of 65536 is 0.0018.
        assert!((mean - 100.3).abs() < 0.01, "{mean}");
        assert!(all.iter().all(|&s| s == 100 || s == 101));
        for (v, code) in [(0.0, 0), (1.0, 255)] {
            let map = MapImage::new(MapKind::Roughness, vec![Plane::filled(64, 64, v)]);
            assert!(samples(&map, &options).iter().all(|&s| s == code));
        }
        // 16 bits are never dithered.
        let map = grey(MapKind::Height, &[0.0, 0.123, 1.0]);
        assert_eq!(samples(&map, &options), samples(&map, &EncodeOptions::default()));
    }

    proptest! {
        #[test]
        fn the_stated_error_is_that_of_a_plain_f64_decoder(
            values in proptest::collection::vec(-3.0f32..9.0, 1..200), sixteen: bool, dither: bool,
        ) {
            let depth = if sixteen { Depth::Sixteen } else { Depth::Eight };
            let map = grey(MapKind::Height, &values).with_range([-2.0, 7.0]);
            let options = EncodeOptions { dither, ..with_depth(MapKind::Height, depth) };
            let all = samples(&map, &options);
            let step = 9.0 / f64::from(depth.max());
            let errors: Vec<f64> =
                all.iter().zip(&values).map(|(&s, &v)| (f64::from(v) - (f64::from(s) * step - 2.0)).abs()).collect();
            let stated = quantisation_error(&map, &options);
            let max = errors.iter().copied().fold(0.0, f64::max);
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            prop_assert!((f64::from(stated.max) - max).abs() < 2e-6, "{stated:?} {max}");
            prop_assert!((f64::from(stated.rms) - rms).abs() < 2e-6, "{stated:?} {rms}");
            let inside = all.iter().zip(&values).zip(&errors).filter(|((_, v), _)| (-2.0..=7.0).contains(*v));
            let bound = if dither && !sixteen { 1.0 } else { 0.5 };
            for (_, e) in inside {
                prop_assert!(*e <= bound * step * 1.02 + 1e-6);
            }
        }

        #[test]
        fn any_float_becomes_a_sample(bits: Vec<u32>, lo: f32, hi: f32, color: bool) {
            let values: Vec<f32> = bits.into_iter().chain([0]).map(f32::from_bits).collect();
            let plane = Plane::from_vec(values.len(), 1, values);
            let map = if color {
                MapImage::new(MapKind::Color, vec![plane; 3])
            } else {
                MapImage::new(MapKind::Height, vec![plane]).with_range([lo, hi])
            };
            let _ = samples(&map, &EncodeOptions { dither: true, ..EncodeOptions::default() });
        }
    }
}
