//! Maps that are made slab by slab are the maps that are made at once, bit for bit, within the memory that is allowed.

use std::collections::BTreeMap;
use std::convert::Infallible;

use ophidian::base::{Domain, MapKind};
use ophidian::eval::{Control, MapRows, run, run_slabs};
use ophidian::graph::Graph;
use ophidian::plan::{Plan, PlanError, Slabs};
use ophidian::preset::Document;

use crate::cli::ophidian;
use crate::made;

/// The values of every map, made slab by slab; each map asks for `again` rows once more.
fn in_slabs(plan: &Plan, slabs: &Slabs, again: usize) -> BTreeMap<MapKind, Vec<f32>> {
    let mut found: BTreeMap<MapKind, Vec<Vec<f32>>> = BTreeMap::new();
    let mut next = 0;
    let ready = |maps: &BTreeMap<MapKind, MapRows<'_>>, end: usize| -> Result<_, Infallible> {
        for (&kind, map) in maps {
            let channels = found.entry(kind).or_insert_with(|| vec![Vec::new(); map.lanes.len()]);
            for (all, lane) in channels.iter_mut().zip(&map.lanes) {
                all.truncate(next * plan.domain.width);
                (next..end).for_each(|y| all.extend_from_slice(lane.row(y as i64)));
            }
        }
        next = end.saturating_sub(again);
        Ok(maps.keys().map(|&kind| (kind, next)).collect())
    };
    run_slabs(plan, slabs, Control::default(), ready).expect("nobody stops");
    found.into_iter().map(|(kind, channels)| (kind, channels.concat())).collect()
}

fn assert_same(name: &str, graph: &Graph, domain: Domain) {
    let wanted: Vec<MapKind> = graph.maps.keys().copied().collect();
    let plan = Plan::new(graph, &wanted, domain, None).expect("a plan");
    let whole = run(&plan, Control::default()).expect("nobody cancels").maps;
    for (rows, again) in [(1, 0), (32, 5), (50, 60)] {
        let found = in_slabs(&plan, &Slabs::new(&plan, rows, again), again);
        assert_eq!(found.len(), whole.len());
        for (kind, planes) in &whole {
            let planes: Vec<f32> = planes.planes.iter().flat_map(|p| p.data().iter().copied()).collect();
            assert!(found[kind] == planes, "{name}: {kind} differs in slabs of {rows}");
        }
    }
}

#[test]
fn slabs_change_no_bit_of_the_built_in_presets() {
    for (name, _) in ophidian::preset::builtin::BUILTIN.iter().step_by(4) {
        assert_same(
            name,
            &made::graph_with_film(name),
            Domain { width: 61, height: 97, ..made::domain(&made::graph(name, &[]), 97) },
        );
    }
}

/// Nodes that want a whole plane, that read anywhere, that look far around: more than the tile is high.
#[test]
fn slabs_change_no_bit_of_nodes_that_read_from_afar() {
    let text = r#"
        [nodes.noise]
        op = "fractal"
        [nodes.far]
        op = "gaussian_blur"
        image = "noise"
        radius = 0.3
        [nodes.outside]
        op = "distance"
        mask = "noise"
        [nodes.bent]
        op = "warp"
        image = "far"
        [nodes.edge]
        op = "gaussian_blur"
        image = "bent"
        radius = 0.02
        [nodes.normal]
        op = "height_to_normal"
        height = "edge"
        [maps]
        height = "edge"
        normal = "normal"
        roughness = "outside"
        color = "far"
        pattern_mask = "far"
    "#;
    let document = Document::parse("far.toml", text).expect("a preset");
    let graph = ophidian::graph::from_document(&document, None).expect("a sound preset");
    assert_same("far", &graph, Domain::square(70));
}

#[test]
fn a_plan_takes_slabs_where_planes_are_large_and_says_what_it_would_need() {
    let graph = made::graph("python_regius", &[]);
    let sized = |size, budget| Plan::in_slabs(&graph, &MapKind::FIVE, made::domain(&graph, size), budget, 64);
    let (large, slabs) = sized(4096, None).expect("a plan");
    assert!(slabs.is_some() && large.peak_bytes <= 64 << 20, "{}", large.peak_bytes);
    let domain = made::domain(&graph, 1024);
    let whole = Plan::new(&graph, &MapKind::FIVE, domain, None).expect("a plan").peak_bytes;
    let plan = |budget| sized(1024, budget);
    assert!(plan(None).expect("a plan").1.is_none() && plan(Some(whole)).expect("a plan").1.is_none());
    let (small, slabs) = plan(Some(whole / 2)).expect("a plan");
    assert!(slabs.is_some() && small.peak_bytes <= whole / 2);
    let Err(PlanError::Memory { need, budget: 1000 }) = plan(Some(1000)) else { panic!("it cannot fit") };
    assert!(need < whole / 2 && plan(Some(need)).is_ok() && plan(Some(need - 1)).is_err());
}

#[test]
fn files_are_the_same_within_little_memory() {
    let dir = tempfile::tempdir().expect("a folder");
    let make = |name: &str, memory: &[&str]| {
        let output = ophidian()
            .args(["generate", "morelia_viridis", "--size", "256x1500", "--normal", "both", "--json", "-o"])
            .arg(dir.path().join(name))
            .args(memory)
            .output()
            .expect("the command runs");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (json["files"].clone(), json["peak_bytes"].as_u64().expect("a number"))
    };
    let (whole, much) = make("whole", &[]);
    let (slabs, little) = make("slabs", &["--memory", "16M", "--verify"]);
    assert!(little <= 16 << 20 && 16 << 20 < much, "{little} {much}");
    assert_eq!(whole, slabs);
    assert_eq!(whole.as_array().map(Vec::len), Some(11));
}
