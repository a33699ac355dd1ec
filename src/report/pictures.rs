//! Whole pictures: what red, green and blue in place of wavelengths, a flat share of energy, and direct light alone cost.

use std::sync::Arc;
use std::time::Instant;

use super::metric::{ColorErrors, PIXELS_PER_DEGREE, flip};
use super::table::{Cell, Table};
use crate::optics::layered::Energy;
use crate::reference::{Control, Renderer, Settings, Transport};
use crate::scene::{Inputs, Scene, SkinMaps, Texel, builtin};

/// How large, and how many samples.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Pixels of a side.
    pub side: usize,
    /// Samples per pixel.
    pub samples: u32,
}

/// Differences of two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Root of the mean square over pixels and channels, linear.
    pub rmse: f64,
    /// Mean FLIP, in [0, 1].
    pub flip: f64,
    /// Mean CIEDE2000.
    pub delta_e: f64,
    /// Its 99th percentile.
    pub delta_e_99: f64,
}

/// A picture against a true one.
#[derive(Clone, Debug)]
pub struct Row {
    /// What was left out.
    pub name: &'static str,
    /// What it is compared with.
    pub truth: &'static str,
    /// How long it took.
    pub seconds: f64,
    /// How far it is off.
    pub apart: Apart,
}

/// One way to render.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    transport: Transport,
    energy: Energy,
}

/// A truth against itself.
const NOISE: &str = "the same, other random numbers";
const DIRECT: Way = spectral("wavelengths, direct light", 1);
const ALL: Way = spectral("wavelengths, all light", 16);

const fn spectral(name: &'static str, bounces: u32) -> Way {
    // All transport in wavelengths is coupled, whatever the material says.
    Way { name, transport: Transport::Full { bounces }, energy: Energy::Coupled }
}

const fn rgb(name: &'static str, energy: Energy) -> Way {
    Way { name, transport: Transport::Direct { environment_shadows: true }, energy }
}

/// Render the built-in scene `sphere` in every way, and compare it with direct light, and with all light, in wavelengths.
///
/// All pictures have the same random numbers, so that their noise is alike. Each truth is compared with itself of other
/// ones, too: differences that are much less are none.
///
/// # Errors
/// None that a caller can cause: the scene is built in.
pub fn rows(size: Size) -> Result<Vec<Row>, String> {
    const RGB: [Way; 2] =
        [rgb("RGB, coupled, direct light", Energy::Coupled), rgb("RGB, flat, direct light", Energy::Flat)];
    let shortcuts = RGB.map(|way| Ok((way.name, render(way, size, 1)?)));
    let shortcuts = shortcuts.into_iter().collect::<Result<Vec<_>, String>>()?;
    let (direct, all) = (render(DIRECT, size, 1)?, render(ALL, size, 1)?);
    let mut rows = Vec::new();
    for (truth, exact) in [(DIRECT, &direct), (ALL, &all)] {
        let again = render(truth, size, 2)?;
        let of = |name, picture: &Picture| -> Result<Row, String> {
            let apart = compare(&picture.rgb, &exact.rgb, size.side)?;
            Ok(Row { name, truth: truth.name, seconds: picture.seconds, apart })
        };
        rows.push(of(NOISE, &again)?);
        if truth.name == ALL.name {
            rows.push(of(DIRECT.name, &direct)?);
        }
        for (name, picture) in &shortcuts {
            rows.push(of(name, picture)?);
        }
    }
    Ok(rows)
}

/// The rows as a table.
pub fn table(rows: &[Row], size: Size) -> Table {
    let Size { side, samples } = size;
    let title = format!("The scene `sphere`, {side} x {side} pixels, {samples} samples per pixel");
    let columns = ["picture", "truth", "seconds", "RMSE", "FLIP", "dE mean", "dE 99%"];
    let mut table = Table::new("pictures", title, &columns);
    for Row { name, truth, seconds, apart } in rows {
        table.row([
            Cell::text(name),
            Cell::text(truth),
            Cell::Fixed(*seconds, 2),
            Cell::Scientific(apart.rmse, 2),
            Cell::Fixed(apart.flip, 4),
            Cell::Fixed(apart.delta_e, 3),
            Cell::Fixed(apart.delta_e_99, 2),
        ]);
    }
    table
}

