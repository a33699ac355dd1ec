//! The command from outside: codes, messages, files.

use std::collections::BTreeMap;
use std::path::Path;

use assert_cmd::Command;
use ophidian::base::simd;

/// The command, with nothing of the caller's environment that changes what it does.
pub(crate) fn ophidian() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ophidian"));
    for name in ["OPHIDIAN_SIMD", "OPHIDIAN_THREADS", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    command.env("NO_COLOR", "1");
    command
}

/// A preset that reads neighbours, whole planes and randomness.
const PRESET: &str = r##"
description = "for tests"
[tile]
girth_mm = 30
length_mm = 60
[nodes.cells]
op = "worley"
[nodes.clouds]
op = "fractal"
[nodes.soft]
op = "gaussian_blur"
image = "clouds"
[nodes.even]
op = "normalise"
image = "soft"
[nodes.mixed]
op = "mix"
a = "#9C3B24"
b = "#14110F"
mask = "even"
[nodes.bumps]
op = "multiply"
a = "cells"
b = 0.2
[nodes.normal]
op = "height_to_normal"
height = "bumps"
[maps]
color = "mixed"
height = "bumps"
normal = "normal"
roughness = 0.5
pattern_mask = "even"
"##;

struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

fn run(command: &mut Command) -> Run {
    let output = command.output().expect("the command starts");
    Run {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).expect("UTF-8"),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// A folder with `snake.toml` in it.
fn folder(text: impl AsRef<[u8]>) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("snake.toml"), text).expect("written");
    dir
}

fn in_folder(dir: &tempfile::TempDir, args: &[&str]) -> Run {
    run(ophidian().current_dir(dir.path()).args(args))
}

/// Every file below a folder, by name.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(dir) else { return BTreeMap::new() };
    let mut all = BTreeMap::new();
    for entry in entries {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("UTF-8");
        if entry.path().is_dir() {
            all.extend(files(&entry.path()).into_iter().map(|(n, b)| (format!("{name}/{n}"), b)));
        } else {
            all.insert(name, std::fs::read(entry.path()).expect("read"));
        }
    }
    all
}

/// It ends with `code`, says each of `texts`, and leaves nothing but the preset.
#[track_caller]
fn refused(dir: &tempfile::TempDir, args: &[&str], code: i32, texts: &[&str]) {
    let before = files(dir.path());
    let run = in_folder(dir, args);
    assert_eq!(run.code, Some(code), "{args:?}\n{}", run.err);
    for text in texts {
        assert!(run.err.contains(text), "{args:?} does not say {text:?} but\n{}", run.err);
    }
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert!(files(dir.path()) == before, "{args:?} left {:?}", files(dir.path()).keys());
}

/// Every node and file is in both, and no byte of a set depends on them.
#[test]
fn a_trace_and_the_stats_tell_of_all_work_and_change_no_file() {
    let dir = folder(PRESET);
    let plain = in_folder(&dir, &["generate", "snake.toml", "--size", "64", "-o", "plain"]);
    let told = [
        "generate",
        "snake.toml",
        "--size",
        "64",
        "-o",
        "told",
        "--trace",
        "trace.json",
        "--stats",
        "--json",
    ];
    let told = in_folder(&dir, &told);
    assert_eq!((plain.code, told.code, told.err.as_str()), (Some(0), Some(0), ""));
    let [plain, same] = ["plain", "told"].map(|name| files(&dir.path().join(name)));
    assert!(plain == same && plain.len() == 6, "{:?} {:?}", plain.keys(), same.keys());

    let text = std::fs::read_to_string(dir.path().join("trace.json")).expect("a trace");
    let trace: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let object: serde_json::Value = serde_json::from_str(&told.out).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("a list");
    let in_trace = |kind: &str, name: &str| events.iter().any(|e| e["cat"] == kind && e["name"] == name);
    let nodes = object["stats"]["nodes"].as_array().expect("a list");
    for node in ["cells", "clouds", "soft", "even", "mixed", "bumps", "normal"] {
        assert!(in_trace("node", node), "{node}");
        assert!(nodes.iter().any(|n| n["node"] == node && n["ms"].as_f64() > Some(0.0)), "{node}");
    }
    for file in plain.keys().filter(|name| name.ends_with(".png")) {
        assert!(in_trace("encode", file) && in_trace("write", file), "{file}");
    }
    assert!(!in_trace("node", "snake_color.png"), "kinds are told apart");

    refused(
        &dir,
        &["generate", "snake.toml", "--size", "64", "-o", "o", "--trace", "none/trace.json"],
        3,
        &["none is not a directory", "somewhere else"],
    );
}

