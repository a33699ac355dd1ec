//! What gloss shows of the environment: by a split sum, and in directions of its lobe.

use super::{
    Apart, Case, Cell, DIRECT, ERRORS, Problem, Sizes, THICKNESSES_NM, Table, draw, inner, time, trace,
};
use crate::preview::{Gpu, Options};
use crate::reference;

/// Samples of each pixel: with one, other errors hide this one.
pub(super) const SAMPLES: u32 = 16;
/// Times the samples of other truths, whose noise would hide it, too.
pub(super) const TRUTH: u32 = 16;
/// Directions in each; 0 is the split sum.
const DIRECTIONS: [u32; 5] = [0, 1, 4, 16, 64];

/// The case's scene by its environment alone, the skin even and with the film of `plain`, against direct light.
pub(super) fn table(
    gpu: &Gpu,
    (case, plain): (&Case, &Case),
    options: &Options,
    sizes: &Sizes,
) -> Result<Table, Problem> {
    let mut case = case.clone();
    let constants = plain.scene.materials.first().map(|material| material.constants).unwrap_or_default();
    case.scene.lights.clear();
    for material in &mut case.scene.materials {
        if material.maps.take().is_some() {
            (material.constants, material.thickness_nm) = (constants, THICKNESSES_NM[1]);
        }
    }
    let columns: Vec<&str> = ["directions"].iter().chain(&ERRORS[3..]).copied().collect();
    let mut table = Table::new("environment", "The environment in gloss", &columns);
    let inner = inner(&case, sizes)?;
    let more = Sizes { samples: sizes.samples.map(|samples| TRUTH * samples), ..*sizes };
    let truth = trace(&reference::Renderer::new(&case.scene)?, &case, &more, DIRECT);
    for directions in DIRECTIONS {
        let options = Options { samples: SAMPLES, sky_directions: Some(directions), ..*options };
        let drawn = draw(gpu, &case, &options, sizes.compared)?;
        let apart = Apart::new(&drawn, &truth, &inner, sizes.compared[0])?;
        let ms = time(gpu, &case, &options, sizes.shortcuts)?;
        let row = [Cell::Count(directions.into()), Cell::Fixed(ms, 1)];
        table.row(row.into_iter().chain(apart.cells()));
    }
    Ok(table)
}
