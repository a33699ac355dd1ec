//! Prints the BLAKE3 of every map of every built-in preset at 128 texels, before encoding.
//!
//! The library alone, without its default features, so that it also builds for other machines; CI runs it there and
//! compares with `tests/golden/planes_128.txt`:
//!
//! ```text
//! cargo run --release --no-default-features --example golden_planes
//! ```

use ophidian::base::{Domain, MapKind};
use ophidian::maps::{SetId, assemble, plane_hash};
use ophidian::plan::Plan;
use ophidian::preset::builtin;
use ophidian::{eval, graph};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, _) in builtin::BUILTIN {
        let graph = graph::from_document(&builtin::document(name)?, None)?;
        let domain = Domain::from_longer_side(128, graph.girth_mm, graph.length_mm);
        let plan = Plan::new(&graph, &MapKind::ALL, domain, None)?;
        let evaluation = eval::run(&plan, eval::Control::default())?;
        let set = assemble(evaluation, SetId::new(&graph, domain));
        for (kind, map) in &set.maps {
            let hash: String = plane_hash(map).iter().map(|b| format!("{b:02x}")).collect();
            println!("{hash}  {name} {kind}");
        }
    }
    Ok(())
}
