//! Who may import whom: one package cannot forbid an import cycle, so this test reads the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Each room and the rooms that it may import; `base` may be imported by all. The ground floor comes first, and a
/// room may only name rooms above its own line, so that there can be no cycle.
const ROOMS: &[(&str, &[&str])] = &[
    ("base", &[]),
    ("optics", &[]),
    ("node", &[]),
    ("preset", &[]),
    ("skin", &["node"]),
    ("graph", &["optics", "node", "preset", "skin"]),
    ("plan", &["node", "graph"]),
    ("eval", &["node", "plan"]),
    ("maps", &["optics", "graph", "eval"]),
    // Files become textures of a graph, too.
    ("io", &["optics", "node", "maps"]),
    ("export", &["maps", "io"]),
    ("scene", &["optics", "preset", "maps"]),
    ("preview", &["optics", "scene"]),
    ("viewer", &["preset", "graph", "plan", "eval", "maps", "scene", "preview"]),
    ("reference", &["optics", "scene"]),
    ("report", &["optics", "node", "graph", "plan", "eval", "maps", "io", "scene", "preview", "reference"]),
    // The attic imports everything and is imported by nothing.
    (
        "cli",
        &[
            "optics",
            "node",
            "preset",
            "skin",
            "graph",
            "plan",
            "eval",
            "maps",
            "io",
            "export",
            "scene",
            "preview",
            "viewer",
            "reference",
            "report",
        ],
    ),
];

/// Words that only rooms which touch the machine may say.
const MACHINE: &[&str] = &[
    "std::fs",
    "std::env",
    "std::time",
    "std::process",
    "Instant::now",
    "SystemTime",
    "available_parallelism",
];

/// Where they may: rooms, and files by name.
const MAY_TOUCH: &[&str] = &["io", "cli", "export", "report", "viewer", "preview", "main.rs"];

#[test]
fn every_import_follows_the_table() {
    let problems = imports(&sources());
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

#[test]
fn files_environment_and_clocks_stay_in_their_rooms() {
    let problems = machine(&sources());
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

#[test]
fn the_table_has_no_cycle_and_names_every_room() {
    let mut known = BTreeSet::from(["base"]);
    for (room, may) in ROOMS {
        for other in *may {
            assert!(known.contains(other), "{room} may import {other}, which stands below it");
        }
        known.insert(room);
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(root).expect("src").flatten() {
        let name = entry.file_name().to_string_lossy().trim_end_matches(".rs").to_owned();
        let is_room = !["main", "lib"].contains(&name.as_str());
        assert!(!is_room || known.contains(name.as_str()), "src/{name} is not in the table");
    }
}

/// What the readers above must find, and what they must not.
#[test]
fn the_reader_finds_what_breaks_the_table() {
    let broken = [
        ("base/a.rs", "use crate::node::Spec;"),
        ("node/b.rs", "fn f() { let x = crate::preset::suggest::nearest(); }"),
        (
            "plan/c.rs",
            "use crate::{\n    base::Domain,\n    graph::{Graph, Source},\n    io::{png, exr},\n};",
        ),
        ("maps/d.rs", "use super::super::cli;"),
        ("graph/mod.rs", "pub use super::eval::run;"),
        ("eval/e.rs", "fn f() -> std::time::Duration { todo() }"),
    ];
    let broken: BTreeMap<String, String> =
        broken.iter().map(|(p, t)| ((*p).to_owned(), (*t).to_owned())).collect();
    assert_eq!(
        imports(&broken),
        [
            "src/base/a.rs:1: base imports node",
            "src/graph/mod.rs:1: graph imports eval",
            "src/maps/d.rs:1: maps imports cli",
            "src/node/b.rs:1: node imports preset",
            "src/plan/c.rs:4: plan imports io",
        ]
    );
    assert_eq!(machine(&broken), ["src/eval/e.rs:1: eval says std::time"]);
    let fine = [
        (
            "node/a.rs",
            "//! See [`crate::eval::run`].\n/* crate::io */ use crate::base::{num, hash}; use crate::multiversion;",
        ),
        ("node/b.rs", "const TEXT: &str = \"crate::eval \\\" crate::io\"; use super::super::node::Spec;"),
        (
            "eval/c.rs",
            "use crate::plan::{self, Plan};\n#[cfg(test)]\nmod tests { use crate::graph; use std::time::Instant; }",
        ),
    ];
    let fine: BTreeMap<String, String> =
        fine.iter().map(|(p, t)| ((*p).to_owned(), (*t).to_owned())).collect();
    assert_eq!(imports(&fine), [""; 0]);
    assert_eq!(machine(&fine), [""; 0]);
}

/// Every source by its path below `src/`.
fn sources() -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = BTreeMap::new();
    let mut open: Vec<PathBuf> = vec![root.clone()];
    while let Some(dir) = open.pop() {
        for entry in std::fs::read_dir(&dir).expect("a folder of sources").flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("a source is UTF-8");
                let name = path.strip_prefix(&root).expect("below src").to_string_lossy().replace('\\', "/");
                found.insert(name, text);
            }
        }
    }
    assert!(found.len() > 20, "the sources were not found");
    found
}