/// Linear colours, and how long they took.
#[derive(Clone, Debug)]
struct Picture {
    rgb: Vec<[f32; 3]>,
    seconds: f64,
}

fn render(way: Way, size: Size, seed: u32) -> Result<Picture, String> {
    let scene = scene(way.energy)?;
    let renderer = Renderer::new(&scene).map_err(|e| e.to_string())?;
    let settings = Settings {
        width: size.side,
        height: size.side,
        samples: size.samples,
        seed,
        transport: way.transport,
        ..Settings::default()
    };
    let start = Instant::now();
    let film = renderer.render(&settings, Control::default());
    Ok(Picture { rgb: film.rgb(), seconds: start.elapsed().as_secs_f64() })
}

/// The scene `sphere`, its skin ringed red, cream and black below a film that grows from 100 to 1000 nm and back around it.
fn scene(energy: Energy) -> Result<Scene, String> {
    const WIDTH: usize = 64;
    const RINGS: [[f32; 3]; 3] = [[0.45, 0.06, 0.03], [0.7, 0.6, 0.4], [0.02; 3]];
    let mut spec = builtin::scene("sphere").map_err(|e| e.to_string())?;
    spec.subject.triangles = 20_000;
    spec.material.energy = energy;
    let texel = |i: usize| {
        let u = (i % WIDTH) as f32 / WIDTH as f32;
        Texel {
            color: RINGS[i / WIDTH % RINGS.len()],
            thickness_nm: 100.0 + 900.0 * (2.0 * u - 1.0).abs(),
            ..spec.material.texel()
        }
    };
    let height = 4 * RINGS.len();
    let maps = SkinMaps {
        width: WIDTH,
        height,
        texels: (0..WIDTH * height).map(texel).collect(),
        height_mm: None,
        size_mm: [60.0, 30.0],
    };
    let inputs = Inputs { maps: Some(Arc::new(maps)), ..Inputs::default() };
    Scene::build(&spec, &inputs).map_err(|e| e.to_string())
}

fn compare(picture: &[[f32; 3]], truth: &[[f32; 3]], width: usize) -> Result<Apart, String> {
    let mut errors = ColorErrors::default();
    for (a, b) in picture.iter().zip(truth) {
        errors.add(a.map(f64::from), b.map(f64::from));
    }
    let seen = flip(truth, picture, width, PIXELS_PER_DEGREE).map_err(|e| e.to_string())?;
    Ok(Apart {
        rmse: errors.rmse(),
        flip: seen.iter().map(|v| f64::from(*v)).sum::<f64>() / seen.len() as f64,
        delta_e: errors.delta_e_mean(),
        delta_e_99: errors.delta_e_quantile(0.99),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise hides most at so few samples; but all shortcuts share it.
    #[test]
    fn a_flat_share_is_farther_off_than_a_coupled_one_and_direct_light_than_either() {
        let size = Size { side: 24, samples: 128 };
        let rows = rows(size).expect("a built-in scene");
        println!("{}", table(&rows, size).text());
        let of = |truth: Way, name: &str| {
            let row = rows.iter().find(|row| row.truth == truth.name && row.name == name);
            row.unwrap_or_else(|| panic!("{name}")).apart
        };
        for truth in [DIRECT, ALL] {
            let [coupled, flat] =
                ["coupled", "flat"].map(|energy| of(truth, &format!("RGB, {energy}, direct light")));
            assert!(coupled.delta_e < flat.delta_e && coupled.rmse < flat.rmse, "{coupled:?} {flat:?}");
        }
        let left_out = of(ALL, DIRECT.name);
        assert!(left_out.delta_e > 2.0 * of(ALL, NOISE).delta_e, "{left_out:?}");
        assert!(left_out.delta_e > 2.0 * of(DIRECT, "RGB, flat, direct light").delta_e, "{left_out:?}");
        assert!(rows.iter().all(|row| row.seconds > 0.0 && row.apart.flip < 0.5));
    }
}
