//! Gratings in the preview, by so many wavelengths.

use super::{Apart, Case, Cell, DIRECT, ERRORS, Problem, Sizes, Table, draw, inner, time, trace};
use crate::optics::Grating;
use crate::preview::{Gpu, Options, SkinOptions};
use crate::reference;

/// Periods and heights, nm: rainbows, and ridges too fine for any but slanted light (Gans & Baic 1977).
const GRATINGS: [(f32, f32); 2] = [(1000.0, 80.0), (250.0, 100.0)];

/// An even skin with ridges against direct light, also drawn without them.
pub(super) fn table(gpu: &Gpu, plain: &Case, options: &Options, sizes: &Sizes) -> Result<Table, Problem> {
    let columns: Vec<&str> =
        ["period, nm", "height, nm", "wavelengths"].iter().chain(&ERRORS[3..]).copied().collect();
    let inner = inner(plain, sizes)?;
    let mut table = Table::new("gratings", "Gratings against direct light", &columns);
    for (period_nm, height_nm) in GRATINGS {
        let ridges = Grating { period_nm, height_nm, direction_rad: 0.0 };
        let with = |grating: Option<Grating>| {
            let mut case = plain.clone();
            case.scene.materials.iter_mut().for_each(|m| m.constants.grating = grating);
            case
        };
        let case = with(Some(ridges));
        let truth = trace(&reference::Renderer::new(&case.scene)?, &case, sizes, DIRECT);
        for wavelengths in [0, 8, 16, 32] {
            let case = if wavelengths == 0 { &with(None) } else { &case };
            let skin = SkinOptions { grating_wavelengths: wavelengths, ..options.skin };
            let options = Options { skin, ..*options };
            let apart =
                Apart::new(&draw(gpu, case, &options, sizes.compared)?, &truth, &inner, sizes.compared[0])?;
            let ms = time(gpu, case, &options, sizes.shortcuts)?;
            let [period, height] = [period_nm, height_nm].map(|nm| Cell::Fixed(f64::from(nm), 0));
            let row = [period, height, Cell::Count(wavelengths.into()), Cell::Fixed(ms, 1)];
            table.row(row.into_iter().chain(apart.cells()));
        }
    }
    Ok(table)
}
