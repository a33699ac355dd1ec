//! The pictures of the README: every built-in preset under one light, and the maps of one of them.
//!
//! ```text
//! cargo run --release --example contact_sheet
//! ```
//!
//! writes `docs/contact_sheet.jpg` (presets in the order of `ophidian presets`, row by row) and `docs/maps.jpg` (maps in
//! the order of [`MapKind::ALL`], row by row). Each cell shows the middle of the back, head up, and repeats along the
//! body where the tile is shorter than the cell.

use std::fs::File;
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};
use ophidian::base::{Domain, MapKind, color, hash};
use ophidian::eval::{self, Evaluation, MapPlanes};
use ophidian::graph;
use ophidian::plan::Plan;
use ophidian::preset::builtin;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Samples per texel of a picture, in each direction.
const OVER: usize = 2;
/// Texels between cells.
const GAP: usize = 6;
/// Quality of the JPEG files.
const QUALITY: u8 = 84;
/// The preset whose maps are shown.
const SHOWN: &str = "epicrates_cenchria";

fn main() -> Result<()> {
    let docs = Path::new("docs");
    std::fs::create_dir_all(docs)?;

    // Four fifths of the girth: what is seen of a snake from above and a little of its flanks.
    let mut cells = Vec::new();
    for (name, _) in builtin::BUILTIN {
        let wanted = [MapKind::Color, MapKind::Normal, MapKind::Roughness, MapKind::AmbientOcclusion];
        let (domain, evaluation) = evaluate(name, &wanted, 300 * OVER * 5 / 4)?;
        cells.push(cell(&domain, [300, 400], |i| lit(&evaluation, i)));
        println!("{name}");
    }
    save(&grid(&cells, 6), &docs.join("contact_sheet.jpg"))?;

    // Half the girth, so that single scales show.
    let (domain, evaluation) = evaluate(SHOWN, &MapKind::ALL, 360 * OVER * 2)?;
    let cells: Vec<RgbImage> = evaluation
        .maps
        .iter()
        .map(|(kind, map)| {
            let span = span(*kind, map);
            cell(&domain, [360, 360], |i| shown(*kind, map, span, i))
        })
        .collect();
    save(&grid(&cells, 5), &docs.join("maps.jpg"))
}

/// The maps of a preset, `width` texels around the body.
fn evaluate(name: &str, wanted: &[MapKind], width: usize) -> Result<(Domain, Evaluation)> {
    let graph = graph::from_document(&builtin::document(name)?, None)?;
    let (girth_mm, length_mm) = (graph.girth_mm, graph.length_mm);
    let height = (width as f32 * length_mm / girth_mm).round().max(1.0) as usize;
    let domain = Domain { width, height, girth_mm, length_mm };
    let plan = Plan::new(&graph, wanted, domain, None)?;
    Ok((domain, eval::run(&plan, eval::Control::default())?))
}

/// The colour of texel `i` under one lamp and a little sky: Lambert, and GGX over a base of index 1.55.
fn lit(evaluation: &Evaluation, i: usize) -> [f32; 3] {
    let planes = |kind| evaluation.maps[&kind].planes.iter().map(move |p| p.data()[i]);
    let normal: Vec<f32> = planes(MapKind::Normal).collect();
    let roughness: f32 = planes(MapKind::Roughness).sum();
    let open: f32 = planes(MapKind::AmbientOcclusion).sum();
    // Unit vectors to the lamp, upper left, and half way between it and the viewer straight above.
    let cos = |v: [f32; 3]| (0..3).map(|k| normal[k] * v[k]).sum::<f32>().max(0.0);
    let (cos_i, cos_m) = (cos([-0.40, 0.50, 0.768]), cos([-0.2127, 0.2659, 0.9402]));
    // A square as artists have it; below 0.01 the lobe is narrower than a texel.
    let alpha2 = (roughness * roughness).max(0.01).powi(2);
    let d = alpha2 / (std::f32::consts::PI * (cos_m * cos_m * (alpha2 - 1.0) + 1.0).powi(2));
    let gloss = 0.046 * d * 0.25 * cos_i + 0.01 * open;
    let mut out = [gloss; 3];
    for (o, albedo) in out.iter_mut().zip(planes(MapKind::Color)) {
        *o += albedo * (0.25 * open + cos_i);
    }
    out
}

