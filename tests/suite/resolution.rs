//! A map is the same image at any resolution: a small one against a large one, averaged down.

use std::collections::BTreeMap;

use ophidian::base::{Domain, MapKind, Plane};
use ophidian::maps::MapImage;
use rayon::prelude::*;

use crate::made;

/// How far a small map is from the averaged large one.
struct Gap {
    kind: MapKind,
    /// Root mean square and 99th percentile of the difference, in the map's unit: mm, nm, 1/mm, linear light,
    /// degrees between normals; for ids the share of texels that differ (twice the same number).
    rms: f32,
    p99: f32,
    /// Standard deviation of the map itself, in the same unit; of ids 1.
    spread: f32,
}

fn gaps(name: &str, longer: usize, factor: usize) -> Vec<Gap> {
    let graph = made::graph_with_film(name);
    let small = made::domain(&graph, longer);
    // A whole number of texels to one, so that an average is over a box.
    let large = Domain { width: small.width * factor, height: small.height * factor, ..small };
    let (small, large) = (made::make(&graph, &MapKind::ALL, small), made::make(&graph, &MapKind::ALL, large));
    MapKind::ALL.iter().map(|kind| gap(&small.maps[kind], &large.maps[kind], factor)).collect()
}

fn gap(small: &MapImage, large: &MapImage, factor: usize) -> Gap {
    let n = small.planes[0].data().len();
    let kind = small.kind;
    if kind == MapKind::ScaleId {
        let most = majority(&large.planes[0], factor);
        let other = small.planes[0].data().iter().zip(most.data()).filter(|(a, b)| a != b).count();
        let share = other as f32 / n as f32;
        return Gap { kind, rms: share, p99: share, spread: 1.0 };
    }
    let means: Vec<Plane> = large.planes.iter().map(|p| averaged(p, factor)).collect();
    let mut all: Vec<f32> = (0..n)
        .map(|i| {
            let a: Vec<f32> = small.planes.iter().map(|p| p.data()[i]).collect();
            let b: Vec<f32> = means.iter().map(|p| p.data()[i]).collect();
            if kind == MapKind::Normal { degrees(&a, &b) } else { distance(&a, &b) }
        })
        .collect();
    let rms = (all.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>() / n as f64).sqrt() as f32;
    all.sort_by(f32::total_cmp);
    let spread = if kind == MapKind::Normal {
        let tilt = |i: usize| {
            let b: Vec<f32> = means.iter().map(|p| p.data()[i]).collect();
            f64::from(degrees(&b, &[0.0, 0.0, 1.0])).powi(2)
        };
        ((0..n).map(tilt).sum::<f64>() / n as f64).sqrt() as f32
    } else {
        means.iter().map(variance).sum::<f64>().sqrt() as f32
    };
    Gap { kind, rms, p99: all[(0.99 * (n - 1) as f32) as usize], spread }
}

fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

fn degrees(a: &[f32], b: &[f32]) -> f32 {
    let length = |v: &[f32]| v.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-12);
    let (la, lb) = (length(a), length(b));
    let (a, b): (Vec<f32>, Vec<f32>) =
        (a.iter().map(|x| x / la).collect(), b.iter().map(|x| x / lb).collect());
    // The chord: exact for small angles, where the cosine is not.
    (2.0 * (0.5 * distance(&a, &b)).min(1.0).asin()).to_degrees()
}

fn variance(p: &Plane) -> f64 {
    let n = p.data().len() as f64;
    let mean = p.data().iter().map(|v| f64::from(*v)).sum::<f64>() / n;
    p.data().iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / n
}

/// The values of a box of `factor` by `factor` texels.
fn in_box(p: &Plane, factor: usize, x: usize, y: usize) -> impl Iterator<Item = f32> + '_ {
    (0..factor * factor)
        .map(move |i| p.at((x * factor + i % factor) as i64, (y * factor + i / factor) as i64))
}

fn averaged(p: &Plane, factor: usize) -> Plane {
    Plane::from_fn(p.width() / factor, p.height() / factor, |x, y| {
        in_box(p, factor, x, y).sum::<f32>() / (factor * factor) as f32
    })
}

