//! `film` from outside: numbers, tables, and what is wrong with tables.

use std::path::Path;

use super::cli::ophidian;

const ORACLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/oracle_dev.csv");
const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/furnace_dev.csv");
const COLORS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/colour_dev.csv");

/// Exit code, standard output, standard error.
fn film(args: &[&str]) -> (Option<i32>, String, String) {
    let output = ophidian().arg("film").args(args).output().expect("the command starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn json(args: &[&str]) -> serde_json::Value {
    let (code, out, err) = film(&[args, &["--json"]].concat());
    assert_eq!((code, err.as_str()), (Some(0), ""), "{args:?}");
    serde_json::from_str(&out).expect("JSON")
}

#[test]
fn one_film_has_the_known_values() {
    let at = |args: &[&str], key: &str| json(args)[key].as_f64().expect("a number");
    let plain = at(&["--thickness-nm", "0", "--lambda-nm", "550"], "R");
    assert!((plain - 1.0 / 9.0).abs() < 1e-15);
    let args = ["--thickness-nm", "400", "--angle-deg", "90", "--lambda-nm", "550"];
    assert_eq!((at(&args, "R"), at(&args, "T")), (1.0, 0.0));
    let color = json(&["--thickness-nm", "400", "--colour"]);
    for (c, expected) in [0.140605, 0.043906, 0.057435].into_iter().enumerate() {
        assert!((color["linear_srgb"][c].as_f64().expect("a number") - expected).abs() < 1e-6);
    }
    let (_, out, _) = film(&["--thickness-nm", "400"]);
    assert!(out.starts_with("linear sRGB 0.1406") && out.contains("sRGB #"), "{out}");
    let single = json(&["--thickness-nm", "400", "--precision", "f32", "--method", "series-3"]);
    assert!((single["linear_srgb"][0].as_f64().expect("a number") - 0.140605).abs() < 6e-4);
}

#[test]
fn tables_are_computed_and_compared() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("out.csv");
    let out = path.to_str().expect("UTF-8");
    let compare = |args: &[&str]| json(&[&["-o", out, "--csv"], args].concat());
    let report = compare(&[COLORS, "--tolerance", "2e-5"]);
    assert!(report["rows"] == 400 && report["max_delta_e_2000"].as_f64() < Some(0.01), "{report}");
    let text = std::fs::read_to_string(&path).expect("read");
    assert_eq!(text.lines().count(), 401);
    let head = "n0,n1,n2,d_nm,cos_theta,lin_r,lin_g,lin_b,lin_r_error,lin_g_error,lin_b_error";
    assert_eq!(text.lines().next(), Some(head));
    let three = compare(&[COLORS, "--method", "three"]);
    assert!(three["max_error"].as_f64() > Some(0.2), "{three}");
    let single = compare(&[ORACLE, "--precision", "f32", "--tolerance", "1e-3"]);
    assert!(single["rows"] == 1950 && single["precision"] == "f32", "{single}");
    // Of the f64 oracle only grazing rows are beyond 1e-12, by their own rounding.
    let (code, out, err) = film(&["--csv", ORACLE, "--tolerance", "1e-12"]);
    assert!(code == Some(1) && err.starts_with("1950 rows, airy, f64: error at most"), "{code:?} {err}");
    for row in out.lines().skip(1).filter(|row| !row.starts_with("graze")) {
        let error = |i: usize| row.rsplit(',').nth(i).and_then(|w| w.parse::<f64>().ok()).expect("a number");
        assert!(error(0).abs() <= 1e-12 && error(1).abs() <= 1e-12, "{row}");
    }
    assert_eq!(film(&["--csv", ORACLE, "--tolerance", "1e-9"]).0, Some(0));
}

#[test]
fn a_film_5_percent_thicker_fails() {
    let text = std::fs::read_to_string(COLORS).expect("read");
    let thicker = |line: &str| {
        let mut words: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(d) = words[3].parse::<f64>() {
            words[3] = (d * 1.05).to_string();
        }
        words.join(",") + "\n"
    };
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("rows.csv");
    std::fs::write(&path, text.lines().map(thicker).collect::<String>()).expect("written");
    let (code, _, err) = film(&["--csv", path.to_str().expect("UTF-8"), "--tolerance", "2e-5"]);
    assert_eq!(code, Some(1), "{err}");
}