/// Files that a `#[cfg(test)] mod name;` declares.
fn test_files(sources: &BTreeMap<String, String>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (path, text) in sources {
        let folder = match path.rsplit_once('/') {
            Some((folder, "mod.rs")) => format!("{folder}/"),
            _ => format!("{}/", path.trim_end_matches(".rs")),
        };
        for item in text.split("#[cfg(test)]").skip(1) {
            let declared = item.split([';', '{']).next().and_then(|head| head.rsplit_once("mod "));
            if let Some((_, name)) = declared {
                found.insert(format!("{folder}{}.rs", name.trim()));
            }
        }
    }
    found
}

fn room_of(path: &str) -> &str {
    path.split('/').next().unwrap_or(path).trim_end_matches(".rs")
}

fn imports(sources: &BTreeMap<String, String>) -> Vec<String> {
    let mut problems = Vec::new();
    let tests = test_files(sources);
    for (path, text) in sources {
        let room = room_of(path);
        let Some((_, may)) = ROOMS.iter().find(|(name, _)| *name == room) else { continue };
        if tests.contains(path) {
            continue;
        }
        let text = code(text);
        for (at, other) in roots(&text, depth(path)) {
            let is_room = ROOMS.iter().any(|(name, _)| *name == other);
            if is_room && other != room && other != "base" && !may.contains(&other.as_str()) {
                let line = text[..at].matches('\n').count() + 1;
                problems.push(format!("src/{path}:{line}: {room} imports {other}"));
            }
        }
    }
    problems
}

fn machine(sources: &BTreeMap<String, String>) -> Vec<String> {
    let mut problems = Vec::new();
    let tests = test_files(sources);
    for (path, text) in sources {
        let room = room_of(path);
        if tests.contains(path) || MAY_TOUCH.contains(&room) || MAY_TOUCH.contains(&path.as_str()) {
            continue;
        }
        let text = code(text);
        for word in MACHINE {
            for (at, _) in text.match_indices(word) {
                let line = text[..at].matches('\n').count() + 1;
                problems.push(format!("src/{path}:{line}: {room} says {word}"));
            }
        }
    }
    problems
}

/// Modules between a file and the crate's root.
fn depth(path: &str) -> usize {
    path.split('/').filter(|part| *part != "mod.rs").count()
}

/// The first segments after `crate::` (and after as many `super::` as lead to the root), each with its place.
fn roots(text: &str, depth: usize) -> Vec<(usize, String)> {
    let mut starts: Vec<usize> = text.match_indices("crate::").map(|(i, m)| i + m.len()).collect();
    let up = "super::".repeat(depth);
    let further = |i: usize| text[..i].ends_with("super::") || text[i..].starts_with(&format!("{up}super::"));
    starts.extend(text.match_indices(&up).filter(|(i, _)| !further(*i)).map(|(i, m)| i + m.len()));
    starts.sort_unstable();
    starts.into_iter().flat_map(|start| segments(text, start)).collect()
}

/// The segment at `start`, or each first segment of a `{…}` there.
fn segments(text: &str, start: usize) -> Vec<(usize, String)> {
    let word = |at: usize| -> String {
        text[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    if !text[start..].starts_with('{') {
        return vec![(start, word(start))];
    }
    let mut found = Vec::new();
    let mut level = 0;
    let mut fresh = false;
    for (i, c) in text[start..].char_indices() {
        match c {
            '{' => {
                level += 1;
                fresh = level == 1;
            }
            '}' => {
                level -= 1;
                if level == 0 {
                    break;
                }
            }
            ',' if level == 1 => fresh = true,
            c if fresh && !c.is_whitespace() => {
                found.push((start + i, word(start + i)));
                fresh = false;
            }
            _ => {}
        }
    }
    found
}

/// The text without comments, strings and what is only for tests; line breaks stay.
fn code(text: &str) -> String {
    let text = plain(text);
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..at]);
        let item = &rest[at..];
        let mut level = 0;
        let end = item.find(|c| {
            level += i32::from(c == '{') - i32::from(c == '}');
            level == 0 && (c == '}' || c == ';')
        });
        let end = end.map_or(item.len(), |i| i + 1);
        out.extend(item[..end].chars().filter(|c| *c == '\n'));
        rest = &item[end..];
    }
    out + rest
}

/// The text without comments and strings.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let skip = |out: &mut String, skipped: &str| out.extend(skipped.chars().filter(|c| *c == '\n'));
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |i| i + 2)
        } else if rest.starts_with("r#\"") || rest.starts_with("r##\"") {
            let end = if rest.starts_with("r##") { "\"##" } else { "\"#" };
            rest[4..].find(end).map_or(rest.len(), |i| i + 4 + end.len())
        } else if c == '"' {
            let mut escaped = false;
            let end = rest[1..].find(|c| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            end.map_or(rest.len(), |i| i + 2)
        } else if ["'\"'", "'{'", "'}'", "';'"].iter().any(|c| rest.starts_with(c)) {
            3
        } else {
            0
        };
        if length == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        } else {
            skip(&mut out, &rest[..length]);
            rest = &rest[length..];
        }
    }
    out
}
