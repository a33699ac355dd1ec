//! A built-in preset to a directory of PNG files, as `ophidian generate` does it.
//!
//! ```text
//! cargo run --release --example preset_to_png -- python_regius out
//! ```

use std::path::Path;

use ophidian::base::{Domain, MapKind};
use ophidian::io::{WriteOptions, write_set};
use ophidian::maps::{SetId, assemble};
use ophidian::plan::Plan;
use ophidian::preset::builtin;
use ophidian::{eval, graph};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_else(|| "python_regius".into());
    let directory = words.next().unwrap_or_else(|| "out".into());

    // Text to graph; `Some(3)` would be the third individual instead of the preset's own.
    let document = builtin::document(&name)?;
    let graph = graph::from_document(&document, None)?;

    // What is needed for these maps at this size, and how much memory that takes.
    let domain = Domain::from_longer_side(1024, graph.girth_mm, graph.length_mm);
    let plan = Plan::new(&graph, &MapKind::FIVE, domain, None)?;
    println!("{} steps, {} MiB at most", plan.steps.len(), plan.peak_bytes >> 20);

    let evaluation = eval::run(&plan, eval::Control::default())?;
    let set = assemble(evaluation, SetId::new(&graph, domain));
    for entry in write_set(&set, Path::new(&directory), &WriteOptions::default(), &|_| {})? {
        println!("{directory}/{}", entry.file);
    }
    Ok(())
}