#[test]
fn rows_are_json_objects_where_they_have_standard_output() {
    let (code, out, err) = film(&["--csv", COLORS, "--json", "--method", "belcour"]);
    assert_eq!((code, out.lines().count()), (Some(0), 400));
    let first: serde_json::Value = serde_json::from_str(out.lines().next().expect("a row")).expect("JSON");
    assert!(first["n1"] == 1.55 && first["lin_r"].is_f64() && first["lin_b_error"].is_f64(), "{first}");
    let report: serde_json::Value = serde_json::from_str(&err).expect("JSON");
    assert!(report["rows"] == 400 && report["method"] == "belcour", "{report}");
}

#[test]
fn every_method_is_as_far_off_as_it_should_be() {
    let rms = |method: &str| {
        let (_, _, err) = film(&["--csv", COLORS, "--json", "--method", method]);
        let report: serde_json::Value = serde_json::from_str(&err).expect("JSON");
        report["rms_error"].as_f64().expect("a number")
    };
    let errors = ["three-best", "belcour-gltf", "belcour", "belcour-white", "series-3"].map(rms);
    assert!(errors.windows(2).all(|e| e[1] < e[0]), "{errors:?}");
    // A table of colours is made for the film, whatever its indices.
    let table = json(&["--thickness-nm", "400", "--n2", "1.4", "--method", "lut-256"]);
    let truth = json(&["--thickness-nm", "400", "--n2", "1.4"]);
    let apart = |c: usize| {
        table["linear_srgb"][c].as_f64().expect("a number")
            - truth["linear_srgb"][c].as_f64().expect("a number")
    };
    assert!(apart(0) != 0.0 && (0..3).all(|c| apart(c).abs() < 5e-3));
}

#[test]
fn the_furnace_is_that_of_the_reference() {
    let (code, out, err) = film(&["--furnace", FURNACE, "--tolerance", "1e-5"]);
    assert!(code == Some(0) && err.starts_with("120 rows, furnace: error at most"), "{code:?} {err}");
    assert_eq!(out.lines().count(), 121);
    let head = out.lines().next().expect("a head");
    assert!(head.starts_with("n0,n1,n2,d_nm,lambda_nm,roughness,kd,tau,cos_o,E_spec,E_diff_flat,"), "{head}");
    // The control.
    assert_eq!(film(&["--furnace", FURNACE, "--tolerance", "1e-12"]).0, Some(1));
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("rows.csv");
    let compute = |row: &str| {
        let head = "n0,n1,n2,d_nm,lambda_nm,roughness,kd,tau,cos_o";
        std::fs::write(&path, format!("{head}\n{row}\n")).expect("written");
        film(&["--furnace", path.to_str().expect("UTF-8"), "--json"])
    };
    let (code, out, err) = compute("1,1.55,2,400,550,0.5,1,0,0.4");
    let row: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let number = |key: &str| row[key].as_f64().expect("a number");
    assert!(code == Some(0) && err == "{\"rows\":1,\"max_error\":null,\"rms_error\":null}\n", "{err}");
    assert!((number("E_spec") + number("E_diff_coupled") - 1.0).abs() < 1e-9, "{row}");
    for (row, text) in [
        ("1,1.55,2,400,550,0.5,1.5,0,0.4", ":2: kd = 1.5 is out of range"),
        ("1,1.55,2,400,550,0.5,1,-1,0.4", ":2: tau = -1 is out of range"),
        ("1,1.55,20,400,550,0.5,1,0,0.4", ":2: n2 = 20 is out of range"),
    ] {
        let (code, _, err) = compute(row);
        assert!(code == Some(2) && err.contains(text), "{code:?} {err}");
    }
}