#[test]
fn a_set_is_written_verified_and_made_again() {
    let dir = folder(PRESET);
    let made = in_folder(&dir, &["generate", "snake.toml", "--size", "64", "-o", "o/p", "--verify"]);
    assert_eq!((made.code, made.err.as_str()), (Some(0), ""));
    let names: Vec<_> = files(&dir.path().join("o/p")).into_keys().collect();
    let wanted = [
        "manifest.json",
        "snake_color.png",
        "snake_height.png",
        "snake_nor_gl.png",
        "snake_pattern_mask.png",
    ];
    assert_eq!(names[..5], wanted);
    let verify = in_folder(&dir, &["verify", "o/p", "--rebuild", "--preset", "snake.toml"]);
    assert_eq!((verify.code, verify.err.as_str()), (Some(0), ""), "{}", verify.out);

    // Negative controls: another preset, a changed file, a missing file.
    let other = in_folder(
        &dir,
        &["verify", "o/p", "--rebuild", "--preset", "snake.toml", "--set", "maps.roughness=0.6"],
    );
    assert_eq!(other.code, Some(1), "{}", other.err);
    let png = dir.path().join("o/p/snake_height.png");
    let mut bytes = std::fs::read(&png).expect("read");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(&png, bytes).expect("written");
    std::fs::remove_file(dir.path().join("o/p/snake_color.png")).expect("removed");
    let verify = in_folder(&dir, &["verify", "o/p"]);
    assert_eq!(verify.code, Some(1));
    assert!(
        verify.out.contains("snake_height.png: changed") && verify.out.contains("snake_color.png: missing")
    );
    refused(&dir, &["verify", "nowhere"], 3, &["nowhere"]);
}

#[test]
fn bytes_do_not_depend_on_threads_or_instruction_set() {
    let dir = folder(PRESET);
    let make = |name: &str, args: &[&str], env: &[(&str, &str)]| {
        let mut command = ophidian();
        command.current_dir(dir.path()).args(["generate", "snake.toml", "--size", "256", "-q", "-o", name]);
        let made = run(command.args(args).envs(env.iter().copied()));
        assert_eq!((made.code, made.err.as_str()), (Some(0), ""));
        files(&dir.path().join(name))
    };
    let one = make("t1", &["--threads", "1", "--format", "png,exr,exr-layers"], &[]);
    assert_eq!(one.len(), 12);
    for threads in ["2", "7"] {
        let env = [("OPHIDIAN_THREADS", threads)];
        assert!(make(threads, &["--format", "png,exr,exr-layers"], &env) == one, "{threads} threads");
    }
    for level in simd::Level::ALL {
        let name = level.name();
        if level > simd::detected() {
            println!("SKIPPED: this machine has no {name}");
            continue;
        }
        let made = make(name, &["--format", "png,exr,exr-layers"], &[("OPHIDIAN_SIMD", name)]);
        assert!(made == one, "{name}");
    }
    // The comparison can fail: another individual differs.
    assert!(make("s1", &["--seed", "1", "--format", "png,exr,exr-layers"], &[]) != one);
}

