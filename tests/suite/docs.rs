//! What the documents say is so: the schema is current, the README's presets are sound and its tables complete.

use std::fmt::Write as _;
use std::path::Path;

use ophidian::base::MapKind;
use ophidian::graph;
use ophidian::preset::builtin;

use super::cli::ophidian;

const README: &str = include_str!("../../README.md");

#[test]
fn the_schemas_in_docs_are_what_the_command_prints() {
    let mut rewritten = Vec::new();
    for (file, args) in
        [("preset.schema.json", &["schema"][..]), ("scene.schema.json", &["schema", "--scene"])]
    {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(file);
        let output = ophidian().args(args).output().expect("the command runs");
        let schema = String::from_utf8(output.stdout).expect("UTF-8");
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(&path, &schema).expect("docs/ can be written");
            rewritten.push(file);
        }
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            text == schema,
            "docs/{file} is old: UPDATE_GOLDEN=1 cargo test the_schemas_in_docs rewrites it"
        );
    }
    assert!(
        rewritten.is_empty(),
        "{rewritten:?} were rewritten: look at the difference, then run again without UPDATE_GOLDEN"
    );
}

#[test]
fn every_preset_and_scene_in_the_readme_is_sound_and_makes_something() {
    let blocks: Vec<&str> =
        README.split("```toml\n").skip(1).filter_map(|text| text.split("```").next()).collect();
    assert!(blocks.len() >= 4, "{}", blocks.len());
    for block in blocks {
        let dir = tempfile::tempdir().expect("a directory");
        std::fs::write(dir.path().join("snake.toml"), block).expect("a file");
        let args: &[&str] = if block.starts_with("#:schema docs/scene") {
            &[
                "render",
                "python_regius",
                "--scene",
                "snake.toml",
                "--map-size",
                "32",
                "--size",
                "8x6",
                "--spp",
                "1",
                "--quiet",
            ]
        } else {
            &["generate", "snake.toml", "--size", "64", "--quiet"]
        };
        let output = ophidian().current_dir(dir.path()).args(args).output().expect("the command runs");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{text}\n{block}");
    }
}

#[test]
fn the_readme_lists_every_preset_map_and_exit_code() {
    for kind in MapKind::ALL {
        assert!(README.contains(&format!("| `{kind}` ")), "no row for the map {kind}");
    }
    let mut rows = String::new();
    for (name, _) in builtin::BUILTIN {
        let document = builtin::document(name).expect("a built-in preset");
        let common = graph::about(&document, "common_name").expect("a common name");
        let class = document.root.get("pattern").and_then(|p| p.get_ref().as_table()?.get("class"));
        let class = class.and_then(|c| c.get_ref().as_str()).unwrap_or("solid").replace('_', " ");
        writeln!(rows, "| `{name}` | {common} | {class} |").expect("a string takes text");
    }
    assert!(README.contains(&rows), "the table of presets should be\n{rows}");
    let help = ophidian().arg("--help").output().expect("the command runs").stdout;
    let help = String::from_utf8(help).expect("UTF-8");
    let codes = help.split("Exit codes:\n").nth(1).expect("the help tells the codes");
    for (code, meaning) in codes.lines().filter_map(|line| line.trim().split_once(' ')) {
        let meaning = meaning.trim();
        let row = |line: &str| line.replace('`', "") == format!("| {code} | {meaning} |").replace('`', "");
        assert!(README.lines().any(row), "no row for {code}: {meaning}");
    }
}

#[test]
fn every_file_that_the_readme_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let links = README.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    // Pictures are no part of the package: `examples/contact_sheet.rs` makes them.
    let here = |l: &&str| !l.starts_with("http") && !l.starts_with('#') && !l.ends_with(".jpg");
    for link in links.filter(here) {
        assert!(root.join(link).exists(), "{link}");
    }
}
