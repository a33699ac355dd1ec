//! From evaluated planes to a texture set.

use super::{MapImage, NormalFormat, SetId, TextureSet};
use crate::base::MapKind;
use crate::eval::{Evaluation, MapPlanes};

/// The set of an evaluation's maps, each with the range that its preset gives. Normals are OpenGL's.
pub fn assemble(evaluation: Evaluation, set: SetId) -> TextureSet {
    let map = |(kind, planes)| (kind, MapImage::of(kind, planes));
    TextureSet {
        domain: set.domain,
        maps: evaluation.maps.into_iter().map(map).collect(),
        preset: set.preset,
        seed: set.seed,
        preset_hash: set.preset_hash,
        optics: set.optics,
    }
}

impl MapImage {
    /// A map as it was evaluated, with the range that its preset gives. Normals are OpenGL's.
    ///
    /// # Panics
    /// If there are not `kind.channels()` planes: a broken invariant of the caller.
    pub fn of(kind: MapKind, planes: MapPlanes) -> Self {
        Self::in_range(kind, planes.planes, planes.range)
    }

    /// The same normals with green pointing as `format` says; any other map as it is.
    pub fn to_normal_format(mut self, format: NormalFormat) -> Self {
        if self.normal_format.is_some_and(|own| own != format) {
            for green in self.planes.iter_mut().skip(1).take(1).flat_map(|p| p.data_mut()) {
                *green = -*green;
            }
            self.normal_format = Some(format);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Plane;

    #[test]
    fn the_other_format_has_green_turned_and_comes_back() {
        let planes = [0.6, -0.8, 0.25].map(|v| Plane::filled(2, 1, v)).to_vec();
        let gl = MapImage::new(MapKind::Normal, planes);
        let dx = gl.clone().to_normal_format(NormalFormat::Dx);
        assert_eq!((dx.planes[0].at(0, 0), dx.planes[1].at(1, 0), dx.planes[2].at(0, 0)), (0.6, 0.8, 0.25));
        assert_eq!(dx.normal_format, Some(NormalFormat::Dx));
        assert_eq!(dx.to_normal_format(NormalFormat::Gl), gl);
        let height = MapImage::new(MapKind::Height, vec![Plane::filled(2, 1, 0.5)]);
        assert_eq!(height.clone().to_normal_format(NormalFormat::Dx), height);
    }
}
