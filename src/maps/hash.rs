//! The golden value of a map: a hash before any encoding.

use super::MapImage;

/// BLAKE3 of a map's values: kind, size, then every plane row by row as little-endian f32 bits.
///
/// It does not depend on file formats, codecs, depth or the physical range, so a change of it is a change of the
/// evaluated texture. -0 and +0 differ.
pub fn plane_hash(map: &MapImage) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"ophidian map 1\0");
    hasher.update(map.kind.name().as_bytes());
    for n in [map.width(), map.height(), map.planes.len()] {
        hasher.update(&(n as u64).to_le_bytes());
    }
    let mut bytes = Vec::with_capacity(1 << 14);
    for values in map.planes.iter().flat_map(|plane| plane.data().chunks(1 << 12)) {
        bytes.clear();
        bytes.extend(values.iter().flat_map(|v| v.to_bits().to_le_bytes()));
        hasher.update(&bytes);
    }
    hasher.finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{MapKind, Plane};

    fn map(kind: MapKind, w: usize, h: usize) -> MapImage {
        MapImage::new(kind, vec![Plane::from_fn(w, h, |x, y| (x * 31 + y * 17) as f32 * 0.01)])
    }

    /// The reference is another way to say the same bytes: one buffer, hashed at once.
    #[test]
    fn it_is_the_hash_of_kind_size_and_little_endian_bits() {
        let map = map(MapKind::Height, 130, 70);
        let mut bytes = b"ophidian map 1\0height".to_vec();
        for n in [130u64, 70, 1] {
            bytes.extend(n.to_le_bytes());
        }
        for v in map.planes[0].data() {
            bytes.extend(v.to_le_bytes());
        }
        assert_eq!(plane_hash(&map), *blake3::hash(&bytes).as_bytes());
    }

    #[test]
    fn one_bit_the_shape_or_the_kind_changes_it_and_the_range_does_not() {
        let a = map(MapKind::Height, 6, 4);
        let mut flipped = a.clone();
        let v = &mut flipped.planes[0].data_mut()[7];
        *v = f32::from_bits(v.to_bits() ^ 1);
        assert_ne!(plane_hash(&a), plane_hash(&flipped));
        let reshaped =
            MapImage { planes: vec![Plane::from_vec(4, 6, a.planes[0].data().to_vec())], ..a.clone() };
        assert_ne!(plane_hash(&a), plane_hash(&reshaped));
        assert_ne!(plane_hash(&a), plane_hash(&MapImage { kind: MapKind::Roughness, ..a.clone() }));
        assert_eq!(plane_hash(&a), plane_hash(&a.clone().with_range([0.0, 9.0])));
    }
}
