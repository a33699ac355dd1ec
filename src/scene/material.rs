//! What a surface is made of: constants, and maps over them.

use std::sync::Arc;

use crate::base::{LinearRgb, MapKind, Plane, num};
use crate::maps::{NormalFormat, TextureSet};
use crate::optics::layered::Constants;

/// A surface. Where [`Material::maps`] has a map, it stands in place of the constant.
#[derive(Clone, Debug)]
pub struct Material {
    /// Indices, absorption, base and energy mode.
    pub constants: Constants,
    /// Albedo where there is no colour map.
    pub color: LinearRgb,
    /// Perceptual roughness (alpha = roughness^2) where there is no map, in [0, 1].
    pub roughness: f32,
    /// Film thickness where there is no map, nm; 0 is no film.
    pub thickness_nm: f32,
    /// The maps of a texture set.
    pub maps: Option<Arc<SkinMaps>>,
}

impl Material {
    /// The surface at texture coordinates, in tiles.
    #[inline]
    pub fn texel(&self, u: f32, v: f32) -> Texel {
        match &self.maps {
            Some(maps) => maps.sample(u, v),
            None => self.constant(),
        }
    }

    /// The surface where there is no map: an even, plain one.
    pub fn constant(&self) -> Texel {
        Texel {
            color: self.color.0,
            roughness: self.roughness,
            normal: [0.0, 0.0, 1.0],
            thickness_nm: self.thickness_nm,
        }
    }
}

/// The maps of a set that shading reads, interleaved: one place, one read.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinMaps {
    /// Texels across u.
    pub width: usize,
    /// Texels along v.
    pub height: usize,
    /// Row by row; v = 0 first.
    pub texels: Vec<Texel>,
    /// Height of the surface, mm, if the set has it: row by row.
    pub height_mm: Option<Vec<f32>>,
    /// Physical size of the tile, mm: u, then v.
    pub size_mm: [f32; 2],
}

/// One texel, 32 bytes. What the set lacks is filled with the material's constants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Texel {
    /// Apparent albedo, linear RGB.
    pub color: [f32; 3],
    /// Perceptual roughness.
    pub roughness: f32,
    /// Unit normal in tangent space (OpenGL: x along growing u, y up the image, which is towards smaller v).
    pub normal: [f32; 3],
    /// Film thickness, nm.
    pub thickness_nm: f32,
}

impl SkinMaps {
    /// The maps of a set; what it lacks is `missing` everywhere. Albedo and roughness are cut to [0, 1], thickness to 0 and
    /// above, normals of DirectX turned to OpenGL's; what is not finite is `missing`'s.
    pub fn new(set: &TextureSet, missing: Texel) -> Self {
        let (width, height) = (set.domain.width, set.domain.height);
        let mut texels = vec![missing; width * height];
        let fill = |texels: &mut [Texel], kind: MapKind, put: &dyn Fn(&mut Texel, &[f32])| {
            let Some(map) = set.maps.get(&kind) else { return };
            let mut values = [0.0; 3];
            for (i, texel) in texels.iter_mut().enumerate() {
                for (value, plane) in values.iter_mut().zip(&map.planes) {
                    *value = plane.data()[i];
                }
                if values.iter().all(|v| v.is_finite()) {
                    put(texel, &values);
                }
            }
        };
        fill(&mut texels, MapKind::Color, &|t, v| t.color = [v[0], v[1], v[2]].map(num::saturate));
        fill(&mut texels, MapKind::Roughness, &|t, v| t.roughness = num::saturate(v[0]));
        fill(&mut texels, MapKind::Iridescence, &|t, v| t.thickness_nm = v[0].max(0.0));
        let normal = set.maps.get(&MapKind::Normal);
        let down = normal.is_some_and(|m| m.normal_format == Some(NormalFormat::Dx));
        let green = if down { -1.0 } else { 1.0 };
        fill(&mut texels, MapKind::Normal, &|t, v| t.normal = unit([v[0], green * v[1], v[2]]));
        let height_mm = set.maps.get(&MapKind::Height).map(|m| m.planes[0].data().to_vec());
        let size_mm = [set.domain.girth_mm, set.domain.length_mm];
        Self { width, height, texels, height_mm, size_mm }
    }

