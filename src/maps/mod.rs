//! TEXTURE SET: named maps in physical units, and how they become integers.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`MapImage`] | one map: planes, the physical range that integers cover, the normal's format |
//! | [`assemble()`] | a set from an evaluation |
//! | [`TextureSet`] | the maps of one preset and seed, all on one grid |
//! | [`EncodeOptions`], [`Quantiser`] | depth, dither; rows of samples and the error that they carry |
//! | [`RowTold`], [`MapTold`] | what encoding finds out in passing |
//! | [`plane_hash`] | BLAKE3 of a map before any encoding: the golden value |
//!
//! No files here: the room compiles on every target.

mod assemble;
mod encode;
mod hash;
mod samples;
mod srgb;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use assemble::assemble;
pub use encode::{Depth, EncodeOptions, MapTold, QuantError, Quantiser, RowTold, quantisation_error};
pub use hash::plane_hash;

use crate::base::{Domain, MapKind, Plane};
use crate::graph::{self, Graph};
use crate::optics::SkinOptics;

/// Which way the green channel of a normal map points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalFormat {
    /// OpenGL: green grows up the image (glTF, Blender, Godot, Unity).
    #[default]
    Gl,
    /// DirectX: green grows down the image (Unreal, most games on Windows).
    Dx,
}

impl NormalFormat {
    /// The suffix in file names.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Gl => "nor_gl",
            Self::Dx => "nor_dx",
        }
    }
}

/// One map of a set, in physical units (mm, nm, 1/mm; linear RGB; unit vectors; ids as whole numbers).
#[derive(Clone, Debug, PartialEq)]
pub struct MapImage {
    /// What it is.
    pub kind: MapKind,
    /// `kind.channels()` planes of equal size.
    pub planes: Vec<Plane>,
    /// The values that integer encodings map to 0 and 1, in the map's unit: `[0, 1]` for colour and pure numbers,
    /// `[-1, 1]` for normals; values outside are clamped. An empty or infinite range encodes as 0 everywhere.
    /// Ids are written as they are and do not use it.
    pub range: [f32; 2],
    /// Which way green points; `None` for anything but a normal.
    pub normal_format: Option<NormalFormat>,
}

impl MapImage {
    /// A map over `planes`, with the range of its kind: `[-1, 1]` for normals, `[0, 1]` for colour and pure
    /// numbers, and for mm, nm and 1/mm the least and greatest finite value (symmetric about 0 for curvature).
    ///
    /// # Panics
    /// If the number of planes or their sizes do not fit: a broken invariant of the caller.
    pub fn new(kind: MapKind, planes: Vec<Plane>) -> Self {
        assert_planes(kind, &planes);
        let extremes = || crate::base::num::min_max(planes[0].data());
        let range = match kind {
            MapKind::Normal => [-1.0, 1.0],
            MapKind::Curvature => {
                let (lo, hi) = extremes();
                [-lo.abs().max(hi.abs()), lo.abs().max(hi.abs())]
            }
            MapKind::Height | MapKind::Iridescence => extremes().into(),
            MapKind::ScaleId => [0.0, extremes().1],
            _ => [0.0, 1.0],
        };
        Self::in_range(kind, planes, range)
    }

    /// A map over `planes`, in physical units, of which integers cover `range`.
    ///
    /// # Panics
    /// As [`MapImage::new`].
    pub fn in_range(kind: MapKind, planes: Vec<Plane>, range: [f32; 2]) -> Self {
        assert_planes(kind, &planes);
        let normal_format = (kind == MapKind::Normal).then_some(NormalFormat::Gl);
        Self { kind, planes, range, normal_format }
    }

    /// The same map with another physical range.
    pub fn with_range(mut self, range: [f32; 2]) -> Self {
        self.range = range;
        self
    }

    /// The same map labelled with a normal format (the planes are taken as they are); ignored for other kinds.
    pub fn with_normal_format(mut self, format: NormalFormat) -> Self {
        self.normal_format = (self.kind == MapKind::Normal).then_some(format);
        self
    }

    /// Width in texels.
    pub fn width(&self) -> usize {
        self.planes[0].width()
    }

    /// Height in texels.
    pub fn height(&self) -> usize {
        self.planes[0].height()
    }
}

/// That the planes are those of one map of this kind.
fn assert_planes(kind: MapKind, planes: &[Plane]) {
    assert_eq!(planes.len(), kind.channels(), "{kind} has the wrong number of planes");
    let size = (planes[0].width(), planes[0].height());
    assert!(
        planes.iter().all(|p| (p.width(), p.height()) == size) && size.0 > 0 && size.1 > 0,
        "{kind} has planes of unequal or empty size"
    );
}

/// Which set a map belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct SetId {
    /// The grid and its physical size.
    pub domain: Domain,
    /// Name of the preset.
    pub preset: String,
    /// The seed: the individual.
    pub seed: u64,
    /// BLAKE3 of the preset as evaluated.
    pub preset_hash: [u8; 32],
    /// What the skin is made of besides its maps.
    pub optics: SkinOptics,
}

impl SetId {
    /// The set that a graph makes on a grid.
    pub fn new(graph: &Graph, domain: Domain) -> Self {
        Self {
            domain,
            preset: graph.name.clone(),
            seed: graph.seed,
            preset_hash: graph::preset_hash(graph),
            optics: graph.optics,
        }
    }
}

/// The maps of one preset and seed, all on one grid, registered to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSet {
    /// The grid and its physical size.
    pub domain: Domain,
    /// The maps, in the order of [`MapKind::ALL`].
    pub maps: BTreeMap<MapKind, MapImage>,
    /// Name of the preset.
    pub preset: String,
    /// The seed: the individual.
    pub seed: u64,
    /// BLAKE3 of the preset as evaluated.
    pub preset_hash: [u8; 32],
    /// What the skin is made of besides its maps.
    pub optics: SkinOptics,
}

impl TextureSet {
    /// The set without its maps.
    pub fn id(&self) -> SetId {
        SetId {
            domain: self.domain,
            preset: self.preset.clone(),
            seed: self.seed,
            preset_hash: self.preset_hash,
            optics: self.optics,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_map_has_the_range_of_its_kind() {
        let ramp = |lo: f32, hi: f32| Plane::from_fn(2, 1, |x, _| if x == 0 { lo } else { hi });
        let range = |kind, lo, hi| MapImage::new(kind, vec![ramp(lo, hi)]).range;
        assert_eq!(range(MapKind::Height, 0.25, 0.75), [0.25, 0.75]);
        assert_eq!(range(MapKind::Curvature, -3.0, 2.0), [-3.0, 3.0]);
        assert_eq!(range(MapKind::Roughness, 0.25, 0.75), [0.0, 1.0]);
        let normal = MapImage::new(MapKind::Normal, vec![ramp(0.0, 1.0); 3]);
        assert_eq!((normal.range, normal.normal_format), ([-1.0, 1.0], Some(NormalFormat::Gl)));
    }
}
