//! Sets in a row: what two of them have in common is evaluated once, and no bit of either changes.

use std::collections::BTreeMap;
use std::sync::Mutex;

use ophidian::base::watch::{Watch, Work};
use ophidian::base::{Domain, MapKind};
use ophidian::eval::{Control, MapPlanes, run};
use ophidian::graph::Graph;
use ophidian::plan::{Order, Plan, Shelf};

use crate::cli::ophidian;
use crate::made;

const SNAKE: &str = "lampropeltis_triangulum";

/// Counts how often each node is at work.
#[derive(Debug, Default)]
struct Counts(Mutex<BTreeMap<String, usize>>);

impl Watch for Counts {
    fn begin(&self) -> u64 {
        0
    }

    fn end(&self, _: u64, work: Work, name: &str) {
        if work == Work::Node {
            *self.0.lock().expect("no one panics").entry(name.to_owned()).or_default() += 1;
        }
    }
}

fn values(maps: &BTreeMap<MapKind, MapPlanes>) -> Vec<Vec<u32>> {
    let planes = maps.values().flat_map(|map| &map.planes);
    planes.map(|plane| plane.data().iter().map(|v| v.to_bits()).collect()).collect()
}

/// A colour of another snake, and nothing else.
fn variants() -> [Graph; 3] {
    [&[][..], &["color.base=\"#80A0FF\""], &["color.base=\"#40FF40\"", "color.vary_lightness=0.2"]]
        .map(|settings| made::graph(SNAKE, settings))
}

fn order(graph: &Graph) -> Order<'_> {
    let domain = Domain { width: 125, height: 163, ..made::domain(graph, 163) };
    Order { graph, wanted: &MapKind::FIVE, domain }
}

/// Plan and make a series; the plans, and how often each node was at work in each set.
fn make(graphs: &[Graph], budget: Option<u64>) -> Vec<(Plan, BTreeMap<String, usize>)> {
    let mut shelf = Shelf::default();
    let mut made = Vec::new();
    for (k, graph) in graphs.iter().enumerate() {
        let next = graphs.get(k + 1).map(order);
        let (plan, slabs, kept) = Plan::in_series(order(graph), next, &shelf, budget, None).expect("a plan");
        assert!(slabs.is_none());
        let counts = Counts::default();
        let control = Control { watch: Some(&counts), ..Control::default() };
        let maps = run(&plan, control).expect("nobody cancels").maps;
        let alone = Plan::new(graph, &MapKind::FIVE, plan.domain, None).expect("a plan");
        let alone = run(&alone, Control::default()).expect("nobody cancels").maps;
        assert!(values(&maps) == values(&alone), "set {k} differs");
        shelf = kept;
        made.push((plan, counts.0.into_inner().expect("no one panicked")));
    }
    assert!(shelf.is_empty(), "nothing comes after the last set");
    made
}

#[test]
fn variants_of_a_colour_evaluate_the_lattice_once() {
    let made = make(&variants(), None);
    assert!(made[0].1["scales"] > 0);
    for (plan, counts) in &made[1..] {
        assert!(!counts.contains_key("scales"), "{:?}", counts.keys());
        // What differs is evaluated, of course.
        assert!(counts.contains_key("skin_color") && counts.keys().any(|name| name.starts_with("shown")));
        assert!(plan.cost_ms() < 0.6 * made[0].0.cost_ms());
    }
}

#[test]
fn individuals_have_too_little_in_common_to_keep_it() {
    let graph = made::graph(SNAKE, &[]);
    let next = graph.clone().with_seed(99);
    let (plan, _, shelf) =
        Plan::in_series(order(&graph), Some(order(&next)), &Shelf::default(), None, None).expect("a plan");
    assert!(shelf.is_empty(), "{:?}", plan.steps.iter().map(|s| &s.name).collect::<Vec<_>>());
    // Nor have sets of two sizes.
    let other = Order { domain: Domain::square(64), ..order(&graph) };
    let series = Plan::in_series(order(&graph), Some(other), &Shelf::default(), None, None);
    assert!(series.expect("a plan").2.is_empty());
}

