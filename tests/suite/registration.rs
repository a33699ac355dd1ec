//! The maps of a set are registered: outlines of scales coincide in height, normal, film thickness and id.

use ophidian::base::{Domain, MapKind, Plane};
use ophidian::graph::Graph;
use ophidian::maps::MapImage;
use ophidian::preset::builtin::BUILTIN;
use rayon::prelude::*;

use crate::made;

const WANTED: [MapKind; 4] = [MapKind::Height, MapKind::Normal, MapKind::Iridescence, MapKind::ScaleId];

/// A domain with about ten texels to a scale in each direction.
fn domain(graph: &Graph) -> Domain {
    let scales = graph.maps[&MapKind::ScaleId].range[1];
    let ratio = (graph.girth_mm / graph.length_mm).max(graph.length_mm / graph.girth_mm);
    let longer = (10.0 * (scales * ratio).sqrt()) as usize;
    made::domain(graph, longer.clamp(128, 1024))
}

/// How well a map tells borders of scales from their insides: the chance that its mark of a border, between two
/// neighbouring texels, is stronger over a border than inside a scale (the area under the ROC curve; 0.5 is no better
/// than chance). The map is moved by `shift` texels first.
///
/// The film is marked by its step. The height is continuous, since each rim rises from what lies beneath: its outlines
/// are creases, the second difference over four texels; and so normals on both sides lean towards each other.
fn tells_borders(map: &MapImage, ids: &Plane, shift: (i64, i64)) -> f64 {
    let (w, h) = (ids.width() as i64, ids.height() as i64);
    let (mut border, mut inside) = (Vec::new(), Vec::new());
    for y in 0..h {
        for x in 0..w {
            let id = ids.at(x, y);
            for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                let other = ids.at(x1, y1);
                // Skin is no scale.
                if id == 0.0 || other == 0.0 {
                    continue;
                }
                let at = |p: &Plane, i: i64| p.at(x + i * (x1 - x) - shift.0, y + i * (y1 - y) - shift.1);
                let p = &map.planes;
                let mark = match map.kind {
                    MapKind::Height => at(&p[0], -1) - at(&p[0], 0) - at(&p[0], 1) + at(&p[0], 2),
                    // Green grows up the image, rows go down.
                    MapKind::Normal if x1 == x => at(&p[1], 1) - at(&p[1], 0),
                    MapKind::Normal => at(&p[0], 0) - at(&p[0], 1),
                    _ => (at(&p[0], 0) - at(&p[0], 1)).abs(),
                };
                if id != other { &mut border } else { &mut inside }.push(mark);
            }
        }
    }
    inside.sort_by(f32::total_cmp);
    let below = |mark: f32| {
        let less = inside.partition_point(|&v| v < mark);
        let equal = inside.partition_point(|&v| v <= mark) - less;
        less as f64 + 0.5 * equal as f64
    };
    assert!(border.len() > 200, "only {} borders", border.len());
    border.iter().map(|&s| below(s)).sum::<f64>() / (border.len() * inside.len()) as f64
}

/// What is measured of one map: registered, moved by a texel (the best of four ways), moved by a third of a scale.
struct Row {
    what: String,
    kind: MapKind,
    own: f64,
    near: f64,
    moved: f64,
}

fn rows(name: &str) -> Vec<Row> {
    let graph = made::graph_with_film(name);
    let set = made::make(&graph, &WANTED, domain(&graph));
    let ids = &set.maps[&MapKind::ScaleId].planes[0];
    let row = |&kind: &MapKind| {
        let tells = |shift| tells_borders(&set.maps[&kind], ids, shift);
        let near = [(1, 0), (-1, 0), (0, 1), (0, -1)].map(tells).into_iter().fold(0.0, f64::max);
        Row { what: format!("{name} {kind}"), kind, own: tells((0, 0)), near, moved: tells((3, 3)) }
    };
    WANTED[..3].iter().map(row).collect()
}

#[test]
fn outlines_of_scales_coincide_in_every_map() {
    let rows: Vec<Row> = BUILTIN.par_iter().flat_map_iter(|(name, _)| rows(name)).collect();
    for r in &rows {
        println!("{:<40} {:.3}, a texel off {:.3}, a third of a scale {:.3}", r.what, r.own, r.near, r.moved);
    }
    for Row { what, kind, own, near, moved } in rows {
        assert!(own > 0.75, "{what}: {own:.3}");
        assert!(own - moved > 0.2, "{what}: {own:.3}, moved by a third of a scale {moved:.3}");
        // To the texel: the film jumps where the id does; the bottom of a crease may be wider than a texel.
        let slack = if kind == MapKind::Iridescence { 0.0 } else { 0.02 };
        assert!(own + slack > near, "{what}: {own:.3}, moved by a texel {near:.3}");
    }
}
