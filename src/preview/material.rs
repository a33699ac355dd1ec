//! The numbers of one material that its shader reads: a uniform block, and tables.

use bytemuck::{Pod, Zeroable};

use super::lobe;
use super::orders;
use super::program::SkinProgram;
use crate::optics::film_color::{BEST_NM, UNIFORM_NM};
use crate::optics::layered::{Albedo, Below, Constants};
use crate::optics::{Bands, Film, FilmColor, FilmError, Layers, Method, Transform, absorption, cie};

/// What is the same over a whole material: `Material` of `material.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialUniform {
    /// Refractive indices: outside, film, layer.
    pub indices: [f32; 3],
    /// Columns of the table of [`Below`] per nm of film.
    pub below_per_nm: f32,
    /// Optical depth of the layer along the normal.
    pub absorption: [f32; 3],
    /// 1 where albedos are the base's own, 0 where they are apparent.
    pub intrinsic: f32,
    /// What becomes of light below the film; see [`Below`].
    pub clear: [f32; 3],
    /// Cauchy coefficient of the film, nm^2: see [`Film::dispersed`].
    pub film_dispersion: f32,
    /// See [`Below`].
    pub lost: [f32; 3],
    /// Cauchy coefficient of the layer, nm^2.
    pub layer_dispersion: f32,
    /// See [`Below`].
    pub entering: [f32; 3],
    /// To the next 16 bytes.
    pub padding: f32,
    /// `(n0/n2)^2` in red, green and blue.
    pub eta: [f32; 3],
    /// To the next 16 bytes.
    pub padding_2: f32,
    /// Index of the layer in red, green and blue.
    pub layer: [f32; 3],
    /// To the next 16 bytes.
    pub padding_3: f32,
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
/// Roughnesses of that table, where they matter.
const BELOW_ROUGH: usize = 33;
/// Wavelengths where the film reflects totally.
const BEYOND: usize = 16;
/// Wavelengths of a dispersive film: those of [`Bands::each`].
const DISPERSED: usize = 32;
/// Entries of a wrapped base's curve over cosines: odd, as curves have a kink at 0.
const CURVE: usize = 2047;
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
    /// For a material of these constants, with this film thickness, nm, where it is the same everywhere: that of
    /// [`Material::texel`](crate::scene::Material::texel) at any place, as a map may hold it.
    ///
    /// # Errors
    /// If an index is out of range.
    pub fn new(constants: &Constants, thickness_nm: f32, program: &SkinProgram) -> Result<Self, FilmError> {
        let layers = Layers::<f32>::new(constants)?;
        let [n0, n1, n2] = constants.indices;
        let film = Film::new(n0, n1, n2, 0.0)?;
        let layer = BEST_NM.map(|l| film.dispersed(constants.dispersion_nm2, l as f32).indices()[2]);
        let mut uniform = MaterialUniform {
            indices: constants.indices,
            film_dispersion: constants.dispersion_nm2[0],
            layer_dispersion: constants.dispersion_nm2[1],
            eta: layer.map(|n2| (n0 / n2) * (n0 / n2)),
            layer,
            absorption: constants.absorption.map(|t| t.max(0.0)),
            intrinsic: f32::from(u8::from(constants.albedo == Albedo::Intrinsic)),
            ..MaterialUniform::default()
        };
        let colors = FilmColor::<f32>::new(Method::Series(3));
        let absorption = uniform.absorption;
        let below = |thickness_nm: f32, roughness: f32| {
            let below = layers.below(&colors, thickness_nm, roughness, absorption);
            match constants.base.wraps() {
                true => Below {
                    entering: wrapped(constants, &colors, &film.with_thickness(thickness_nm), layer),
                    ..below
                },
                false => below,
            }
        };
        let mut tables = Vec::new();
        if program.has("fringes") || program.has("fringes_filtered") {
            tables.push(fringes(program.has("fringes_filtered")));
        }
        if program.has("below_constant") {
            let Below { clear, lost, entering } = below(thickness_nm, 0.0);
            (uniform.clear, uniform.lost, uniform.entering) = (clear, lost, entering);
        }
        if program.has("below_table") || program.has("below_rough") {
            let last = BELOW - 2;
            let per_nm = (last as f64 * 2.0 * f64::from(n1) / BELOW_END_NM) as f32;
            // Just within, where films still interfere.
            let thickness = |i: usize| if i > last { f32::INFINITY } else { i as f32 / per_nm * 0.99999 };
            let rows = |roughness: f32| {
                let columns: Vec<_> = (0..BELOW).map(|i| below(thickness(i), roughness)).collect();
                let row = |get: fn(&Below<f32, 3>) -> [f32; 3]| {
                    columns.iter().map(get).map(rgb).collect::<Vec<_>>()
                };
                [row(|b| b.clear), row(|b| b.lost), row(|b| b.entering)].concat()
            };
            let texels = match program.has("below_rough") {
                true => (0..BELOW_ROUGH).flat_map(|r| rows(r as f32 / (BELOW_ROUGH - 1) as f32)).collect(),
                false => rows(0.0),
            };
            tables.push(Table { name: "below_rows", binding: 2, width: BELOW as u32, texels });
            uniform.below_per_nm = per_nm;
        }
        if program.has("lobe") {
            let width = 2 * lobe::COSINES as u32;
            tables.push(Table { name: "lobe_table", binding: 3, width, texels: lobe::table() });
        }
        if program.has("beyond_frustrated") || program.has("film_dispersed") {
            let node = |n: &cie::Node| {
                let [r, g, b] = n.rgb;
                [n.wavelength_nm, r, g, b].map(|x| x as f32)
            };
            let count = if program.has("film_dispersed") { DISPERSED } else { BEYOND };
            let texels: Vec<_> = cie::uniform_nodes(count, UNIFORM_NM).iter().map(node).collect();
            tables.push(Table { name: "wavelengths", binding: 4, width: count as u32, texels });
        }
        if program.has("curve") {
            let cosine = |i: usize| i as f32 / (CURVE - 1) as f32 * 2.0 - 1.0;
            let sides = if program.has("base_translucent") { 2 } else { 1 };
            let row = |side: usize| (0..CURVE).map(move |i| rgb(constants.base.sides(cosine(i))[side]));
            let texels = (0..sides).flat_map(row).collect();
            tables.push(Table { name: "curve", binding: 5, width: CURVE as u32, texels });
        }
        if let (Some(count), Some(grating)) = (program.grating_wavelengths(), &constants.grating) {
            tables.extend(orders::tables(grating, count)?);
        }
        Ok(Self { uniform, tables })
    }
}

