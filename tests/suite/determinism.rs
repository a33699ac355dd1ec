//! The same bytes whatever the number of threads and the instruction set.

use std::collections::BTreeMap;
use std::sync::PoisonError;

use ophidian::base::MapKind;
use ophidian::base::simd::{self, Level};
use ophidian::graph::Graph;
use ophidian::maps::plane_hash;

use crate::made;

type Hashes = BTreeMap<MapKind, [u8; 32]>;

fn hashes(graph: &Graph, threads: usize) -> Hashes {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let set = pool.install(|| made::make(graph, &MapKind::ALL, made::domain(graph, 256)));
    set.maps.iter().map(|(kind, map)| (*kind, plane_hash(map))).collect()
}

/// A rainbow boa: marks of several kinds, film, keels, belly; nearly every operation that presets use.
#[test]
fn threads_and_instruction_sets_change_no_byte() {
    let _alone = made::LEVEL.lock().unwrap_or_else(PoisonError::into_inner);
    let graph = made::graph_with_film("epicrates_cenchria");
    simd::force(Level::Baseline);
    let reference = hashes(&graph, 1);
    assert_eq!(reference.len(), MapKind::ALL.len());
    for level in Level::ALL {
        if level > simd::detected() {
            println!("SKIPPED: this machine has no {}", level.name());
            continue;
        }
        assert_eq!(simd::force(level), level);
        for threads in [1, 2, 7] {
            assert_eq!(hashes(&graph, threads), reference, "{} on {threads} threads", level.name());
        }
        assert_eq!(simd::level(), level, "another test forced a level meanwhile");
    }
    simd::force(simd::detected());

    // The comparison can fail: another individual differs in every map.
    let other = hashes(&graph.clone().with_seed(graph.seed + 1), 2);
    for (kind, hash) in &reference {
        assert_ne!(hash, &other[kind], "{kind}");
    }
}
