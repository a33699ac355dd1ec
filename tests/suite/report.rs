//! `report` from outside: one page, the numbers beside it, and the exit code.

use super::cli::ophidian;

#[test]
fn the_report_on_optics_is_one_page_with_numbers_beside_it() {
    let dir = tempfile::tempdir().expect("a folder");
    let output = ophidian()
        .args(["report", "optics", "--quick", "--json", "-o"])
        .arg(dir.path().join("new/report"))
        .output()
        .expect("the command runs");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    // In a build for tests, beside other tests, times say nothing; all else must pass.
    let failures: Vec<&str> =
        json["failures"].as_array().expect("a list").iter().filter_map(|f| f.as_str()).collect();
    assert!(failures.iter().all(|f| f.contains("times as long")), "{failures:?}");
    assert!(output.stderr.is_empty());
    let methods = json["tables"]["film_color"].as_array().expect("rows");
    assert!(methods.len() >= 16 && methods.iter().any(|m| m["method"] == "series-3"), "{methods:?}");
    let read =
        |name: &str| std::fs::read_to_string(dir.path().join("new/report").join(name)).expect("a file");
    let html = read("optics.html");
    assert!(html.matches("<svg").count() >= 4 && html.matches("<table>").count() >= 4);
    for outside in ["src=", "href=", "@import", "url(", "<script"] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(read("optics_stability.csv").lines().count() > 40);
    assert!(read("optics_film_color.csv").starts_with("method,ns,"));
    assert!(read("optics_curves.svg").starts_with("<svg"));
    assert_eq!(serde_json::from_str::<serde_json::Value>(&read("optics.json")).expect("JSON"), json);
}

#[test]
fn a_directory_that_cannot_be_made_is_told_at_once() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let output =
        ophidian().args(["report", "-o"]).arg(file.path().join("x")).output().expect("the command runs");
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn the_report_on_textures_measures_a_preset_and_refuses_what_cannot_be() {
    let dir = tempfile::tempdir().expect("a folder");
    let output = ophidian()
        .args(["report", "textures", "boa.toml", "--size", "48", "--quick", "--json", "-o", "made"])
        .current_dir(dir.path())
        .output()
        .expect("the command runs");
    assert_eq!(output.status.code(), Some(3), "there is no such file");
    let output = ophidian()
        .args(["report", "textures", "python_regius", "--size", "48", "--quick", "--json", "-o", "made"])
        .current_dir(dir.path())
        .output()
        .expect("the command runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let rows = json["tables"]["approximations"].as_array().expect("rows");
    assert!(rows.iter().any(|r| r["map"] == "normal" && r["seen"] == "degrees" && r["max"].is_number()));
    let read = |name: &str| std::fs::read_to_string(dir.path().join("made").join(name)).expect("a file");
    let csv = read("textures_approximations.csv");
    assert!(
        csv.starts_with("shortcut,in place of,map,unit,max,RMS,") && csv.lines().count() == rows.len() + 1
    );
    assert!(read("textures_saved.svg").starts_with("<svg") && read("textures.html").contains("<svg"));
    let output = ophidian()
        .args(["report", "textures", "python_regius", "--size", "16", "--quick", "-q", "-o", "small"])
        .current_dir(dir.path())
        .output()
        .expect("the command runs");
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{output:?}");
    assert!(dir.path().join("small/textures.html").is_file());
}

/// On any adapter; without one the command says so.
#[test]
fn the_report_on_the_preview_shows_pictures_beside_the_path_tracers() {
    let dir = tempfile::tempdir().expect("a folder");
    let output = ophidian()
        .args(["report", "preview", "--quick", "--json", "-o"])
        .arg(dir.path())
        .output()
        .expect("the command runs");
    let told = String::from_utf8_lossy(&output.stderr);
    if told.contains("needs a graphics adapter") || told.contains("no graphics adapter") {
        assert!(std::env::var_os("OPHIDIAN_REQUIRE_GPU").is_none_or(|v| v != "1"), "{told}");
        println!("SKIPPED: {told}");
        return;
    }
    let json: serde_json::Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {told}"));
    let rows = |table: &str| json["tables"][table].as_array().unwrap_or_else(|| panic!("{table}")).clone();
    let number = |row: &serde_json::Value, column: &str| row[column].as_f64().unwrap_or(f64::NAN);
    // What the preview draws is nearer to light as it draws it than to all light.
    let [direct, full] = [0, 1].map(|i| number(&rows("scenes")[i], "dE mean"));
    assert!(direct < full && direct < 5.0, "{direct} {full}");
    // Without a light a picture is farther off than with all.
    let shortcuts = rows("shortcuts");
    let of = |name: &str| {
        let row = shortcuts.iter().find(|row| row["changed"] == name).unwrap_or_else(|| panic!("{name}"));
        number(row, "dE mean")
    };
    assert!(of("without environment") > 2.0 * of("as set for this adapter"), "{shortcuts:?}");
    assert!(of("64 samples") <= of("1 sample"), "{shortcuts:?}");
    // A split sum is farther off than directions of the lobe.
    let environment = rows("environment");
    let [split, many] =
        [&environment[0], &environment[environment.len() - 1]].map(|row| number(row, "dE inner"));
    assert!(many < 0.9 * split, "{many} {split}");
    // An even skin is near, and fewer terms of its film's series are not nearer.
    let films = rows("films");
    assert_eq!((films.len(), rows("snakes").len()), (24, 4));
    assert!(
        films.iter().filter(|row| row["terms"] == 3).all(|row| number(row, "dE mean") < 3.0),
        "{films:?}"
    );
    let html = std::fs::read_to_string(dir.path().join("preview.html")).expect("a page");
    assert!(html.matches("<image").count() >= 5 + 16 && html.matches("data:image/png;base64,").count() >= 21);
    for outside in ["src=", "href=\"http", "@import", "url(", "<script"] {
        assert!(!html.contains(outside), "{outside}");
    }
}