    /// The height map, if the set has it.
    pub fn height_plane(&self) -> Option<Plane> {
        self.height_mm.as_ref().map(|heights| Plane::from_vec(self.width, self.height, heights.clone()))
    }

    /// Whether any normal is not straight up.
    pub fn has_bumps(&self) -> bool {
        self.texels.iter().any(|t| t.normal[0] != 0.0 || t.normal[1] != 0.0)
    }

    /// The texel at texture coordinates in tiles, bilinear between texel centres, the tile repeated; its normal is unit.
    #[inline]
    pub fn sample(&self, u: f32, v: f32) -> Texel {
        let (at, weights) = self.corners(u, v);
        let mut out = Texel::default();
        for (i, w) in at.into_iter().zip(weights) {
            let t = &self.texels[i];
            for c in 0..3 {
                out.color[c] += w * t.color[c];
                out.normal[c] += w * t.normal[c];
            }
            out.roughness += w * t.roughness;
            out.thickness_nm += w * t.thickness_nm;
        }
        out.normal = unit(out.normal);
        out
    }

    /// Height of the surface at texture coordinates in tiles, mm; 0 where the set has none.
    #[inline]
    pub fn height_mm(&self, u: f32, v: f32) -> f32 {
        let Some(heights) = &self.height_mm else { return 0.0 };
        let (at, weights) = self.corners(u, v);
        at.into_iter().zip(weights).map(|(i, w)| w * heights[i]).sum()
    }

    /// The four texels around a place, and their weights.
    #[inline]
    fn corners(&self, u: f32, v: f32) -> ([usize; 4], [f32; 4]) {
        let axis = |t: f32, size: usize| {
            // Into the tile first, so that far tiles are as sharp as near ones; NaN and infinity read the first texel.
            let x = if t.is_finite() { num::fract(t) * size as f32 - 0.5 } else { 0.0 };
            let floor = x.floor();
            // From -1 to size - 1 (and, after rounding, size).
            let low = if floor < 0.0 { size - 1 } else { (floor as usize).min(size - 1) };
            let high = if low + 1 == size { 0 } else { low + 1 };
            (low, high, x - floor)
        };
        let ((x0, x1, s), (y0, y1, t)) = (axis(u, self.width), axis(v, self.height));
        let (top, bottom) = (y0 * self.width, y1 * self.width);
        (
            [top + x0, top + x1, bottom + x0, bottom + x1],
            [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t],
        )
    }
}

