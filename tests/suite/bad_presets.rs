//! The messages for broken presets are part of the interface: `tests/bad_presets/*.toml`, each with the text that
//! `ophidian check` prints of it. `UPDATE_GOLDEN=1` rewrites the texts, and then fails.

use std::path::Path;

use super::cli::ophidian;

#[test]
fn every_broken_preset_gives_its_message_and_code_2() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_presets");
    let update = std::env::var_os("UPDATE_GOLDEN").is_some();
    let mut wrong = Vec::new();
    let mut count = 0;
    let mut entries: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        let file = path.file_name().unwrap().to_str().unwrap();
        let output = ophidian().current_dir(&folder).args(["check", file]).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        let golden = path.with_extension("txt");
        if update {
            std::fs::write(&golden, &text).unwrap();
        }
        count += 1;
        let expected = std::fs::read_to_string(&golden).unwrap_or_default();
        if output.status.code() != Some(2) || text != expected || !output.stdout.is_empty() {
            wrong.push(format!("{file}: {}\n{text}\nexpected\n{expected}", output.status));
        }
    }
    assert!(count >= 20, "{count}");
    assert!(wrong.is_empty(), "{} of {count} differ\n{}", wrong.len(), wrong.join("\n"));
    assert!(!update, "the messages were rewritten: look at them, then run again without UPDATE_GOLDEN");
}

#[test]
fn no_text_lacks_its_preset() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_presets");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        assert!(
            path.extension().is_none_or(|e| e != "txt") || path.with_extension("toml").exists(),
            "{path:?}"
        );
    }
}
