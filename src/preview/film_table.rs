//! What a film reflects, as a table: a pixel asks for it some twenty times, and on a software adapter each read of the
//! series' own table costs as much as a hundred operations.

use half::f16;
use rayon::prelude::*;

use super::material::reflected;
use crate::base::num;
use crate::optics::layered::Constants;
use crate::optics::{Film, FilmColor, FilmError, Method};

/// Columns: even steps of the root of the cosine, which tell more of grazing angles.
pub(super) const COSINES: usize = 64;
/// Rows: even steps of thickness, from 0 to the thickest.
pub(super) const THICKNESSES: usize = 512;
/// Layers: the film itself, then its mean over a width of 16 nm, and twice as much for each next but one: near enough that one
/// read will do, of the nearest.
pub(super) const LAYERS: usize = 12;
/// The width of the second layer, nm.
const WIDTH_NM: f32 = 16.0;
/// A table of thicker films would miss fringes between its rows.
pub(super) const THICKEST_NM: f32 = 4000.0;

/// The texels, four halves each, for films of a material up to a thickness.
///
/// # Errors
/// If an index is out of range.
pub(super) fn table(constants: &Constants, thickest_nm: f32) -> Result<Vec<f16>, FilmError> {
    let colors = FilmColor::<f32>::new(Method::Series(3));
    let [n0, n1, n2] = constants.indices;
    let film = Film::new(n0, n1, n2, 0.0)?;
    let step = thickest_nm / (THICKNESSES - 1) as f32;
    let row = |j: usize| {
        let film = film.with_thickness(j as f32 * step);
        std::array::from_fn::<[f32; 3], COSINES, _>(|i| {
            let root = i as f32 / (COSINES - 1) as f32;
            reflected(constants, &colors, &film, root * root)
        })
    };
    let rows: Vec<_> = (0..THICKNESSES).into_par_iter().map(row).collect();
    let mut texels = vec![f16::ONE; 4 * COSINES * THICKNESSES * LAYERS];
    texels.par_chunks_mut(4 * COSINES).enumerate().for_each(|(row, texels)| {
        let (layer, j) = (row / THICKNESSES, row % THICKNESSES);
        let width = if layer == 0 { 0.0 } else { WIDTH_NM * num::exp2(0.5 * (layer - 1) as f32) };
        let half = 0.5 * width / step.max(1e-6);
        // Rows that a box of this width covers, those at its ends in part.
        let weight = |k: usize| (half + 0.5 - (k as f32 - j as f32).abs()).max(0.0).min(1.0);
        let reach = (half + 0.5) as usize + 1;
        let covered = j.saturating_sub(reach)..(j + reach + 1).min(THICKNESSES);
        let total: f32 = covered.clone().map(weight).sum();
        for (i, texel) in texels.chunks_exact_mut(4).enumerate() {
            let mean = |c: usize| covered.clone().map(|k| weight(k) * rows[k][i][c]).sum::<f32>() / total;
            (0..3).for_each(|c| texel[c] = f16::from_f32(mean(c)));
        }
    });
    Ok(texels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texel(table: &[f16], layer: usize, row: usize, column: usize) -> [f32; 3] {
        let at = 4 * ((layer * THICKNESSES + row) * COSINES + column);
        std::array::from_fn(|c| table[at + c].to_f32())
    }

    /// Between texels the table is the film to a three-hundredth; 5 % thicker it is another.
    #[test]
    fn the_table_is_the_film() {
        let table = table(&Constants::default(), 600.0).expect("indices in range");
        let colors = FilmColor::<f32>::new(Method::Series(3));
        let film = Film::new(1.0_f32, 1.55, 2.0, 0.0).expect("indices in range");
        let (mut most, mut wrong) = (0.0_f32, 0.0_f32);
        for (row, column) in [(80, 20), (255, 40), (341, 62), (400, 10), (500, 50)] {
            let thickness = (row as f32 + 0.5) * 600.0 / (THICKNESSES - 1) as f32;
            let root = (column as f32 + 0.5) / (COSINES - 1) as f32;
            let right = colors.color(&film.with_thickness(thickness), root * root);
            let thicker = colors.color(&film.with_thickness(1.05 * thickness), root * root);
            for c in 0..3 {
                let near = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let mean =
                    near.map(|(r, k)| texel(&table, 0, row + r, column + k)[c]).iter().sum::<f32>() / 4.0;
                most = most.max((mean - right[c]).abs());
                wrong = wrong.max((mean - thicker[c]).abs());
            }
        }
        assert!(most < 3e-3, "{most}");
        assert!(wrong > 3e-2, "{wrong}");
    }

    /// Over a width of many fringes colours go.
    #[test]
    fn wide_layers_are_grey() {
        let table = table(&Constants::default(), 1500.0).expect("indices in range");
        let spread = |layer: usize| {
            let [r, g, b] = texel(&table, layer, 300, COSINES - 1);
            r.max(g).max(b) - r.min(g).min(b)
        };
        assert!(spread(LAYERS - 1) < 0.25 * spread(0), "{} {}", spread(LAYERS - 1), spread(0));
    }
}
