use super::*;
use crate::plan::Plan;
use crate::preset::{Document, builtin};

fn built_in(name: &str) -> Graph {
    crate::graph::from_document(&builtin::document(name).expect("a built-in preset"), None).expect("sound")
}

fn written(text: &str) -> Graph {
    crate::graph::from_document(&Document::parse("test.toml", text).expect("TOML"), None).expect("sound")
}

fn subject(graph: &Graph) -> Subject<'_> {
    let wanted = graph.maps.keys().copied().collect();
    let domain = Domain::from_longer_side(96, graph.girth_mm, graph.length_mm);
    Subject { graph, wanted, domain, rounds: 1 }
}

fn one_thread<T: Send>(f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread").install(f)
}

/// The formulas are written without a look at the kernels: that both agree checks both.
#[test]
fn formulas_and_kernels_agree_on_all_built_in_presets_but_for_rounding() {
    for (name, _) in builtin::BUILTIN.iter().step_by(3) {
        let graph = built_in(name);
        let subject = subject(&graph);
        let ours = subject.made(&graph, subject.domain, 1).expect("maps");
        let (rows, failures) = subject.arithmetic(&ours, &ours.maps());
        assert!(failures.is_empty(), "{name}: {failures:?}");
        for row in rows.iter().filter(|row| row.map.is_some()) {
            let share = page::share(row).expect("a map");
            assert!(share < 2e-4, "{name}: {row:?}");
        }
        // f32 is not f64: some map differs.
        assert!(rows.iter().any(|row| row.difference.rms > 0.0), "{name}");
    }
}

/// Negative control of the test above: a node that differs by a little is noticed.
#[test]
fn a_formula_of_something_else_is_doubted() {
    let graph = built_in("lampropeltis_triangulum");
    let mut other = graph.clone();
    let i = other.find("micro_height").expect("a node");
    let out_high = other.nodes[i].node.spec().input("out_high").expect("an input");
    if let crate::graph::Source::Scalar(v) = &mut other.nodes[i].inputs[out_high] {
        *v *= 1.5;
    }
    let subject = subject(&graph);
    let ours = subject.made(&other, subject.domain, 1).expect("maps").maps();
    let truth =
        plain::reckon::<f64>(&Plan::new(&graph, &subject.wanted, subject.domain, None).expect("a plan"));
    let found = doubts(&subject.rows(&row("arithmetic", "", ""), &ours, &truth.maps));
    assert!(found.iter().any(|f| f.starts_with("height:")), "{found:?}");
}

/// One column of ones: its box blur and its Gaussian are known.
const BLURRED: &str = r#"
[nodes.noise]
op = "white_noise"
cells_u = 96
cells_v = 96
[nodes.soft]
op = "box_blur"
image = "noise"
radius = 0.04
[maps]
height = "soft"
roughness = "noise"
"#;

#[test]
fn a_box_blur_is_held_against_a_gaussian_and_maps_without_it_are_the_same() {
    let graph = written(BLURRED);
    let subject = subject(&graph);
    let ours = subject.made(&graph, subject.domain, 1).expect("maps");
    let rows = subject.nodes(&ours, &ours.maps()).expect("rows");
    assert_eq!(rows.len(), 1, "{rows:?}");
    let (kind, _) = rows[0].map.expect("a map differs");
    assert_eq!((kind, rows[0].shortcut.as_str()), (MapKind::Height, "box blur"));
    // Of white noise of variance 1/12 blurred by weights w the variance is sum w^2 / 12, of a difference that of the
    // difference of weights; a box of 7.7 texels and a bell of 2.2 differ by about half of either.
    let blurred = (1.0f64 / 12.0).sqrt() / 7.7;
    assert!(rows[0].difference.rms > 0.2 * blurred && rows[0].difference.rms < blurred, "{rows:?}");
    assert!(rows[0].ms.is_some_and(|ms| ms > 0.0) && rows[0].exact_ms.is_some_and(|ms| ms > 0.0));
}

#[test]
fn graphs_without_approximations_have_no_rows_of_nodes() {
    let graph = written("[nodes.a]\nop = \"white_noise\"\n[maps]\nheight = \"a\"\n");
    let subject = subject(&graph);
    let ours = subject.made(&graph, subject.domain, 1).expect("maps");
    assert!(subject.nodes(&ours, &ours.maps()).expect("rows").is_empty());
}

#[test]
fn finer_occlusion_and_curvature_change_their_own_maps_only() {
    let graph = built_in("lampropeltis_triangulum");
    let subject = subject(&graph);
    let ours = subject.made(&graph, subject.domain, 1).expect("maps");
    let rows = subject.nodes(&ours, &ours.maps()).expect("rows");
    let maps: Vec<MapKind> = rows.iter().filter_map(|row| Some(row.map?.0)).collect();
    assert!(maps.iter().all(|m| [MapKind::AmbientOcclusion, MapKind::Curvature].contains(m)), "{maps:?}");
    assert!(maps.contains(&MapKind::AmbientOcclusion));
}

#[test]
fn smaller_steps_of_a_reaction_are_measured() {
    let graph = written("[nodes.a]\nop = \"gray_scott\"\ncells = 4\n[maps]\npattern_mask = \"a\"\n");
    let subject = subject(&graph);
    let ours = subject.made(&graph, subject.domain, 1).expect("maps");
    let rows = subject.nodes(&ours, &ours.maps()).expect("rows");
    assert_eq!(rows.len(), 1);
    assert!(rows[0].shortcut.starts_with("reaction") && rows[0].difference.rms > 0.0, "{rows:?}");
    assert!(rows[0].saved().is_some_and(|ms| ms > 0.0), "eight times the steps: {rows:?}");
}

#[test]
fn the_report_has_every_group_and_its_numbers() {
    let graph = built_in("python_regius");
    let domain = Domain::from_longer_side(64, graph.girth_mm, graph.length_mm);
    let report = one_thread(|| report(&graph, domain, 1, &mut |_, _| {})).expect("a report");
    assert!(report.failures.is_empty(), "{:?}", report.failures);
    let json = report.json();
    let rows = json["tables"]["approximations"].as_array().expect("rows");
    for shortcut in
        ["our kernels", "f32", "polynomials", "1/2 of", "one sample", "8 bits", "8 bits with dither"]
    {
        assert!(
            rows.iter().any(|r| r["shortcut"].as_str().is_some_and(|s| s.starts_with(shortcut))),
            "{shortcut}"
        );
    }
    let colors = rows.iter().filter(|r| r["map"] == "color");
    assert!(colors.into_iter().all(|r| r["seen"] == "dE2000"));
}