fn majority(p: &Plane, factor: usize) -> Plane {
    Plane::from_fn(p.width() / factor, p.height() / factor, |x, y| {
        let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
        for id in in_box(p, factor, x, y) {
            *counts.entry(id as u32).or_default() += 1;
        }
        counts.into_iter().max_by_key(|(_, n)| *n).map_or(0.0, |(id, _)| id as f32)
    })
}

fn table(name: &str, longer: usize, factor: usize) -> (String, Vec<Gap>) {
    let gaps = gaps(name, longer, factor);
    let mut text = format!("{name}: {longer} against {}, averaged\n", longer * factor);
    for g in &gaps {
        let unit = match g.kind {
            MapKind::Normal => "degrees",
            MapKind::ScaleId => "share",
            kind => kind.unit(),
        };
        let relative = if g.spread > 0.0 { g.rms / g.spread } else { 0.0 };
        text.push_str(&format!(
            "  {:<18} rms {:>9.5}  p99 {:>9.5} {:<8} rms/spread {:.3}\n",
            g.kind.name(),
            g.rms,
            g.p99,
            unit,
            relative
        ));
    }
    (text, gaps)
}

/// Greatest RMS difference of presets whose scales are ten texels and more, as a share of the map's own spread. An image
/// of edges is sampled at texel centres, not averaged, so half a texel along every edge differs; most where the map is
/// finer than a texel (octaves of noise in roughness and film, creases in normals).
fn bound(kind: MapKind) -> f32 {
    match kind {
        MapKind::ScaleId => 0.025,
        MapKind::Height | MapKind::Translucency => 0.18,
        MapKind::Color | MapKind::PatternMask => 0.22,
        MapKind::Curvature => 0.35,
        MapKind::Iridescence | MapKind::Normal => 0.5,
        MapKind::Roughness => 0.65,
        // Creases narrower than a texel do not darken a small map.
        MapKind::AmbientOcclusion => 0.9,
    }
}

fn hold(name: &str, longer: usize, factor: usize, slack: f32) {
    let (text, gaps) = table(name, longer, factor);
    println!("{text}");
    for g in gaps {
        let most = slack * bound(g.kind) * g.spread + 1e-6;
        assert!(g.rms <= most, "{name} {}: {} is over {most}\n{text}", g.kind, g.rms);
    }
}

#[test]
fn small_maps_are_large_ones_averaged() {
    ["lampropeltis_triangulum", "xenopeltis_unicolor", "bungarus_fasciatus"]
        .par_iter()
        .for_each(|name| hold(name, 256, 4, 1.0));
}

/// The bounds mean something: maps moved by a third of a scale are over them.
#[test]
fn maps_that_do_not_fit_are_over_the_bounds() {
    let graph = made::graph_with_film("lampropeltis_triangulum");
    let small = made::domain(&graph, 256);
    let large = Domain { width: 2 * small.width, height: 2 * small.height, ..small };
    let (small, large) = (made::make(&graph, &MapKind::ALL, small), made::make(&graph, &MapKind::ALL, large));
    for (kind, map) in &small.maps {
        let moved = MapImage::new(*kind, map.planes.iter().map(|p| p.shifted(3, 3)).collect());
        let g = gap(&moved, &large.maps[kind], 2);
        println!("{kind}: {:.3} moved", g.rms / g.spread);
        assert!(g.rms > bound(*kind) * g.spread, "{kind}: {} of {}", g.rms, g.spread);
    }
}

/// Run it in release for the whole table.
#[test]
#[ignore = "minutes, gigabytes: the full table of 512 against 4096"]
fn maps_at_512_are_those_at_4096_averaged() {
    for name in ["lampropeltis_triangulum", "xenopeltis_unicolor", "bitis_gabonica", "python_regius"] {
        // Scales of vipers and pythons are small at 512, and keels are about a texel wide.
        hold(name, 512, 8, 2.0);
    }
}