/// A unit vector; straight up where there is none.
#[inline]
fn unit([x, y, z]: [f32; 3]) -> [f32; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    if length > 1e-6 { [x / length, y / length, z / length] } else { [0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;
    use crate::maps::MapImage;
    use std::collections::BTreeMap;

    fn set(width: usize, height: usize, maps: Vec<MapImage>) -> TextureSet {
        TextureSet {
            domain: Domain { width, height, girth_mm: 60.0, length_mm: 90.0 },
            maps: maps.into_iter().map(|m| (m.kind, m)).collect::<BTreeMap<_, _>>(),
            preset: "test".into(),
            seed: 1,
            preset_hash: [0; 32],
            optics: Default::default(),
        }
    }

    const MISSING: Texel =
        Texel { color: [0.5, 0.4, 0.3], roughness: 0.25, normal: [0.0, 0.0, 1.0], thickness_nm: 300.0 };

    #[test]
    fn a_texel_is_32_bytes_and_what_is_missing_is_filled() {
        assert_eq!(size_of::<Texel>(), 32);
        let maps = SkinMaps::new(&set(4, 3, vec![]), MISSING);
        assert_eq!((maps.texels.len(), maps.height_mm.as_ref(), maps.size_mm), (12, None, [60.0, 90.0]));
        assert_eq!(maps.height_mm(0.3, 0.4), 0.0);
        let t = maps.sample(0.37, -2.4);
        assert!(
            (t.color[0] - 0.5).abs() < 1e-6 && (t.thickness_nm - 300.0).abs() < 1e-3 && t.normal[2] == 1.0
        );
        let material = Material {
            constants: Constants::default(),
            color: LinearRgb(MISSING.color),
            roughness: 0.25,
            thickness_nm: 300.0,
            maps: None,
        };
        assert_eq!(material.texel(0.1, 0.2), MISSING);
    }

    #[test]
    fn sampling_is_the_planes_own_and_wraps() {
        let plane = |k: f32| Plane::from_fn(5, 3, |x, y| 0.1 * k + 0.02 * (3 * x + 7 * y * y % 5) as f32);
        let height = Plane::from_fn(5, 3, |x, y| (x * y) as f32);
        let maps = SkinMaps::new(
            &set(
                5,
                3,
                vec![
                    MapImage::new(MapKind::Color, vec![plane(1.0), plane(2.0), plane(3.0)]),
                    MapImage::new(MapKind::Roughness, vec![plane(4.0)]),
                    MapImage::new(MapKind::Height, vec![height.clone()]),
                ],
            ),
            MISSING,
        );
        for i in 0..400 {
            let (u, v) = (0.013 * i as f32 - 2.0, 1.5 - 0.029 * i as f32);
            let t = maps.sample(u, v);
            let expected = |p: &Plane| p.rows().bilinear(u * 5.0, v * 3.0);
            assert!((t.color[1] - expected(&plane(2.0))).abs() < 1e-4, "{u} {v}");
            assert!((t.roughness - expected(&plane(4.0))).abs() < 1e-4, "{u} {v}");
            assert!((maps.height_mm(u, v) - expected(&height)).abs() < 1e-3, "{u} {v}");
            let tile = maps.sample(u + 3.0, v - 2.0);
            assert!((tile.color[0] - t.color[0]).abs() < 1e-4);
        }
        for odd in [f32::NAN, f32::INFINITY, -1e-20, 1e20, f32::MIN] {
            assert!(maps.sample(odd, -odd).color.iter().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn normals_are_unit_and_of_one_convention_and_bad_values_are_not_taken() {
        let part = |value: f32| Plane::filled(2, 2, value);
        let normal = MapImage::new(MapKind::Normal, vec![part(0.0), part(0.6), part(0.8)]);
        let gl = SkinMaps::new(&set(2, 2, vec![normal.clone()]), MISSING);
        assert_eq!(gl.texels[0].normal, [0.0, 0.6, 0.8]);
        let dx = SkinMaps::new(&set(2, 2, vec![normal.with_normal_format(NormalFormat::Dx)]), MISSING);
        assert_eq!(dx.texels[3].normal, [0.0, -0.6, 0.8]);
        // Opposite normals between texels: still a unit vector.
        let flip = Plane::from_fn(2, 2, |x, _| if x == 0 { 1.0 } else { -1.0 });
        let flip = MapImage::new(MapKind::Normal, vec![flip, part(0.0), part(0.0)]);
        let flip = SkinMaps::new(&set(2, 2, vec![flip]), MISSING);
        assert_eq!(flip.sample(0.5, 0.5).normal, [0.0, 0.0, 1.0]);
        let odd = Plane::from_fn(2, 2, |x, y| [f32::NAN, -5.0, 7.0, f32::INFINITY][x + 2 * y]);
        let odd = SkinMaps::new(&set(2, 2, vec![MapImage::new(MapKind::Roughness, vec![odd])]), MISSING);
        let roughness: Vec<f32> = odd.texels.iter().map(|t| t.roughness).collect();
        assert_eq!(roughness, [0.25, 0.0, 1.0, 0.25]);
    }
}