#[test]
fn seeds_make_individuals_and_json_tells_of_each() {
    let dir = folder(PRESET);
    let args = ["generate", "snake.toml", "--size", "32x48", "--seeds", "3..5", "--maps", "color,normal"];
    let made = in_folder(&dir, &[&args[..], &["--normal", "both", "--json"]].concat());
    assert_eq!((made.code, made.err.as_str()), (Some(0), ""));
    let sets: Vec<serde_json::Value> =
        made.out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(sets.len(), 2);
    let written = files(&dir.path().join("out"));
    for (set, seed) in sets.iter().zip([3, 4]) {
        assert_eq!((&set["preset"], &set["seed"]), (&"snake".into(), &seed.into()));
        assert_eq!(set["size"], serde_json::json!([32, 48]));
        assert!(set["ms"]["evaluate"].is_number() && set["peak_bytes"].is_number());
        let listed = set["files"].as_array().expect("files");
        assert_eq!(listed.len(), 3);
        for file in listed {
            let bytes = &written[file["file"].as_str().expect("a name")];
            assert_eq!(file["bytes"], bytes.len());
            assert_eq!(file["blake3"], blake3::hash(bytes).to_hex().as_str());
        }
    }
    assert_eq!(written.len(), 7);
    assert_ne!(written["snake_3_color.png"], written["snake_4_color.png"]);
    assert_ne!(written["snake_3_nor_gl.png"], written["snake_3_nor_dx.png"]);

    // The same individual alone has the same bytes.
    in_folder(&dir, &["generate", "snake.toml", "--size", "32x48", "--seed", "4", "-o", "one", "-q"]);
    assert_eq!(files(&dir.path().join("one"))["snake_color.png"], written["snake_4_color.png"]);
}

#[test]
fn the_printed_graph_makes_the_same_files() {
    let dir = folder(PRESET);
    let graph = in_folder(&dir, &["graph", "snake.toml", "--set", "nodes.bumps.b=0.1"]);
    assert_eq!(graph.code, Some(0), "{}", graph.err);
    std::fs::write(dir.path().join("nodes.toml"), graph.out).expect("written");
    let make = |preset: &str, dir_name: &str, more: &[&str]| {
        let made = in_folder(&dir, &[&["generate", preset, "--size", "64", "-o", dir_name], more].concat());
        assert_eq!(made.code, Some(0), "{}", made.err);
        files(&dir.path().join(dir_name))
    };
    let own = make("snake.toml", "a", &["--set", "nodes.bumps.b=0.1"]);
    assert!(make("nodes.toml", "b", &[]) == own);
    assert!(make("snake.toml", "c", &[]) != own);
    for format in ["dot", "mermaid", "json"] {
        let graph = in_folder(&dir, &["graph", "snake.toml", "--format", format, "--maps", "color"]);
        assert!(graph.code == Some(0) && graph.out.contains("even"), "{format} {}", graph.err);
    }
}

#[test]
fn presets_are_named_found_and_suggested() {
    let dir = folder(PRESET);
    let list = in_folder(&dir, &["presets", "--json"]);
    let list: Vec<serde_json::Value> = serde_json::from_str(&list.out).expect("JSON");
    assert!(!list.is_empty());
    for preset in &list {
        let (name, common) = (preset["name"].as_str(), preset["common_name"].as_str());
        let common = common.expect("a common name");
        let checked = in_folder(&dir, &["check", name.expect("a name"), common]);
        assert_eq!((checked.code, checked.err.as_str()), (Some(0), ""));
        assert_eq!(checked.out.lines().count(), 2);
    }
    let missing = "did you mean `lampropeltis_triangulum`?";
    refused(&dir, &["generate", "lampropeltis_triangulun"], 2, &[missing]);
    refused(
        &dir,
        &["check", "no_such_snake"],
        2,
        &["no built-in preset `no_such_snake`", "ophidian presets"],
    );
    refused(&dir, &["generate", "sneak.toml"], 3, &["sneak.toml", "no such file"]);
    refused(&dir, &["generate", "lampropeltis_triangulum.toml"], 3, &["is named without a path"]);
    refused(&dir, &["generate", "."], 2, &["no built-in preset"]);
    refused(&dir, &["generate", "./"], 3, &["is a directory"]);
}

