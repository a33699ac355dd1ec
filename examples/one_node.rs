//! One node, without a preset or a graph: cells of Worley noise to a grey PNG.
//!
//! ```text
//! cargo run --release --example one_node -- cells.png
//! ```

use ophidian::base::Domain;
use ophidian::eval::{Input, run_node};
use ophidian::node::generate::{Metric, Worley};
use ophidian::node::{Assets, Operation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "cells.png".into());

    // A node is a struct of its settings; what a map could drive are its inputs, in the order of its spec.
    let node = Worley { cells_u: 9, cells_v: 9, metric: Metric::Euclidean, jitter: 0.8 };
    let mut inputs = vec![Input::Unset; Worley::SPEC.inputs.len()];
    if let Some(du) = Worley::SPEC.input("du") {
        inputs[du] = Input::Value(0.25);
    }

    let domain = Domain::square(512);
    let planes = run_node(&node, &domain, 7, &inputs, &Assets::new(), 0);

    let samples = planes[0].data().iter().map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect();
    let (width, height) = (domain.width as u32, domain.height as u32);
    image::GrayImage::from_raw(width, height, samples).ok_or("one sample per texel")?.save(&file)?;

    let outputs: Vec<&str> = Worley::SPEC.outputs.iter().map(|o| o.name).collect();
    println!("{file}: {}, the first of {}", outputs[0], outputs.join(", "));
    Ok(())
}
