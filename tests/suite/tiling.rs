//! Every map of every preset tiles: a seam is no more visible than any other line of texels.

use ophidian::base::{MapKind, Plane};
use ophidian::maps::MapImage;

use crate::made::ALL_256;

/// Which seam: the one that lies along the body's side (columns), or the one across it (rows).
#[derive(Clone, Copy, Debug)]
enum Seam {
    U,
    V,
}

/// Steps from each line of texels to the next; the last goes over the seam.
struct Steps {
    /// Mean step of a line.
    mean: Vec<f32>,
    /// The 99.9th percentile.
    high: Vec<f32>,
}

/// Steps between lines of a map. A step of colours and normals is a distance, of ids whether they change.
fn steps(map: &MapImage, seam: Seam) -> Steps {
    let (w, h) = (map.width(), map.height());
    let (lines, length) = match seam {
        Seam::U => (w, h),
        Seam::V => (h, w),
    };
    let at = |plane: &Plane, line: usize, i: usize| match seam {
        Seam::U => plane.data()[i * w + line],
        Seam::V => plane.data()[line * w + i],
    };
    let step = |a: usize, b: usize, i: usize| {
        if map.kind == MapKind::ScaleId {
            return f32::from(u8::from(at(&map.planes[0], a, i) != at(&map.planes[0], b, i)));
        }
        let square = |p: &Plane| (at(p, a, i) - at(p, b, i)).powi(2);
        map.planes.iter().map(square).sum::<f32>().sqrt()
    };
    let mut steps = Steps { mean: Vec::new(), high: Vec::new() };
    for line in 0..lines {
        let mut all: Vec<f32> = (0..length).map(|i| step(line, (line + 1) % lines, i)).collect();
        all.sort_by(f32::total_cmp);
        steps.mean.push(all.iter().sum::<f32>() / length as f32);
        steps.high.push(all[(0.999 * (length - 1) as f32) as usize]);
    }
    steps
}

/// The seam's step over the greatest inside.
fn ratio(values: &[f32]) -> f32 {
    let (seam, inside) = values.split_last().expect("lines");
    let most = inside.iter().copied().fold(0.0, f32::max);
    if *seam <= 1e-6 { 0.0 } else { seam / most.max(1e-12) }
}

/// How much more the seam's mean and high steps may be than the greatest inside. Of hundreds of lines one is the
/// greatest by chance: a little for what follows from the scales, whose phases all occur inside; more for pigment, where
/// a border of belly checks may lie on the seam, two dozen of them, black or white by chance.
fn most(kind: MapKind) -> f32 {
    if matches!(kind, MapKind::Color | MapKind::PatternMask) { 1.35 } else { 1.05 }
}

fn shows(map: &MapImage, seam: Seam) -> Option<String> {
    let steps = steps(map, seam);
    let (mean, high, most) = (ratio(&steps.mean), ratio(&steps.high), most(map.kind));
    (mean > most || high > most).then(|| format!("{} {seam:?}: mean {mean:.3}, high {high:.3}", map.kind))
}

#[test]
fn no_seam_stands_out() {
    let mut told = Vec::new();
    for (name, set) in &*ALL_256 {
        for map in set.maps.values() {
            for seam in [Seam::U, Seam::V] {
                told.extend(shows(map, seam).map(|fault| format!("{name} {fault}")));
            }
        }
    }
    assert!(told.is_empty(), "\n{}", told.join("\n"));
}

/// The same maps cut to three quarters no longer tile: that must show, in every preset and at both seams.
#[test]
fn a_tile_cut_short_shows_its_seam() {
    for (name, set) in &*ALL_256 {
        for seam in [Seam::U, Seam::V] {
            let shown = set.maps.values().filter(|map| shows(&cut(map, seam), seam).is_some()).count();
            assert!(shown > 0, "{name}: a tile cut at {seam:?} passes");
        }
    }
}

fn cut(map: &MapImage, seam: Seam) -> MapImage {
    let (w, h) = (map.width(), map.height());
    let (w, h) = match seam {
        Seam::U => (3 * w / 4, h),
        Seam::V => (w, 3 * h / 4),
    };
    let short = |p: &Plane| Plane::from_fn(w, h, |x, y| p.at(x as i64, y as i64));
    MapImage::new(map.kind, map.planes.iter().map(short).collect())
}
