//! Built-in presets made small, for the tests that look at their maps.

use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex};

use ophidian::base::{Domain, MapKind};
use ophidian::eval::{self, Control, MapPlanes};
use ophidian::graph::{self, Graph, Source};
use ophidian::maps::{SetId, TextureSet, assemble};
use ophidian::plan::Plan;
use ophidian::preset::builtin::{self, BUILTIN};
use ophidian::preset::{Diagnostics, Document, overrides};
use rayon::prelude::*;

/// Held by tests that force a SIMD level, which is the whole process's.
pub(crate) static LEVEL: Mutex<()> = Mutex::new(());

/// The graph of a built-in preset, with settings such as `iridescence.thickness_nm=300`.
pub(crate) fn graph(name: &str, settings: &[&str]) -> Graph {
    let mut document = builtin::document(name).expect("a built-in preset");
    let mut diagnostics = Diagnostics::new();
    for setting in settings {
        assert!(overrides::apply(&mut document, setting, &mut diagnostics), "{setting}");
    }
    graph::from_document(&document, None).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The same, with a film of 300 nm where the snake has none: a map that is 0 everywhere proves nothing.
pub(crate) fn graph_with_film(name: &str) -> Graph {
    let own = graph(name, &[]);
    match own.maps[&MapKind::Iridescence].source {
        Source::Scalar(_) => graph(name, &["iridescence.thickness_nm=300"]),
        _ => own,
    }
}

/// A graph from its text, nodes only.
pub(crate) fn parse(text: &str) -> Graph {
    let document = Document::parse("graph.toml", text).unwrap_or_else(|error| panic!("{error}"));
    graph::from_document(&document, None).unwrap_or_else(|error| panic!("{error}"))
}

/// The planes of wanted maps.
pub(crate) fn planes(graph: &Graph, wanted: &[MapKind], domain: Domain) -> BTreeMap<MapKind, MapPlanes> {
    let plan = Plan::new(graph, wanted, domain, None).expect("a plan");
    eval::run(&plan, Control::default()).expect("nobody cancels").maps
}

/// The domain of a preset with `longer` texels on its longer side.
pub(crate) fn domain(graph: &Graph, longer: usize) -> Domain {
    Domain::from_longer_side(longer, graph.girth_mm, graph.length_mm)
}

/// The wanted maps, on the current pool of threads.
pub(crate) fn make(graph: &Graph, wanted: &[MapKind], domain: Domain) -> TextureSet {
    let plan = Plan::new(graph, wanted, domain, None).expect("a plan");
    let made = eval::run(&plan, Control::default()).expect("nobody cancels");
    assemble(made, SetId::new(graph, domain))
}

/// Every built-in preset at 256, all maps, all with a film.
pub(crate) static ALL_256: LazyLock<BTreeMap<&str, TextureSet>> = LazyLock::new(|| {
    let one = |(name, _): &(&'static str, &str)| {
        let graph = graph_with_film(name);
        (*name, make(&graph, &MapKind::ALL, domain(&graph, 256)))
    };
    BUILTIN.par_iter().map(one).collect()
});
