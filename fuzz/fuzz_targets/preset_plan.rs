//! Any bytes as a preset: document, graph, plan. A diagnostic or a plan, never a panic and never much memory.
//!
//! `cargo +nightly fuzz run preset_plan fuzz/corpus presets`, from the package's folder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ophidian::base::Domain;
use ophidian::graph;
use ophidian::plan::Plan;
use ophidian::preset::Document;

fuzz_target!(|data: &[u8]| {
    let built = Document::parse_bytes("fuzz.toml", data).and_then(|document| graph::build(&document));
    match built {
        Ok((graph, _)) => {
            let wanted: Vec<_> = graph.maps.keys().copied().collect();
            let domain = Domain::from_longer_side(64, graph.girth_mm, graph.length_mm);
            let _ = Plan::new(&graph, &wanted, domain, Some(1 << 28));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