#[test]
fn arguments_that_cannot_be_are_refused_with_code_2() {
    let dir = folder(PRESET);
    let with = |args: &[&str], texts: &[&str]| {
        refused(&dir, &[&["generate", "snake.toml"], args].concat(), 2, texts);
    };
    with(&["--size", "0x0"], &["1 to 65536"]);
    with(&["--size", "1000000000"], &["1 to 65536"]);
    with(&["--size", "99999999999999999999999999"], &["1 to 65536"]);
    with(&["--size", "big"], &["WIDTHxHEIGHT"]);
    with(&["--maps", "colour"], &["did you mean `color`?"]);
    with(&["--maps", "iridescence"], &["has no map `iridescence`", "color, height, normal"]);
    with(&["--seeds", "5..5"], &["is empty"]);
    with(&["--seed", "1", "--seeds", "1..3"], &["cannot be used with"]);
    with(&["--seed", "-1"], &["-1"]);
    with(&["--threads", "0"], &["0"]);
    with(&["--format", "jpeg"], &["png"]);
    with(&["--memory", "lots"], &["4G"]);
    with(&["--depth", "12"], &["8 and 16"]);
    with(&["--name", "../{map}.{ext}"], &["no file name"]);
    with(&["--name", "{mapp}.{ext}"], &["unknown placeholder {mapp}"]);
    with(&["--name", "{map}.{ext}", "--seeds", "0..2"], &["{seed}"]);
    with(&["--name", "{preset}.{ext}", "--normal", "both"], &["{map}"]);
    with(&["--set", "maps.roughness"], &["has no `=`", "--set maps.roughness"]);
    with(&["--set", "maps.roughness=yes"], &["--set maps.roughness=yes:1:16"]);
    with(&["--set", "nodes.bumps.b.c=1"], &["not a table"]);
    with(&["snake.toml"], &["two presets are named `snake`"]);
    refused(&dir, &["nodes", "worly"], 2, &["did you mean `worley`?"]);
    refused(&dir, &[], 2, &["Usage"]);
    refused(&dir, &["make"], 2, &["make"]);
    let forced = run(ophidian().env("OPHIDIAN_SIMD", "mmx").current_dir(dir.path()).args(["nodes"]));
    assert_eq!(forced.code, Some(2));
    assert!(forced.err.contains("baseline, avx2, avx512"), "{}", forced.err);
}

#[test]
fn one_bad_preset_of_many_stops_all_before_anything_is_written() {
    let dir = folder(PRESET);
    std::fs::write(dir.path().join("bad.toml"), "sed = 3\n").expect("written");
    refused(&dir, &["generate", "snake.toml", "bad.toml"], 2, &["unknown key `sed`", "did you mean `seed`?"]);
    refused(&dir, &["generate", "bad.toml", "none.toml"], 3, &["unknown key `sed`", "none.toml"]);
}

#[test]
fn more_memory_than_allowed_is_refused_with_the_numbers() {
    let dir = folder(PRESET);
    let args = ["generate", "snake.toml", "--size", "16384", "--format", "png,exr", "--memory", "64M"];
    refused(&dir, &args, 4, &["8192 x 16384", "may use 64 MiB", "--memory"]);
    // PNG files alone can be made a few rows at a time, but not of nothing.
    let args = ["generate", "snake.toml", "--size", "16384", "--memory", "1M"];
    refused(&dir, &args, 4, &["8192 x 16384", "may use 1 MiB", "--memory"]);
}

