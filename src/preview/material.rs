//! The numbers of one material that its shader reads: a uniform block, and tables.

use bytemuck::{Pod, Zeroable};

use super::lobe;
use super::program::SkinProgram;
use crate::optics::layered::{Albedo, Below, Constants};
use crate::optics::{FilmColor, FilmError, Layers, Method, Transform};

/// What is the same over a whole material: `Material` of `material.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialUniform {
    /// Refractive indices: outside, film, layer.
    pub indices: [f32; 3],
    /// `(n0/n2)^2`.
    pub eta: f32,
    /// Optical depth of the layer along the normal.
    pub absorption: [f32; 3],
    /// 1 where albedos are the base's own, 0 where they are apparent.
    pub intrinsic: f32,
    /// What becomes of light below the film; see [`Below`].
    pub clear: [f32; 3],
    /// Columns of the table of [`Below`] per nm of film.
    pub below_per_nm: f32,
    /// See [`Below`].
    pub lost: [f32; 3],
    /// To the next 16 bytes.
    pub padding: f32,
    /// See [`Below`].
    pub entering: [f32; 3],
    /// To the next 16 bytes.
    pub padding_2: f32,
}

/// A table that the shader reads texel by texel: a texture of `Rgba32Float`, which needs no sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The variable in WGSL.
    pub name: &'static str,
    /// Its binding in group 1.
    pub binding: u32,
    /// Columns.
    pub width: u32,
    /// Row by row.
    pub texels: Vec<[f32; 4]>,
}

impl Table {
    /// Rows.
    pub fn height(&self) -> u32 {
        (self.texels.len() / self.width.max(1) as usize) as u32
    }
}

/// Intervals of the table of fringes: to 20 um, where nothing is left to see.
pub const FRINGES: usize = 1024;
/// Path difference of one interval, nm.
pub const FRINGES_STEP_NM: f64 = 20.0;
/// Columns of the table of [`Below`]; the last is for films too thick to interfere.
pub const BELOW: usize = 1024;
/// Optical path, `2 n1 d`, where that table ends, nm: twenty fringes of [`Layers::below`]'s own.
const BELOW_END_NM: f64 = 8000.0;

/// All numbers of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinData {
    /// The uniform block, binding 0.
    pub uniform: MaterialUniform,
    /// The tables that the program reads.
    pub tables: Vec<Table>,
}

impl SkinData {
    /// For a material of these constants, with this film thickness where no map says otherwise, nm.
    ///
    /// # Errors
    /// If an index is out of range.
    pub fn new(constants: &Constants, thickness_nm: f32, program: &SkinProgram) -> Result<Self, FilmError> {
        let layers = Layers::<f32>::new(constants)?;
        let [n0, n1, n2] = constants.indices;
        let mut uniform = MaterialUniform {
            indices: constants.indices,
            eta: (n0 / n2) * (n0 / n2),
            absorption: constants.absorption.map(|t| t.max(0.0)),
            intrinsic: f32::from(u8::from(constants.albedo == Albedo::Intrinsic)),
            ..MaterialUniform::default()
        };
        let colors = FilmColor::<f32>::new(Method::Series(3));
        let below = |thickness_nm: f32| layers.below(&colors, thickness_nm, 0.0, constants.absorption);
        let mut tables = Vec::new();
        if program.has("fringes") || program.has("fringes_filtered") {
            tables.push(fringes(program.has("fringes_filtered")));
        }
        if program.has("below_constant") {
            Below { clear: uniform.clear, lost: uniform.lost, entering: uniform.entering } =
                below(thickness_nm);
        }
        if program.has("below_table") {
            let last = BELOW - 2;
            let end_nm = BELOW_END_NM / (2.0 * f64::from(n1));
            uniform.below_per_nm = (last as f64 / end_nm) as f32;
            // Just within, where films still interfere.
            let at =
                |i: usize| if i > last { f32::INFINITY } else { i as f32 / uniform.below_per_nm * 0.99999 };
            let columns: Vec<Below<f32, 3>> = (0..BELOW).map(|i| below(at(i))).collect();
            let row =
                |get: fn(&Below<f32, 3>) -> [f32; 3]| columns.iter().map(get).map(rgb).collect::<Vec<_>>();
            let texels = [row(|b| b.clear), row(|b| b.lost), row(|b| b.entering)].concat();
            tables.push(Table { name: "below_rows", binding: 2, width: BELOW as u32, texels });
        }
        if program.has("lobe") {
            let width = 2 * lobe::COSINES as u32;
            tables.push(Table { name: "lobe_table", binding: 3, width, texels: lobe::table() });
        }
        Ok(Self { uniform, tables })
    }
}

/// C as cubics, a row for each channel and a column for each interval, right to 1e-5; and below them, if wanted, its
/// integral up to each. See [`Transform`].
fn fringes(integral: bool) -> Table {
    let transform = Transform::double();
    // Through four even points of the interval, by Newton's forward differences.
    let cubic = |i: usize, c: usize| {
        let y: [f64; 4] =
            std::array::from_fn(|k| transform.at((i as f64 + k as f64 / 3.0) * FRINGES_STEP_NM)[c]);
        let (one, two) = (y[1] - y[0], y[2] - 2.0 * y[1] + y[0]);
        let three = y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0];
        let of_thirds = [y[0], one - two / 2.0 + three / 3.0, (two - three) / 2.0, three / 6.0];
        [0, 1, 2, 3].map(|k| (of_thirds[k] * 3f64.powi(k as i32)) as f32)
    };
    let row = |c: usize| (0..FRINGES).map(move |i| cubic(i, c)).chain([[0.0; 4]]);
    let mut texels: Vec<[f32; 4]> = (0..3).flat_map(row).collect();
    if integral {
        let at = |i: usize| transform.integral(i as f64 * FRINGES_STEP_NM).map(|s| s as f32);
        texels.extend((0..=FRINGES).map(|i| rgb(at(i))));
    }
    Table { name: "fringes_table", binding: 1, width: FRINGES as u32 + 1, texels }
}

fn rgb([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 0.0]
}
