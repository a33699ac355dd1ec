//! Maps that nobody asks for cost nothing: no steps, no memory.

use std::collections::BTreeSet;

use ophidian::base::MapKind;
use ophidian::graph::{Graph, to_toml};
use ophidian::plan::Plan;
use ophidian::preset::builtin::BUILTIN;

use crate::made;

fn plan(name: &str, wanted: &[MapKind]) -> Plan {
    let graph = made::graph(name, &[]);
    Plan::new(&graph, wanted, made::domain(&graph, 2048), None).expect("a plan")
}

fn names(plan: &Plan) -> BTreeSet<&str> {
    plan.steps.iter().map(|s| s.name.as_str()).collect()
}

/// Steps that only make colour, gloss, film or what follows from the height.
fn is_no_part_of_height(name: &str) -> bool {
    let whole =
        ["color", "normal", "ambient_occlusion", "curvature", "translucency", "position", "scute_mask"];
    let starts = ["ground", "belly", "roughness", "film", "pattern", "vary", "quantise"];
    let ends = ["_mark", "_marks", "_mark_cut", "_outline", "_outline_cut", "_inner", "_halo", "_union"];
    whole.contains(&name)
        || starts.iter().any(|s| name.starts_with(s))
        || ends.iter().any(|e| name.ends_with(e))
}

#[test]
fn height_alone_plans_no_step_of_other_maps() {
    for (name, _) in BUILTIN {
        let (height, all) = (plan(name, &[MapKind::Height]), plan(name, &MapKind::ALL));
        let stray: Vec<_> = names(&height).into_iter().filter(|n| is_no_part_of_height(n)).collect();
        assert!(stray.is_empty(), "{name}: {stray:?}");
        assert!(names(&height).is_subset(&names(&all)) && height.steps.len() < all.steps.len(), "{name}");
        let others = names(&all).into_iter().filter(|n| is_no_part_of_height(n)).count();
        assert!(others >= 5, "{name}: the list knows {others} of {:?}", names(&all));
        assert!(height.peak_bytes < all.peak_bytes, "{name}: {} bytes", height.peak_bytes);
        assert!(height.cost_ms() < all.cost_ms(), "{name}: {} ms", height.cost_ms());
    }
}

/// Whatever the maps, the plan is what they need between them and no more.
#[test]
fn steps_of_several_maps_are_the_union_of_those_of_each() {
    for (name, _) in BUILTIN {
        let mut union = BTreeSet::new();
        for kind in MapKind::ALL {
            union.extend(names(&plan(name, &[kind])).into_iter().map(str::to_owned));
        }
        let all = plan(name, &MapKind::ALL);
        assert_eq!(union.iter().map(String::as_str).collect::<BTreeSet<_>>(), names(&all), "{name}");
    }
}

#[test]
fn a_map_that_is_one_number_has_no_steps() {
    let film = plan("lampropeltis_triangulum", &[MapKind::Iridescence]);
    assert!(film.steps.is_empty(), "{:?}", names(&film));
    // One plane, which holds the number.
    assert_eq!(film.peak_bytes, 4 * film.domain.texels() as u64);
    assert!(!plan("xenopeltis_unicolor", &[MapKind::Iridescence]).steps.is_empty());
}

/// The same graph with all noise computed everywhere and all distances told, and with noise hardly anywhere; `None` where it
/// has no bounds.
fn other_bounds(graph: &Graph) -> Option<[Graph; 2]> {
    let text = to_toml(graph);
    let key = |line: &str| line.split(" = ").next().unwrap_or(line).to_owned();
    let is_bound = |line: &&str| ["where", "above", "below", "farthest"].contains(&key(line).as_str());
    let lines = || text.lines();
    let everywhere: Vec<_> = lines().filter(|line| !is_bound(line)).collect();
    let nowhere: Vec<_> =
        lines().map(|line| if key(line) == "below" { "below = -1e8" } else { line }).collect();
    (everywhere.len() < lines().count()).then(|| [everywhere, nowhere].map(|l| made::parse(&l.join("\n"))))
}

/// Colours are the same where the noise of outlines and bellies is computed only where it shows; without it they are not.
#[test]
fn noise_is_left_out_where_no_map_shows_it() {
    let wanted = [MapKind::Color, MapKind::Roughness, MapKind::PatternMask];
    let (mut found, mut noisy) = (0, 0);
    for (name, _) in BUILTIN {
        let graph = made::graph(name, &[]);
        let Some([everywhere, nowhere]) = other_bounds(&graph) else { continue };
        found += 1;
        let domain = made::domain(&graph, 160);
        let wanted: Vec<_> = wanted.into_iter().filter(|kind| graph.maps.contains_key(kind)).collect();
        let (ours, all) = (made::planes(&graph, &wanted, domain), made::planes(&everywhere, &wanted, domain));
        for kind in &wanted {
            assert!(ours[kind] == all[kind], "{name}: {kind}");
        }
        noisy += usize::from(made::planes(&nowhere, &wanted, domain) != ours);
    }
    assert!(found >= 10 && noisy >= 10, "{found} presets leave noise out, {noisy} have some");
}