#[test]
fn a_plot_is_an_svg_with_axes() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("film.svg");
    let plot = |args: &[&str]| film(&[&["--plot", path.to_str().expect("UTF-8")], args].concat());
    assert_eq!(plot(&["--thickness-nm", "1500", "--angle-deg", "30"]).0, Some(0));
    let svg = std::fs::read_to_string(&path).expect("read");
    for part in ["<svg", ">2000<", "thickness, nm", "at 30 degrees", "</svg>"] {
        assert!(svg.contains(part), "{part}");
    }
    assert_eq!(plot(&[]).0, Some(0));
    assert_eq!(plot(&["--n2", "0"]).0, Some(2));
    assert_eq!(plot(&["--lambda-nm", "550"]).0, Some(2));
    assert_eq!(film(&["--plot", dir.path().join("no/film.svg").to_str().expect("UTF-8")]).0, Some(3));
}

#[test]
fn tables_without_expected_columns_are_computed_alone() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("rows.csv");
    std::fs::write(&path, "\u{feff}# films\r\nname,n0,n1,n2,d_nm,cos_theta\r\n\r\nmine,1,1.55,2,0,1\r\n")
        .expect("written");
    let (code, out, err) = film(&["--csv", path.to_str().expect("UTF-8")]);
    assert_eq!((code, err.as_str()), (Some(0), "1 rows, reference (1e-7), f64\n"));
    let mut lines = out.lines();
    assert_eq!(lines.next(), Some("name,n0,n1,n2,d_nm,cos_theta,lin_r,lin_g,lin_b"));
    assert!(lines.next().is_some_and(|l| l.starts_with("mine,1,1.55,2,0,1,0.1111")), "{out}");
}

#[test]
fn bad_tables_are_refused_with_their_lines() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("rows.csv");
    let file = path.to_str().expect("UTF-8");
    let refuse = |bytes: &[u8], text: &str| {
        std::fs::write(Path::new(file), bytes).expect("written");
        let (code, out, err) = film(&["--csv", file]);
        assert!(code == Some(2) && out.is_empty() && err.contains(text), "{code:?} {out} {err}");
    };
    refuse(b"", "no line of column names");
    refuse(b"n0,n1,n2,d_nm\n1,1,1,1\n", ":1: there is no column `cos_theta`");
    refuse(b"n0,n0\n", ":1: column `n0` is there twice");
    let head = "n0,n1,n2,d_nm,cos_theta\n";
    let rows = |row: &str| format!("{head}# a comment\n1,1.5,2,1,1\n{row}\n").into_bytes();
    refuse(&rows("1,2,3"), ":4: 3 values, where there are 5 columns");
    refuse(&rows("1,abc,2,1,1"), ":4: column `n1`: `abc` is not a finite number");
    refuse(&rows("1,NaN,2,1,1"), ":4: column `n1`: `NaN`");
    refuse(&rows("1,1.5,2,-1,1"), ":4: thickness = -1 nm is out of range");
    refuse(&rows("1,1.5,0,1,1"), ":4: n2 = 0 is out of range");
    refuse(&rows("1,1.5,2,1,1.5"), ":4: cos_theta = 1.5 is out of range");
    refuse(&[rows("1,1.5,2,1,"), vec![0xff]].concat(), ":5: the text is not UTF-8");
    assert_eq!(film(&["--csv", dir.path().join("none.csv").to_str().expect("UTF-8")]).0, Some(3));
}

#[test]
fn bad_arguments_are_refused() {
    let refuse = |args: &[&str], text: &str| {
        let (code, _, err) = film(args);
        assert!(code == Some(2) && err.contains(text), "{args:?} {code:?} {err}");
    };
    refuse(&[], "--thickness-nm");
    refuse(&["--thickness-nm", "400", "--n1", "nan"], "n1 = NaN is out of range");
    refuse(&["--thickness-nm", "400", "--angle-deg", "91"], "--angle-deg 91");
    refuse(&["--thickness-nm", "400", "--lambda-nm", "0"], "wavelength = 0 nm");
    refuse(&["--thickness-nm", "400", "--method", "magic"], "reference, series-K, uniform-N");
    refuse(&["--thickness-nm", "400", "--method", "uniform-0"], "the number is 1 to");
    refuse(&["--thickness-nm", "400", "--csv", "x"], "cannot be used with");
    refuse(&["--csv", ORACLE, "--method", "three"], "only one method for one wavelength");
}
