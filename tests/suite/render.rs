//! `render` from outside: pictures, numbers beside them, messages and exit codes. Small and noisy: what the light does is
//! tested in the rooms.

use std::collections::BTreeMap;
use std::path::Path;

use ophidian::base::simd;
use ophidian::scene::builtin::BUILTIN;
use serde_json::Value;

use super::cli::ophidian;

const PRESET: &str = "lampropeltis_triangulum";

/// Few triangles, pixels and samples.
const SMALL: [&str; 7] =
    ["--size", "32x24", "--json", "--scene-set", "render.samples=1", "--scene-set", "subject.triangles=4000"];

struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

/// `args` begin with the skin; maps that are not yet made are small.
fn render(dir: &Path, args: &[&str]) -> Run {
    let made = dir.join(args[0]).is_dir();
    let texels: &[&str] = if made { &[] } else { &["--map-size", "64"] };
    let output = ophidian()
        .current_dir(dir)
        .arg("render")
        .args(SMALL)
        .args(texels)
        .args(args)
        .output()
        .expect("the command runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

/// A picture that must be made, by its channels.
fn picture(dir: &Path, args: &[&str]) -> BTreeMap<String, Vec<f32>> {
    let run = render(dir, &[args, &["-o", "a.exr"]].concat());
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{args:?}");
    channels(&dir.join("a.exr"))
}

fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    use exr::prelude::*;
    let image =
        read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(path).expect("an OpenEXR file");
    assert_eq!(image.layer_data.size, Vec2(32, 24));
    let planes = image.layer_data.channel_data.list.into_iter();
    planes.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect()
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn files(dir: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(dir).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn every_built_in_scene_gives_a_picture_its_channels_and_a_report() {
    for (scene, _) in BUILTIN {
        let dir = folder();
        let run = render(dir.path(), &[PRESET, "--scene", scene, "-o", "a.exr"]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{scene}");
        assert_eq!(files(dir.path()), ["a.exr", "a.png"]);
        let png = image::open(dir.path().join("a.png")).expect("a PNG").to_rgb8();
        assert_eq!(png.dimensions(), (32, 24));
        let planes = channels(&dir.path().join("a.exr"));
        let names: Vec<&str> = planes.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "A",
                "B",
                "G",
                "R",
                "albedo.B",
                "albedo.G",
                "albedo.R",
                "film.thickness_nm",
                "normal.X",
                "normal.Y",
                "normal.Z",
                "variance.B",
                "variance.G",
                "variance.R"
            ]
        );
        assert!(planes.values().flatten().all(|v| v.is_finite()), "{scene}");
        let color = ["R", "G", "B"].map(|c| mean(&planes[c]));
        assert!(color.iter().all(|m| *m > 1e-3), "{scene} is dark: {color:?}");
        assert!(mean(&planes["A"]) > 0.02, "{scene}: nothing is met");
        let json: Value = serde_json::from_str(&run.out).expect("one JSON object");
        assert_eq!(json["scene"], *scene);
        assert_eq!(json["skin"], PRESET);
        assert_eq!(json["size"], serde_json::json!([32, 24]));
        assert_eq!(json["samples_per_pixel"], 1.0);
        assert_eq!(json["files"], serde_json::json!(["a.exr", "a.png"]));
        for number in ["seconds", "million_samples_per_second", "standard_error", "exposure_ev"] {
            assert!(json[number].as_f64().is_some_and(f64::is_finite), "{number}");
        }
    }
}

#[test]
fn a_picture_does_not_depend_on_threads_level_or_time_but_on_its_noise() {
    let dir = folder();
    let bytes = |args: &[&str], level: simd::Level| {
        // Ten blocks of rows in the file.
        let all = [
            &["render", PRESET, "--scene", "sphere", "--size", "96x160", "--spp", "3", "--map-size", "64"],
            args,
            &["-q", "-o", "a.exr"],
        ];
        let mut command = ophidian();
        command.current_dir(dir.path()).env("OPHIDIAN_SIMD", level.name()).args(all.concat());
        let output = command.output().expect("the command runs");
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        ["a.exr", "a.png"].map(|file| std::fs::read(dir.path().join(file)).expect("a file"))
    };
    let best = simd::detected();
    let first = bytes(&["--threads", "2"], best);
    assert!(first == bytes(&["--threads", "2"], best), "a second run differs");
    assert!(first == bytes(&["--threads", "1"], best), "threads are seen");
    for level in simd::Level::ALL.into_iter().filter(|level| *level < best) {
        assert!(first == bytes(&[], level), "{} is seen", level.name());
    }
    let other = bytes(&["--noise", "1"], best);
    assert!(first[0] != other[0] && first[1] != other[1], "the noise is the same");
    assert!(first[0] != bytes(&["--seed", "99"], best)[0], "the individual is the same");
}

#[test]
fn stages_and_transports_are_told_apart() {
    let dir = folder();
    let of = |args: &[&str]| {
        let all = ["xenopeltis_unicolor", "--scene", "studio", "--spp", "4"];
        picture(dir.path(), &[&all, args].concat())
    };
    let red: Vec<Vec<f32>> = [
        &["--stage", "diffuse"],
        &["--stage", "normal"],
        &["--stage", "film"],
        &["--stage", "all"],
        &["--transport", "direct"],
        &["--transport", "direct-open"],
    ]
    .map(|args| of(args).remove("R").expect("red"))
    .into();
    for (i, a) in red.iter().enumerate() {
        assert!(red[..i].iter().all(|b| a != b), "picture {i} is another one");
    }
    // No albedo is read for the film alone; no thickness for the base alone.
    assert!(mean(&of(&["--stage", "diffuse"])["film.thickness_nm"]) == 0.0);
    assert!(mean(&of(&["--stage", "film"])["film.thickness_nm"]) > 10.0);
}

#[test]
fn a_set_gives_nearly_the_picture_of_its_preset() {
    let dir = folder();
    let preset = "epicrates_cenchria";
    let made = ophidian()
        .current_dir(dir.path())
        .args(["generate", preset, "--size", "64", "-o", "set", "--quiet"])
        .output()
        .expect("the command runs");
    assert!(made.status.success());
    let on = |skin| picture(dir.path(), &[skin, "--scene", "sphere", "--spp", "4"]);
    let (own, set) = (on(preset), on("set"));
    for channel in ["R", "G", "B"] {
        let apart: Vec<f32> = own[channel].iter().zip(&set[channel]).map(|(a, b)| (a - b).abs()).collect();
        let share = mean(&apart) / mean(&own[channel]);
        assert!(share < 0.02, "{channel}: {share}");
    }
    // Its optics come along: the set of another index is another picture.
    let manifest = std::fs::read_to_string(dir.path().join("set/manifest.json")).expect("a manifest");
    let dull = manifest.replace("\"n_layer\": 1.9", "\"n_layer\": 1.2");
    assert_ne!(manifest, dull, "the manifest tells no optics");
    std::fs::write(dir.path().join("set/manifest.json"), dull).expect("written");
    assert_ne!(on("set")["R"], set["R"]);
    // Unless the scene has its own.
    let over = |skin| {
        let args = ["--scene", "sphere", "--scene-set", "material.n_layer=1.5"];
        mean(&picture(dir.path(), &[&[skin], &args[..]].concat())["R"])
    };
    assert!((over("set") / over(preset) - 1.0).abs() < 0.02);
    // What would shape the maps of a preset is refused.
    let before = files(dir.path());
    for option in [&["--set", "body.girth=3"][..], &["--seed", "3"], &["--map-size", "32"]] {
        let run = render(dir.path(), &[&["set"], option].concat());
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{option:?}: {}", run.err);
        assert!(run.err.contains(option[0]) && run.err.contains("`set`"), "{}", run.err);
        assert_eq!(files(dir.path()), before);
    }
}

#[test]
fn a_time_that_is_over_still_gives_a_whole_picture() {
    let dir = folder();
    let args = [PRESET, "--scene", "sphere", "--spp", "64", "--budget", "0", "-o", "a.exr"];
    let run = render(dir.path(), &args);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let json: Value = serde_json::from_str(&run.out).expect("JSON");
    assert_eq!(json["samples_per_pixel"], 1.0);
    let once = picture(dir.path(), &[PRESET, "--scene", "sphere", "--spp", "1"]);
    render(dir.path(), &args);
    assert_eq!(channels(&dir.path().join("a.exr"))["R"], once["R"]);
}

#[test]
fn a_displaced_subject_is_another_form() {
    let dir = folder();
    let of = |args: &[&str]| picture(dir.path(), &[&["crotalus_atrox", "--scene", "plane"], args].concat());
    let flat = of(&[]);
    assert_ne!(flat["R"], of(&["--displace", "3"])["R"]);
    assert_eq!(of(&["--displace", "3"]), of(&["--scene-set", "subject.displacement=3"]));
    assert_eq!(flat, of(&["--displace", "0"]));
    let run = render(dir.path(), &["crotalus_atrox", "--displace", "nan"]);
    assert_eq!(run.code, Some(2), "{}", run.err);
}

const OBJ: &str = "v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\n";

#[test]
fn a_mesh_of_ones_own_is_rendered_and_others_are_refused() {
    let dir = folder();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).expect("written");
    write("good.obj", &format!("{OBJ}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"));
    write("bare.obj", &format!("{OBJ}f 1 2 3 4\n"));
    write("broken.obj", "v 1 2\nf a b c\n");
    write("broken.glb", "glTF? no");
    let own = picture(dir.path(), &[PRESET, "--scene", "plane", "--mesh", "good.obj"]);
    assert!(mean(&own["A"]) > 0.3, "{}", mean(&own["A"]));
    let refused = |mesh: &str, code: i32, what: &str| {
        let run = render(dir.path(), &[PRESET, "--mesh", mesh, "-o", "b.exr"]);
        assert_eq!(run.code, Some(code), "{mesh}: {}", run.err);
        assert!(run.err.contains(mesh) && run.err.contains(what), "{mesh}: {}", run.err);
        assert!(!dir.path().join("b.exr").exists());
    };
    refused("bare.obj", 2, "has no texture coordinates");
    refused("mesh.stl", 3, "mesh.stl");
    write("mesh.stl", "");
    refused("mesh.stl", 2, "an .obj or a .glb file");
    refused("broken.obj", 3, "not a readable OBJ file");
    refused("broken.glb", 3, "not a readable GLB file");
    refused("none.obj", 3, "none.obj");
}

#[test]
fn what_cannot_be_rendered_is_told_and_leaves_nothing() {
    let dir = folder();
    std::fs::create_dir(dir.path().join("empty")).expect("a folder");
    std::fs::write(dir.path().join("own.toml"), "include = 'coil'\ncamera.fosal_length_mm = 3\n")
        .expect("written");
    std::fs::write(dir.path().join("sky.toml"), "environment = { kind = 'picture', file = 'no.exr' }")
        .expect("written");
    let before = files(dir.path());
    for (args, code, what) in [
        (&[PRESET, "--scene", "sphare"][..], 2, "did you mean `sphere`?"),
        (&[PRESET, "--scene", "none.toml"], 3, "none.toml"),
        (&[PRESET, "--scene", "own.toml"], 2, "did you mean `focal_length_mm`?"),
        (&[PRESET, "--scene", "sky.toml"], 3, "no.exr"),
        (&[PRESET, "--scene-set", "camera.colour=3"], 2, "unknown key `colour`"),
        (&[PRESET, "--scene-set", "render.samples=0"], 2, "out of range"),
        (&["lampropeltis_triangula"], 2, "did you mean"),
        (&["empty"], 3, "manifest"),
        (&[PRESET, "-o", "a.jpg"], 2, ".exr"),
        (&[PRESET, "-o", "no/a.exr"], 3, "not a directory"),
        (&[PRESET, "--set", "material.n_layer=9"], 2, "n_layer"),
        (&[PRESET, "--set", "material.n_flim=1.5"], 2, "did you mean `n_film`?"),
    ] {
        let run = render(dir.path(), args);
        assert_eq!(run.code, Some(code), "{args:?}: {}", run.err);
        assert!(run.err.contains(what), "{args:?}: {}", run.err);
        assert_eq!((run.out.as_str(), files(dir.path())), ("", before.clone()), "{args:?}");
    }
}

#[test]
fn a_scene_of_ones_own_may_be_laid_over_a_built_in_one() {
    let dir = folder();
    std::fs::write(dir.path().join("own.toml"), "include = 'sphere'\nground.show = false\n")
        .expect("written");
    let own = picture(dir.path(), &[PRESET, "--scene", "own.toml"]);
    let same = picture(dir.path(), &[PRESET, "--scene", "sphere", "--scene-set", "ground.show=false"]);
    assert_eq!(own, same);
}

#[test]
fn a_png_that_cannot_be_written_takes_the_exr_with_it() {
    let dir = folder();
    std::fs::create_dir(dir.path().join("a.png")).expect("a folder");
    let run = render(dir.path(), &[PRESET, "--scene", "sphere", "-o", "a.exr"]);
    assert_eq!(run.code, Some(3), "{}", run.err);
    assert!(run.err.contains("a.png"), "{}", run.err);
    assert_eq!(files(dir.path()), ["a.png"]);
}

/// A limit on the size of files ends writing as a full disk does.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing() {
    let dir = folder();
    let output = std::process::Command::new("sh")
        .current_dir(dir.path())
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 2; exec \"$@\"",
            "sh",
            env!("CARGO_BIN_EXE_ophidian"),
            "render",
        ])
        .args(SMALL)
        .args([PRESET, "--scene", "sphere", "--map-size", "64", "-o", "a.exr"])
        .output()
        .expect("a shell");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("a.exr") && files(dir.path()).is_empty(), "{told} {:?}", files(dir.path()));
}
