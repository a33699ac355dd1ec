//! What each shortcut of the preview saves and costs.

use std::time::Instant;

use super::{Apart, Case, Cell, ERRORS, Problem, Sizes, Table, Watch, draw, linear, shown, time};
use crate::preview::{Gpu, Options, SkinOptions};
use crate::scene::bloom::bloom;

/// Share of the light that a lens spreads, beside none.
const BLOOM: f32 = 0.05;

/// The case by each of them against `truth` and its inner pixels.
pub(super) fn table(
    gpu: &Gpu,
    case: &Case,
    (truth, inner): (&[[f32; 3]], &[bool]),
    options: &Options,
    sizes: &Sizes,
    watch: Watch<'_>,
) -> Result<Table, Problem> {
    let all = *options;
    let skin = all.skin;
    let rows = [
        ("as set for this adapter", all),
        ("1 sample", Options { samples: 1, ..all }),
        ("4 samples", Options { samples: 4, ..all }),
        ("16 samples", Options { samples: 16, ..all }),
        ("64 samples", Options { samples: 64, ..all }),
        ("1 small light a rectangle", Options { rectangle_samples: 1, ..all }),
        ("4 small lights a rectangle", Options { rectangle_samples: 4, ..all }),
        ("64 small lights a rectangle", Options { rectangle_samples: 64, ..all }),
        ("shadow maps of half the sides", {
            let [sun, rectangle] = [all.shadow_size / 2, all.rectangle_shadow_size / 2];
            Options { shadow_size: sun, rectangle_shadow_size: rectangle, ..all }
        }),
        ("shadow maps of twice the sides", {
            let [sun, rectangle] = [all.shadow_size * 2, all.rectangle_shadow_size * 2];
            Options { shadow_size: sun, rectangle_shadow_size: rectangle, ..all }
        }),
        ("shadows of rectangles for each pixel", Options { shared_shadows: false, ..all }),
        ("triangles shaded one by one", Options { deferred: false, ..all }),
        ("maps of halves, filtered throughout", Options { compact_maps: false, ..all }),
        ("maps of bytes", Options { compact_maps: true, ..all }),
        ("film as if even in a pixel", Options { skin: SkinOptions { footprint: false, ..skin }, ..all }),
        ("maps without anisotropy", Options { anisotropy: 1, ..all }),
        ("maps at the level of a whole pixel", Options { map_bias: 0.0, ..all }),
        ("maps a level sharper", Options { map_bias: all.map_bias - 1.0, ..all }),
        ("maps without levels", Options { map_bias: -16.0, ..all }),
        ("environment in 16 directions of the lobe", Options { sky_directions: Some(16), ..all }),
        ("environment in 256 directions of the lobe", Options { sky_directions: Some(256), ..all }),
        ("without environment", Options { environment: false, ..all }),
        ("without suns and rectangles", Options { lamps: false, ..all }),
    ];
    let columns: Vec<&str> = ["changed"].iter().chain(&ERRORS[3..]).copied().collect();
    let mut plain_ms = None;
    let mut table = Table::new("shortcuts", "Shortcuts, each changed alone", &columns);
    for (i, (name, options)) in rows.iter().enumerate() {
        watch(0.65 + 0.15 * i as f32 / rows.len() as f32, name);
        let apart = Apart::new(&draw(gpu, case, options, sizes.compared)?, truth, inner, sizes.compared[0])?;
        let ms = time(gpu, case, options, sizes.shortcuts)?;
        plain_ms.get_or_insert(ms);
        table.row([Cell::text(name), Cell::Fixed(ms, 1)].into_iter().chain(apart.cells()));
    }
    // The truth has no lens.
    let [mut drawn, mut large] =
        [linear(gpu, case, options, sizes.compared)?, linear(gpu, case, options, sizes.shortcuts)?];
    bloom(&mut drawn, sizes.compared[0], BLOOM);
    let start = Instant::now();
    bloom(&mut large, sizes.shortcuts[0], BLOOM);
    let ms = plain_ms.unwrap_or(0.0) + 1e3 * start.elapsed().as_secs_f64();
    let apart = Apart::new(&shown(case, &drawn), truth, inner, sizes.compared[0])?;
    let row = [Cell::text(format!("bloom of {BLOOM}")), Cell::Fixed(ms, 1)];
    table.row(row.into_iter().chain(apart.cells()));
    Ok(table)
}
