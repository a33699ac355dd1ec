//! Maps as eyes can see them, and their values in words.

use rayon::prelude::*;

use crate::base::color::linear_to_srgb;
use crate::base::{LinearRgb, MapKind, Srgb8, hash, num};
use crate::maps::MapImage;

/// What is shown of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Channel {
    /// All of it, as colours.
    #[default]
    All,
    /// One channel, as greys.
    One(usize),
}

/// A map as sRGB, row by row. Greys go from the map's least to its greatest value; ids have colours of chance.
pub(super) fn pixels(map: &MapImage, channel: Channel) -> Vec<u8> {
    let planes = &map.planes;
    let texels = planes[0].data().len();
    let byte = |v: f32| (num::saturate(v) * 255.0 + 0.5) as u8;
    let one = match channel {
        Channel::One(c) => Some(c.min(planes.len() - 1)),
        Channel::All if planes.len() < 3 => Some(0),
        Channel::All => None,
    };
    let (low, high) = one.map_or((0.0, 1.0), |c| shown_range(map, c).into());
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    let texel = |i: usize| -> [u8; 3] {
        if map.kind == MapKind::ScaleId {
            return id_color(planes[0].data()[i]);
        }
        match (one, map.kind) {
            (Some(c), MapKind::Color) => [byte(linear_to_srgb(num::saturate(planes[c].data()[i]))); 3],
            (Some(c), _) => [byte((planes[c].data()[i] - low) * scale); 3],
            (None, MapKind::Color) => {
                [0, 1, 2].map(|c| byte(linear_to_srgb(num::saturate(planes[c].data()[i]))))
            }
            (None, _) => [0, 1, 2].map(|c| byte(0.5 * planes[c].data()[i] + 0.5)),
        }
    };
    let pixels: Vec<[u8; 3]> = (0..texels).into_par_iter().with_min_len(4096).map(texel).collect();
    pixels.into_flattened()
}

/// The values that a grey picture of a channel shows as black and white.
pub(super) fn shown_range(map: &MapImage, channel: usize) -> [f32; 2] {
    match map.kind {
        MapKind::Color => [0.0, 1.0],
        MapKind::Normal => [-1.0, 1.0],
        _ => num::min_max(map.planes[channel.min(map.planes.len() - 1)].data()).into(),
    }
}

/// A colour of chance for each scale; skin is black.
fn id_color(id: f32) -> [u8; 3] {
    if id < 0.5 {
        return [0; 3];
    }
    [0, 1, 2].map(|c| 56 + (hash::hash2(7, id as u32, c) >> 24) as u8 / 4 * 3)
}

/// The value at a texel, with its unit.
pub(super) fn told(map: &MapImage, x: usize, y: usize) -> String {
    let at = |c: usize| map.planes[c].data()[y * map.planes[c].width() + x];
    match map.kind {
        MapKind::Color => {
            let [r, g, b] = [at(0), at(1), at(2)];
            format!("{}   linear {r:.3} {g:.3} {b:.3}", Srgb8::from(LinearRgb([r, g, b])))
        }
        MapKind::Normal => format!("x {:+.3}  y {:+.3}  z {:+.3}", at(0), at(1), at(2)),
        MapKind::ScaleId if at(0) < 0.5 => "skin".into(),
        MapKind::ScaleId => format!("scale {}", at(0)),
        MapKind::Iridescence => format!("{:.1} nm", at(0)),
        kind if kind.unit().is_empty() => format!("{:.3}", at(0)),
        kind => format!("{:.4} {}", at(0), kind.unit()),
    }
}

/// Names of a map's channels; none where there is one.
pub(super) fn channel_names(kind: MapKind) -> &'static [&'static str] {
    match kind {
        MapKind::Color => &["R", "G", "B"],
        MapKind::Normal => &["X", "Y", "Z"],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Plane;

    fn map(kind: MapKind, values: &[f32]) -> MapImage {
        MapImage::new(kind, values.iter().map(|v| Plane::filled(1, 1, *v)).collect())
    }

    #[test]
    fn colours_are_encoded_and_normals_are_moved_into_range() {
        assert_eq!(pixels(&map(MapKind::Color, &[0.0, 0.215_861, 1.0]), Channel::All), [0, 128, 255]);
        assert_eq!(pixels(&map(MapKind::Color, &[0.0, 0.215_861, 1.0]), Channel::One(1)), [128; 3]);
        assert_eq!(pixels(&map(MapKind::Normal, &[-1.0, 0.0, 1.0]), Channel::All), [0, 128, 255]);
    }

    #[test]
    fn greys_use_the_whole_range_and_an_even_map_is_no_trouble() {
        let plane = Plane::from_fn(3, 1, |x, _| 0.2 + 0.1 * x as f32);
        let height = MapImage::new(MapKind::Height, vec![plane]);
        let grey: Vec<u8> = pixels(&height, Channel::All).chunks(3).map(|p| p[0]).collect();
        assert_eq!((grey[0], grey[2]), (0, 255));
        assert!((127..=128).contains(&grey[1]));
        assert_eq!(pixels(&map(MapKind::Roughness, &[0.4]), Channel::All), [0; 3]);
        assert_eq!(pixels(&map(MapKind::Roughness, &[f32::NAN]), Channel::One(9)), [0; 3]);
    }

    #[test]
    fn values_are_told_in_their_unit() {
        let told = |kind, values: &[f32]| told(&map(kind, values), 0, 0);
        assert_eq!(told(MapKind::Height, &[0.214]), "0.2140 mm");
        assert_eq!(told(MapKind::Iridescence, &[260.04]), "260.0 nm");
        assert_eq!(told(MapKind::Roughness, &[0.3]), "0.300");
        assert_eq!(told(MapKind::ScaleId, &[0.0]), "skin");
        assert_eq!(told(MapKind::ScaleId, &[17.0]), "scale 17");
        assert_eq!(told(MapKind::Color, &[1.0, 0.0, 0.0]), "#FF0000   linear 1.000 0.000 0.000");
    }

    #[test]
    fn neighbouring_scales_have_other_colours() {
        let colors: std::collections::BTreeSet<_> = (1..200).map(|i| id_color(i as f32)).collect();
        assert!(colors.len() > 195);
        assert!(colors.iter().all(|c| c.iter().all(|v| *v >= 56)), "none is taken for skin");
    }
}