/// The values that are shown black and white: the map's own span without its outliers.
fn span(kind: MapKind, map: &MapPlanes) -> [f32; 2] {
    if matches!(kind, MapKind::Color | MapKind::Normal | MapKind::ScaleId | MapKind::PatternMask) {
        return [0.0, 1.0];
    }
    let mut values = map.planes[0].data().to_vec();
    values.sort_by(f32::total_cmp);
    let at = |share: f32| values[(share * (values.len() - 1) as f32) as usize];
    let (lo, hi) = (at(0.005), at(0.995));
    [lo, if hi > lo { hi } else { lo + 1.0 }]
}

/// A map's texel `i` as a linear colour; data are shown as a viewer without colour management shows their file.
fn shown(kind: MapKind, map: &MapPlanes, [lo, hi]: [f32; 2], i: usize) -> [f32; 3] {
    let v = |k: usize| map.planes[k].data()[i];
    match kind {
        MapKind::Color => [v(0), v(1), v(2)],
        MapKind::Normal => [0, 1, 2].map(|k| color::srgb_to_linear(0.5 * v(k) + 0.5)),
        // Ids as colours of their own; skin is black.
        MapKind::ScaleId if v(0) == 0.0 => [0.0; 3],
        MapKind::ScaleId => {
            let id = hash::hash1(1, v(0) as u32);
            color::hsl_to_rgb([hash::unit(id), 0.6, 0.35 + 0.3 * hash::unit(hash::hash1(2, id))])
                .map(color::srgb_to_linear)
        }
        _ => [color::srgb_to_linear(((v(0) - lo) / (hi - lo)).clamp(0.0, 1.0)); 3],
    }
}

/// A picture of the middle of the back, from the linear colour of each texel of the tile.
fn cell(domain: &Domain, [width, height]: [usize; 2], texel: impl Fn(usize) -> [f32; 3]) -> RgbImage {
    let left = (domain.width - width * OVER) / 2;
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let mut sum = [0.0; 3];
        for n in 0..OVER * OVER {
            let column = left + x as usize * OVER + n % OVER;
            let row = (y as usize * OVER + n / OVER) % domain.height;
            let color = texel(row * domain.width + column);
            (0..3).for_each(|k| sum[k] += color[k]);
        }
        Rgb(sum.map(|s| {
            let mean = (s / (OVER * OVER) as f32).clamp(0.0, 1.0);
            (color::linear_to_srgb(mean) * 255.0 + 0.5) as u8
        }))
    })
}

/// Cells of one size, row by row.
fn grid(cells: &[RgbImage], columns: usize) -> RgbImage {
    let (width, height) = (cells[0].width() as usize + GAP, cells[0].height() as usize + GAP);
    let rows = cells.len().div_ceil(columns);
    let mut sheet =
        RgbImage::from_pixel((columns * width + GAP) as u32, (rows * height + GAP) as u32, Rgb([24, 24, 24]));
    for (n, cell) in cells.iter().enumerate() {
        let (x, y) = (GAP + n % columns * width, GAP + n / columns * height);
        image::imageops::replace(&mut sheet, cell, x as i64, y as i64);
    }
    sheet
}

fn save(picture: &RgbImage, path: &Path) -> Result<()> {
    JpegEncoder::new_with_quality(File::create(path)?, QUALITY).encode_image(picture)?;
    println!("{}: {} x {}", path.display(), picture.width(), picture.height());
    Ok(())
}
