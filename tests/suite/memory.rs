//! What a plan says it takes is what its evaluation takes, within 10 %.
//!
//! Resident memory is the whole process's, so each measurement runs in a process of its own: this test binary again,
//! with one ignored test.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::process::Command;

use ophidian::base::{Domain, MapKind};
use ophidian::eval::{Control, MapRows, run, run_slabs};
use ophidian::graph::Graph;
use ophidian::plan::{Order, Plan, Shelf};
use ophidian::preset::Document;

use crate::made;

/// A mask whose distance is taken: nodes that want the whole plane and work in memory of their own.
const WHOLE: &str = r#"
seed = 1
[nodes.noise]
op = "fractal"
[nodes.outside]
op = "distance"
mask = "noise"
[nodes.grown]
op = "dilate"
mask = "noise"
[maps]
height = "outside"
roughness = "grown"
"#;

/// What is measured: a name, a graph, its maps.
fn cases() -> Vec<(&'static str, Graph, Vec<MapKind>)> {
    let whole = Document::parse("whole.toml", WHOLE).expect("a preset");
    let whole = ophidian::graph::from_document(&whole, None).expect("a sound preset");
    vec![
        ("five", made::graph("python_regius", &[]), MapKind::FIVE.to_vec()),
        ("all", made::graph("lampropeltis_triangulum", &[]), MapKind::ALL.to_vec()),
        ("whole", whole, vec![MapKind::Height, MapKind::Roughness]),
    ]
}

/// A line of this process's status, bytes.
fn status(key: &str) -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("Linux tells");
    let line = text.lines().find(|line| line.starts_with(key)).expect("a known key");
    let kib: u64 = line.split_whitespace().nth(1).and_then(|n| n.parse().ok()).expect("a number");
    kib * 1024
}

#[test]
#[ignore = "run by the test below, alone in its process"]
fn measure() {
    let name = std::env::var("OPHIDIAN_TEST_CASE").expect("the test below says which");
    let (_, graph, maps) = cases().into_iter().find(|case| case.0 == name).expect("a case");
    let plan = Plan::new(&graph, &maps, made::domain(&graph, 1536), None).expect("a plan");
    rayon::broadcast(|_| ());
    // 5: the greatest resident size starts anew from here.
    std::fs::write("/proc/self/clear_refs", "5").expect("a process may reset its own");
    let before = status("VmRSS");
    let evaluation = run(&plan, Control::default()).expect("nobody cancels");
    let took = status("VmHWM") - before;
    assert_eq!(evaluation.maps.len(), maps.len());
    println!("took {took} planned {}", plan.peak_bytes);
}

/// The same slab by slab, at a size whose planes would take ten times as much.
#[test]
#[ignore = "run by the test below, alone in its process"]
fn measure_slabs() {
    let graph = made::graph("lampropeltis_triangulum", &[]);
    let domain = Domain { width: 1024, height: 12_288, ..made::domain(&graph, 1024) };
    let budget = Some(96 << 20);
    let (plan, slabs) = Plan::in_slabs(&graph, &MapKind::ALL, domain, budget, 16).expect("a plan");
    let slabs = slabs.expect("it does not fit whole");
    rayon::broadcast(|_| ());
    std::fs::write("/proc/self/clear_refs", "5").expect("a process may reset its own");
    let before = status("VmRSS");
    let ready = |maps: &BTreeMap<MapKind, MapRows<'_>>, end: usize| -> Result<_, Infallible> {
        Ok(maps.keys().map(|&kind| (kind, end - 16)).collect())
    };
    run_slabs(&plan, &slabs, Control::default(), ready).expect("nobody stops");
    println!("took {} planned {}", status("VmHWM") - before, plan.peak_bytes);
}

/// Two sets in a row that differ in a colour: the second one reads what the first one has kept.
#[test]
#[ignore = "run by the test below, alone in its process"]
fn measure_series() {
    let graphs = [&[][..], &["color.base=\"#80A0FF\""]].map(|s| made::graph("lampropeltis_triangulum", s));
    let domain = made::domain(&graphs[0], 1536);
    let [first, second] = [0, 1].map(|k| Order { graph: &graphs[k], wanted: &MapKind::FIVE, domain });
    rayon::broadcast(|_| ());
    std::fs::write("/proc/self/clear_refs", "5").expect("a process may reset its own");
    let before = status("VmRSS");
    let series = Plan::in_series(first, Some(second), &Shelf::default(), None, None);
    let (plan, _, shelf) = series.expect("a plan");
    drop(run(&plan, Control::default()).expect("nobody cancels"));
    let alone = plan.peak_bytes;
    drop(plan);
    let (plan, ..) = Plan::in_series(second, None, &shelf, None, None).expect("a plan");
    drop(run(&plan, Control::default()).expect("nobody cancels"));
    println!("took {} planned {}", status("VmHWM") - before, plan.peak_bytes.max(alone));
}

/// Bytes taken and planned, as a test of this binary tells them alone in a process.
fn measured(test: &str, case: &str) -> (f64, f64) {
    let output = Command::new(std::env::current_exe().expect("a path"))
        .args([test, "--exact", "--ignored", "--nocapture"])
        .env("OPHIDIAN_TEST_CASE", case)
        .output()
        .expect("the test binary runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find(|line| line.contains("took ")).unwrap_or_else(|| panic!("{text}"));
    let words: Vec<&str> = line[line.find("took").unwrap_or(0)..].split_whitespace().collect();
    let number = |i: usize| words[i].parse::<f64>().expect("a number");
    (number(1), number(3))
}

#[test]
fn the_planned_peak_is_within_a_tenth_of_the_measured_one() {
    for (name, ..) in cases() {
        let (took, planned) = measured("memory::measure", name);
        assert!((planned / took - 1.0).abs() < 0.1, "{name}: took {took}, planned {planned}");
    }
}

#[test]
fn the_planned_peak_of_slabs_is_within_a_tenth_of_the_measured_one() {
    let (took, planned) = measured("memory::measure_slabs", "");
    assert!((planned / took - 1.0).abs() < 0.1, "took {took}, planned {planned}");
}

#[test]
fn the_planned_peak_of_a_series_is_within_a_tenth_of_the_measured_one() {
    let (took, planned) = measured("memory::measure_series", "");
    assert!((planned / took - 1.0).abs() < 0.1, "took {took}, planned {planned}");
}
