//! What a plan says it takes is what its evaluation takes, within 10 %.
//!
//! Resident memory is the whole process's, so each measurement runs in a process of its own: this test binary again,
//! with one ignored test.
#![cfg(target_os = "linux")]

use std::process::Command;

use ophidian::base::MapKind;
use ophidian::eval::{Control, run};
use ophidian::graph::Graph;
use ophidian::plan::Plan;
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

#[test]
fn the_planned_peak_is_within_a_tenth_of_the_measured_one() {
    for (name, ..) in cases() {
        let output = Command::new(std::env::current_exe().expect("a path"))
            .args(["memory::measure", "--exact", "--ignored", "--nocapture"])
            .env("OPHIDIAN_TEST_CASE", name)
            .output()
            .expect("the test binary runs");
        let text = String::from_utf8_lossy(&output.stdout);
        let line = text.lines().find(|line| line.contains("took ")).unwrap_or_else(|| panic!("{text}"));
        let words: Vec<&str> = line[line.find("took").unwrap_or(0)..].split_whitespace().collect();
        let number = |i: usize| words[i].parse::<f64>().expect("a number");
        let (took, planned) = (number(1), number(3));
        assert!((planned / took - 1.0).abs() < 0.1, "{name}: took {took}, planned {planned}");
    }
}