/// [`Below::entering`] of a base that light reaches around: `2 int_-1^1 w(c) T((1 + c)/2) exp(-tau/c2) dc`, the film taken
/// as smooth; and the same of what comes through, where c is -c.
fn wrapped(constants: &Constants, colors: &FilmColor<f32>, film: &Film<f32>, layer: [f32; 3]) -> [f32; 3] {
    const COUNT: u16 = 64;
    let n0 = film.indices()[0];
    let mut sum = [0.0; 3];
    for i in 0..COUNT {
        let half_way = (f32::from(i) + 0.5) / f32::from(COUNT);
        let cosine = 2.0 * half_way - 1.0;
        let ([near, _], [_, far]) = (constants.base.sides(cosine), constants.base.sides(-cosine));
        let reflected = reflected(constants, colors, film, half_way);
        for c in 0..3 {
            let inside = absorption::cosine_in_layer(n0, layer[c], half_way);
            let survives = absorption::one_way(constants.absorption[c], inside);
            sum[c] += 4.0 / f32::from(COUNT) * (near[c] + far[c]) * (1.0 - reflected[c]) * survives;
        }
    }
    sum
}

/// The colour that a film reflects, dispersive or not, limited to [0, 1].
pub(super) fn reflected(
    constants: &Constants,
    colors: &FilmColor<f32>,
    film: &Film<f32>,
    cosine: f32,
) -> [f32; 3] {
    let b = constants.dispersion_nm2;
    let rgb = match b == [0.0; 2] {
        true => colors.color(film, cosine),
        false => colors.each(|l| film.dispersed(b, l).power(cosine, l).reflected),
    };
    rgb.map(|c| c.max(0.0).min(1.0))
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