#[test]
fn sharing_is_left_out_where_memory_does_not_allow_it() {
    let graphs = variants();
    let alone: Vec<u64> = (graphs.iter())
        .map(|g| Plan::new(g, &MapKind::FIVE, order(g).domain, None).expect("a plan").peak_bytes)
        .collect();
    let budget = alone.iter().copied().max().expect("three sets");
    for (plan, counts) in make(&graphs, Some(budget)) {
        assert!(plan.peak_bytes <= budget && counts.contains_key("scales"));
    }
    let peak = make(&graphs, None).iter().map(|(plan, _)| plan.peak_bytes).max().expect("three sets");
    assert!(peak > budget, "what is kept counts");
    assert!(make(&graphs, Some(peak)).iter().skip(1).all(|(_, counts)| !counts.contains_key("scales")));
}

#[test]
fn a_run_of_many_sets_writes_the_files_of_separate_runs() {
    let dir = tempfile::tempdir().expect("a folder");
    let files = |name: &str| -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(dir.path().join(name)).expect("a folder of files");
        let one = |entry: std::io::Result<std::fs::DirEntry>| {
            let entry = entry.expect("an entry");
            (entry.file_name().into_string().expect("a name"), std::fs::read(entry.path()).expect("a file"))
        };
        entries.map(one).filter(|(name, _)| name.ends_with("png")).collect()
    };
    let variant = |name: &str, color: &str| {
        let text = format!("include = \"{SNAKE}.toml\"\nname = \"{name}\"\n[color]\nbase = \"{color}\"\n");
        std::fs::write(dir.path().join(format!("{name}.toml")), text).expect("written");
    };
    variant("red", "#FF4030");
    variant("blue", "#3040FF");
    let make = |out: &str, args: &[&str]| {
        let made = ophidian()
            .current_dir(dir.path())
            .args(["generate", "--size", "64", "-o", out])
            .args(args)
            .output();
        let made = made.expect("it runs");
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        String::from_utf8(made.stdout).expect("text")
    };
    let told = make("together", &["red.toml", "blue.toml", "python_regius", "--seeds", "3..5"]);
    // All presets of one individual, then of the next.
    let first: Vec<&str> = told.lines().filter_map(|line| line.split(':').next()).collect();
    assert_eq!(
        first,
        [
            "red seed 3",
            "blue seed 3",
            "python_regius seed 3",
            "red seed 4",
            "blue seed 4",
            "python_regius seed 4"
        ]
    );
    for (preset, seed) in ["red.toml", "blue.toml", "python_regius"].iter().flat_map(|p| [(p, "3"), (p, "4")])
    {
        make("apart", &[preset, "--seed", seed, "--name", "{preset}_{seed}_{map}.{ext}"]);
    }
    make("traced", &["red.toml", "blue.toml", "--seeds", "3..5", "--trace", "trace.json"]);
    let together = files("together");
    assert!(together == files("apart"));
    assert!(files("traced").iter().all(|(name, bytes)| together[name] == *bytes));

    // Of four sets two evaluated the lattice: one of each individual.
    let trace = std::fs::read_to_string(dir.path().join("trace.json")).expect("a trace");
    let trace: serde_json::Value = serde_json::from_str(&trace).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    let mut lattices: Vec<(&str, bool)> = Vec::new();
    for event in events {
        // A set comes before what it consists of.
        match (event["cat"].as_str(), event["name"].as_str(), lattices.last_mut()) {
            (Some("set"), Some(name), _) => lattices.push((name, false)),
            (Some("node"), Some("scales"), Some((_, evaluated))) => *evaluated = true,
            _ => {}
        }
    }
    assert_eq!(
        lattices,
        [("red seed 3", true), ("blue seed 3", false), ("red seed 4", true), ("blue seed 4", false)]
    );
}
