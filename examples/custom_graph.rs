//! A graph built in Rust: cells with a colour ramp and bumps, to the planes of three maps.
//!
//! ```text
//! cargo run --release --example custom_graph
//! ```

use std::collections::BTreeMap;

use ophidian::base::{Domain, MapKind, Srgb8};
use ophidian::eval;
use ophidian::graph::{MapDraft, Sketch, resolve, to_toml};
use ophidian::node::combine::{Mix, Multiply};
use ophidian::node::convert::HeightToNormal;
use ophidian::node::draft::{Draft, Wire};
use ophidian::node::filter::GaussianBlur;
use ophidian::node::generate::Worley;
use ophidian::plan::Plan;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Nodes by name; randomness hangs on the name, so that a node added elsewhere changes nothing.
    let mut draft = Draft::default();
    let cells = draft.add("cells", Worley { cells_u: 12, cells_v: 24, ..Worley::default() }, &[]);
    let soft = draft.add("soft", GaussianBlur::default(), &[("image", cells.clone())]);
    let height = draft.add("height", Multiply::default(), &[("a", soft), ("b", 0.4.into())]);
    let normal = draft.add("normal", HeightToNormal::default(), &[("height", height.clone())]);
    let [dark, light] = ["#14110F", "#9C3B24"].map(str::parse::<Srgb8>);
    let color = draft.add("color", Mix {}, &[("a", dark?.into()), ("b", light?.into()), ("mask", cells)]);

    let map = |wire: Wire, range| MapDraft { wire, range, span: None };
    let sketch = Sketch {
        name: "cells".into(),
        seed: 1,
        size_mm: [50.0, 100.0],
        draft,
        maps: BTreeMap::from([
            (MapKind::Color, map(color, [0.0, 1.0])),
            (MapKind::Height, map(height, [0.0, 0.4])),
            (MapKind::Normal, map(normal, [-1.0, 1.0])),
        ]),
    };

    // Every problem at once: unknown names, kinds that do not fit, ranges, circles.
    let graph = resolve(&sketch)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))?;
    println!("{}", to_toml(&graph));

    let domain = Domain::from_longer_side(512, graph.girth_mm, graph.length_mm);
    let wanted: Vec<MapKind> = graph.maps.keys().copied().collect();
    let plan = Plan::new(&graph, &wanted, domain, None)?;
    let evaluation = eval::run(&plan, eval::Control::default())?;
    for (kind, map) in &evaluation.maps {
        let mean = map.planes[0].data().iter().sum::<f32>() / domain.texels() as f32;
        println!("{kind}: {} x {}, mean of its first channel {mean:.3}", domain.width, domain.height);
    }
    Ok(())
}