#[test]
fn output_that_cannot_be_written_ends_with_code_3() {
    let dir = folder(PRESET);
    std::fs::write(dir.path().join("file"), "").expect("written");
    let with = |out: &str, texts: &[&str]| {
        refused(&dir, &["generate", "snake.toml", "--size", "16", "-o", out], 3, texts);
    };
    with("file", &["file: not a directory"]);
    with("file/below", &["file/below: not a directory"]);
    std::fs::create_dir_all(dir.path().join("o/snake_color.png")).expect("made");
    with("o", &["snake_color.png: is a directory"]);
    std::fs::create_dir(dir.path().join("m")).expect("made");
    std::fs::write(dir.path().join("m/manifest.json"), "{").expect("written");
    let run = in_folder(&dir, &["generate", "snake.toml", "--size", "16", "-o", "m"]);
    assert_eq!(run.code, Some(3));
    assert!(run.err.contains("manifest"), "{}", run.err);
    assert_eq!(std::fs::read(dir.path().join("m/manifest.json")).expect("read"), b"{");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let locked = dir.path().join("locked");
        std::fs::create_dir(&locked).expect("made");
        std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).expect("set");
        if std::fs::write(locked.join("x"), "").is_ok() {
            println!("SKIPPED: this user may write into read-only directories");
            std::fs::remove_file(locked.join("x")).expect("removed");
        } else {
            with("locked", &["permission denied or read-only"]);
        }
    }
}

#[test]
fn nonsense_is_refused_with_line_and_column() {
    let of = |text: &[u8], texts: &[&str]| {
        refused(&folder(text), &["generate", "snake.toml", "--size", "16"], 2, texts);
    };
    of(b"a = \"\xff\"", &["snake.toml:1:6", "not UTF-8"]);
    of(&[0; 4096], &["snake.toml:1:1"]);
    of(&b"x".repeat(1 << 20), &["snake.toml:1:"]);
    of(&b"a = [".repeat(10_000), &["snake.toml:1:", "nested"]);
    of(format!("x = {}1{}", "{a = ".repeat(9_000), "}".repeat(9_000)).as_bytes(), &["nested"]);
    of(format!("[{}]", "a.".repeat(5_000) + "a").as_bytes(), &["nested"]);
    of(&b"[nodes.a]\n".repeat(50_000), &["snake.toml:2:", "more syntax errors"]);
    of(&b"nonsense ".repeat(8 << 17), &["9437184 bytes"]);
    of(b"", &["has no maps"]);
    // A million scales is a number like any other: planned, refused or made, never a panic.
    let many = "[nodes.a]\nop = 'worley'\ncells_u = 1000000\n[maps]\nheight = 'a'";
    of(many.as_bytes(), &["cells_u = 1000000 is out of range"]);
}

#[test]
fn help_version_and_completions_are_no_errors() {
    for args in
        [&["--help"][..], &["generate", "--help"], &["--version"], &["completions", "bash"], &["schema"]]
    {
        let shown = run(ophidian().args(args));
        assert_eq!((shown.code, shown.err.as_str()), (Some(0), ""), "{args:?}");
        assert!(shown.out.contains("ophidian") || args == ["schema"], "{args:?}");
    }
    let help = run(ophidian().args(["generate", "--help"])).out;
    assert!(help.contains("Exit codes:") && help.contains("Examples:"));
    let schema: serde_json::Value = serde_json::from_str(&run(ophidian().arg("schema")).out).expect("JSON");
    assert!(schema["properties"]["nodes"].is_object());
    assert!(run(ophidian().arg("nodes")).out.contains("gaussian_blur"));
    assert!(run(ophidian().args(["nodes", "gaussian_blur"])).out.contains("# gaussian_blur"));
}

#[test]
fn what_a_file_cannot_hold_is_warned_of() {
    let dir = folder("[maps]\nheight = 3\n");
    let made = in_folder(&dir, &["generate", "snake.toml", "--size", "8"]);
    assert_eq!(made.code, Some(0));
    assert!(
        made.err.contains("height goes from 3.0000 to 3.0000 mm") && made.err.contains("range = ["),
        "{}",
        made.err
    );
    let range = "maps.height={from = 3, range = [0, 4]}";
    let made = in_folder(&dir, &["generate", "snake.toml", "--size", "8", "--set", range]);
    assert_eq!((made.code, made.err.as_str()), (Some(0), ""));
}

/// The window is opt-in: the verb is there, and says how to get it.
#[cfg(not(feature = "viewer"))]
#[test]
fn a_build_without_the_window_says_how_to_get_it() {
    let dir = folder(PRESET);
    refused(&dir, &["view", "snake.toml"], 2, &["this build of ophidian has no window", "--features viewer"]);
}
