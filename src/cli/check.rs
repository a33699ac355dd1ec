//! `check`: diagnostics only.

use std::io::Write as _;

use super::args::Check;
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::render;

/// Tell everything that is wrong with every preset.
pub(super) fn run(args: &Check) -> Result<Exit, Failure> {
    let mut worst = Exit::Done;
    for word in &args.presets {
        match check(word, args) {
            Ok(line) if !args.quiet => writeln!(anstream::stdout(), "{line}")?,
            Ok(_) => {}
            Err(failure) => {
                render::failure(&failure);
                worst = worst.max(failure.exit());
            }
        }
    }
    Ok(worst)
}

fn check(word: &str, args: &Check) -> Result<String, Failure> {
    let preset = Preset::open(word, &args.set.settings)?;
    let graph = preset.graph()?;
    let maps: Vec<&str> = graph.maps.keys().map(|m| m.name()).collect();
    let maps = if maps.is_empty() { "no maps".to_owned() } else { maps.join(", ") };
    Ok(format!(
        "{}: {} nodes, {} x {} mm, {maps}",
        graph.name,
        graph.nodes.len(),
        graph.girth_mm,
        graph.length_mm
    ))
}
