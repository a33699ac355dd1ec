//! What the built-in presets make at 128 texels, byte by byte: before encoding, and as PNG files.
//!
//! After a change that is meant to change it, `UPDATE_GOLDEN=1 cargo test --test suite golden` writes the new values
//! (and fails, so that it cannot stay on by mistake). `tests/golden/planes_128.txt` is also what
//! `examples/golden_planes.rs` prints on other machines.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use ophidian::base::MapKind;
use ophidian::io::{Manifest, WriteOptions, write_set};
use ophidian::maps::plane_hash;
use ophidian::preset::builtin::BUILTIN;
use rayon::prelude::*;

use crate::made;

/// The two texts, in the form that `b3sum` prints: hash, two spaces, name.
static MADE: LazyLock<[String; 2]> = LazyLock::new(|| {
    let of_one: Vec<[String; 2]> = BUILTIN.par_iter().map(|(name, _)| one(name)).collect();
    [0, 1].map(|i| of_one.iter().map(|texts| texts[i].as_str()).collect())
});

fn one(name: &str) -> [String; 2] {
    let graph = made::graph(name, &[]);
    let set = made::make(&graph, &MapKind::ALL, made::domain(&graph, 128));
    let mut planes = String::new();
    for (kind, map) in &set.maps {
        let hash: String = plane_hash(map).iter().map(|b| format!("{b:02x}")).collect();
        planes.push_str(&format!("{hash}  {name} {kind}\n"));
    }
    let dir = tempfile::tempdir().expect("a folder");
    write_set(&set, dir.path(), &WriteOptions::default(), &|_| {}).expect("files");
    let manifest = Manifest::read(dir.path()).expect("a manifest");
    let files = manifest.sets[0].files.iter().map(|f| format!("{}  {}\n", f.blake3, f.file)).collect();
    [planes, files]
}

fn hold(file: &str, made: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(file);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("tests/golden");
        std::fs::write(&path, made).expect("a golden file");
        panic!("{} is written anew; run again without UPDATE_GOLDEN", path.display());
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    let told = differences(&golden, made);
    assert!(
        told.is_empty(),
        "{} lines of {file} differ:\n{}\nif they should: UPDATE_GOLDEN=1 cargo test --test suite golden",
        told.len(),
        told[..told.len().min(12)].join("\n")
    );
}

/// Names whose hashes differ, or that only one of the two has.
fn differences(golden: &str, made: &str) -> Vec<String> {
    let parse = |text| -> BTreeMap<String, String> {
        let pair = |line: &str| line.split_once("  ").map(|(hash, name)| (name.into(), hash.into()));
        str::lines(text).filter_map(pair).collect()
    };
    let (golden, made) = (parse(golden), parse(made));
    let mut told: Vec<String> = Vec::new();
    for (name, hash) in &made {
        match golden.get(name) {
            Some(known) if known == hash => {}
            Some(_) => told.push(format!("changed {name}")),
            None => told.push(format!("new     {name}")),
        }
    }
    told.extend(golden.keys().filter(|name| !made.contains_key(*name)).map(|n| format!("gone    {n}")));
    told
}

#[test]
fn planes_are_the_golden_ones() {
    hold("planes_128.txt", &MADE[0]);
}

#[test]
fn files_are_the_golden_ones() {
    hold("files_128.txt", &MADE[1]);
}

#[test]
fn the_comparison_tells_changed_new_and_gone() {
    let golden = "aa  boa color\nbb  boa height\ncc  boa normal\n";
    assert!(differences(golden, golden).is_empty());
    let made = "aa  boa color\nbc  boa height\ndd  boa roughness\n";
    assert_eq!(
        differences(golden, made),
        ["changed boa height", "new     boa roughness", "gone    boa normal"]
    );
}
