//! Tests of the room as a whole: places, limits, layers, overrides, and that no text makes it panic.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::document::{MAX_DEPTH, MAX_TEXT};
use super::value::deserializer;
use super::*;

/// `name:line:column code message` of each diagnostic.
fn told(error: &PresetError) -> Vec<String> {
    let show = |d: &Diagnostic| {
        let at = d.span().and_then(|s| error.sources.locate(s.start));
        let at = at.map(|l| format!("{}:{}:{}", error.sources.sources()[l.source].name, l.line, l.column));
        format!("{} {} {}", at.unwrap_or_default(), d.code, d.message)
    };
    error.diagnostics.iter().map(show).collect()
}

fn failed(bytes: &[u8]) -> Vec<String> {
    told(&Document::parse_bytes("p", bytes).expect_err("it is no preset"))
}

fn toml_of(document: &Document) -> toml::Table {
    let root = Value::new(0..0, Item::Table(document.root.clone()));
    serde::Deserialize::deserialize(deserializer(&root)).expect("a table is a table")
}

struct Map(BTreeMap<&'static str, &'static str>);

impl Loader for Map {
    fn load(&self, path: &str, _: &str) -> Result<Loaded, String> {
        let bytes = self.0.get(path).ok_or_else(|| format!("there is no {path}"))?.as_bytes().to_vec();
        Ok(Loaded { name: path.into(), bytes })
    }
}

fn load(files: &[(&'static str, &'static str)]) -> Result<Document, PresetError> {
    Document::load("main", &Map(files.iter().copied().collect()))
}

#[test]
fn spans_name_the_place_in_the_text() {
    let document = Document::parse("p", "seed = 3\n[scales]\nrows = 21\ntip.keel = true\n").expect("valid");
    let scales = document.root["scales"].get_ref().as_table().expect("a table");
    let text = |v: &Value| document.sources.sources()[0].text[v.span()].to_owned();
    assert_eq!(text(&document.root["seed"]), "3");
    assert_eq!(text(&document.root["scales"]), "[scales]");
    assert_eq!(text(&scales["rows"]), "21");
    assert_eq!(text(&scales["tip"].get_ref().as_table().expect("a table")["keel"]), "true");
}

#[test]
fn all_syntax_errors_are_told_at_once() {
    let errors = failed(b"a = 1\nb = \nc = \"open\nd = 1\nd = 2\n[e\n");
    let places: Vec<&str> = errors.iter().map(|e| e.split(' ').next().unwrap_or("")).collect();
    assert_eq!(places, ["p:2:5", "p:3:10", "p:5:1", "p:6:3"], "{errors:#?}");
}

#[test]
fn the_commonest_mistakes_have_help() {
    let error = Document::parse("p", "a = spots\na = 1").expect_err("two mistakes");
    let helps: Vec<_> = error.diagnostics.iter().map(|d| d.help.as_deref().unwrap_or("")).collect();
    assert_eq!(helps, ["write \"spots\"", "a key may be set once; remove one of the two"]);
}

#[test]
fn bytes_that_are_no_utf8_are_told_with_offset_and_place() {
    assert_eq!(
        failed(b"a = 1\nb = \"\xff\"\n"),
        ["p:2:6 not-utf8 the text is not UTF-8: byte 0xff at offset 11"]
    );
}

#[test]
fn nonsense_of_any_size_is_refused_soon() {
    let started = Instant::now();
    assert_eq!(failed(&vec![b'['; 100 << 20])[0].split(' ').nth(1), Some("too-long"));
    let fill = |pattern: &str| pattern.repeat(MAX_TEXT / pattern.len()).into_bytes();
    for pattern in ["[", "{", "a.", "[a.", "a={", "a=[", "\"", "'''", "=", "#", "\0", "]", "a=1\n", "[[a]]\n"]
    {
        let one = Instant::now();
        let _ = Document::parse_bytes("p", &fill(pattern));
        assert!(one.elapsed() < Duration::from_secs(10), "{pattern:?} took {:?}", one.elapsed());
    }
    // Many tables, each opened behind its child.
    let text: String = (0..40_000).map(|i| format!("[t{i}.a]\n[t{i}]\n")).collect();
    assert!(Document::parse("p", &text).is_ok());
    assert!(started.elapsed() < Duration::from_secs(60), "{:?}", started.elapsed());
}

#[test]
fn nesting_is_limited_whatever_it_is_made_of() {
    let nest = |open: &str, middle: &str, close: &str, n: usize| {
        format!("a={}{middle}{}", open.repeat(n), close.repeat(n)).into_bytes()
    };
    assert!(Document::parse_bytes("p", &nest("[", "1", "]", MAX_DEPTH)).is_ok());
    for bytes in [
        nest("[", "1", "]", MAX_DEPTH + 1),
        nest("[", "1", "]", 100_000),
        nest("{a=", "1", "}", 100_000),
        nest(&format!("{{{}a=", "a.".repeat(70)), "1", "}", 79),
        format!("[{}a]\nb = 1", "a.".repeat(79)).into_bytes(),
        format!("[{}a]\n{}b = 1", "a.".repeat(70), "b.".repeat(70)).into_bytes(),
    ] {
        let errors = failed(&bytes);
        let deep = |e: &String| e.contains(" too-deep ") || e.contains("recursion limit");
        assert!(errors.iter().any(deep), "{errors:?}");
    }
}

#[test]
fn an_ordinary_mistake_is_not_taken_for_nesting() {
    let text: String = (0..300).map(|i| format!("[t{i}]\nx = [1, 2\n")).collect();
    let errors = failed(text.as_bytes());
    assert!(errors.iter().all(|e| e.contains(" syntax ")), "{errors:?}");
    assert_eq!(errors.len(), 21, "twenty, and the count of the others");
}

#[test]
fn layers_merge_and_the_later_wins() {
    let document = load(&[
        ("main", "include = ['a', 'b']\nseed = 1\n[pattern]\nsize = 9\n[nodes.n]\nop = 'worley'\nx = 1"),
        ("a", "seed = 2\nlist = [1, 2]\n[pattern]\nsize = 1\ntype = 'spots'\n[nodes.n]\nop = 'perlin'\ncells = 3"),
        ("b", "list = [3]\n[pattern]\ntype = 'bands'\n[nodes.m]\nop = 'mix'"),
    ])
    .expect("valid layers");
    let expected = "list = [3]\nseed = 1\n[pattern]\nsize = 9\ntype = 'bands'\n\
                    [nodes.n]\nop = 'worley'\nx = 1\n[nodes.m]\nop = 'mix'";
    assert_eq!(toml_of(&document), expected.parse().expect("valid"));
    let kind = &document.root["pattern"].get_ref().as_table().expect("a table")["type"];
    let at = document.sources.locate(kind.span().start).expect("located");
    assert_eq!((document.sources.sources()[at.source].name.as_str(), at.line, at.column), ("b", 3, 8));
}

#[test]
fn a_texts_include_reached_twice_is_no_circle() {
    let files =
        [("main", "include = ['a', 'b']"), ("a", "include = 'c'"), ("b", "include = 'c'"), ("c", "x = 1")];
    assert_eq!(toml_of(&load(&files).expect("a diamond")), "x = 1".parse().expect("valid"));
}

#[test]
fn errors_of_every_layer_are_told_at_once_with_the_chain() {
    let error = load(&[
        ("main", "include = ['a', 'gone', 3]\nx = "),
        ("a", "y = 1\ninclude = 'b'"),
        ("b", "include = 'main'\nz = ]"),
    ])
    .expect_err("broken");
    assert_eq!(
        told(&error),
        [
            "main:2:5 syntax a value is missing",
            "main:1:25 wrong-type include is a number, not the name of a preset",
            "b:2:5 syntax missing array opening, expected `[`",
            "b:1:11 include-cycle presets include one another in a circle: main → a → b → main",
            "main:1:17 no-file there is no gone",
        ]
    );
    let chain: Vec<_> = error.diagnostics[3].labels.iter().map(|l| l.span.start).collect();
    let places: Vec<_> =
        chain.iter().filter_map(|&p| error.sources.locate(p)).map(|l| (l.source, l.line)).collect();
    assert_eq!(places, [(2, 1), (1, 2), (0, 1)]);
}

#[test]
fn includes_without_end_end() {
    struct Deeper;
    impl Loader for Deeper {
        fn load(&self, path: &str, _: &str) -> Result<Loaded, String> {
            let next: u32 = path.parse().map_err(|_| "no number".to_owned())?;
            let text = format!("include = ['{}', '{}']", next * 2, next * 2 + 1);
            Ok(Loaded { name: path.into(), bytes: text.into_bytes() })
        }
    }
    let error = Document::load("1", &Deeper).expect_err("no end");
    assert_eq!(error.diagnostics.len(), 1);
    assert_eq!(error.diagnostics[0].code, "include-depth");
    assert!(Document::load("x", &Deeper).is_err_and(|e| e.diagnostics[0].code == "no-file"));
}

fn overridden(text: &str, settings: &[&str]) -> (Document, Vec<String>) {
    let mut document = Document::parse("p", text).expect("valid");
    let mut diagnostics = Diagnostics::new();
    for setting in settings {
        overrides::apply(&mut document, setting, &mut diagnostics);
    }
    let error = PresetError { diagnostics: diagnostics.into_list(), sources: document.sources.clone() };
    (document, told(&error))
}

#[test]
fn overrides_set_make_and_merge() {
    let (document, errors) = overridden(
        "seed = 1\n[pattern]\nsize = 1\nstops = [{x = 1}, {x = 2}]",
        &[
            "seed=7",
            "pattern.size = 0.3",
            "pattern.type=spots",
            "color.ground=#9C3B24",
            "color . 'a=b' = \"x\"",
            "pattern={outline=true}",
            "pattern.stops.1.x=5",
            "path=masks/a.png",
            "list=[1, 2]",
        ],
    );
    assert_eq!(errors, [""; 0]);
    let expected = "seed = 7\npath = 'masks/a.png'\nlist = [1, 2]\n\
                    [pattern]\nsize = 0.3\ntype = 'spots'\noutline = true\nstops = [{x = 1}, {x = 5}]\n\
                    [color]\nground = '#9C3B24'\n'a=b' = 'x'";
    assert_eq!(toml_of(&document), expected.parse().expect("valid"));
    let size = &document.root["pattern"].get_ref().as_table().expect("a table")["size"];
    let at = document.sources.locate(size.span().start).expect("located");
    let source = &document.sources.sources()[at.source];
    assert_eq!((source.name.as_str(), at.column), ("--set pattern.size = 0.3", 16));
}

#[test]
fn bad_overrides_are_told_in_their_own_text() {
    let (_, errors) = overridden(
        "seed = 1\nlist = [1]",
        &["seed", "=3", "a..b=3", "seed.x=3", "list.4=3", "list.x.y=3", "x=[1", "x=", "a\nb=1"],
    );
    assert_eq!(
        errors,
        [
            "--set seed:1:1 bad-override the override has no `=`",
            "--set =3:1:1 bad-override the override's key is no TOML key",
            "--set a..b=3:1:1 bad-override the override's key is no TOML key",
            "--set seed.x=3:1:1 bad-override `seed` is a number, not a table",
            "--set list.4=3:1:6 bad-override `list` is a list of 1",
            "--set list.x.y=3:1:6 bad-override `list` is a list of 1",
            "--set x=[1:1:5 syntax unclosed array, expected `]`",
            "--set x=:1:3 syntax a value is missing",
            "--set a\nb=1:1:1 bad-override the override's key is no TOML key",
        ]
    );
}

mod properties {
    use super::*;
    use proptest::prelude::*;

    const PRESET: &str = "include = 'x'\nseed = 3\n[scales]\nrows = 21 # of them\ntip = { amount = 0.5, keel = true }\n\
                          [[stops]]\nposition = 0.0\ncolor = \"#9C3B24\"\n[[stops]]\nposition = 1.0\n\
                          [nodes.noise]\nop = \"perlin\"\ncells_u = 8\ntext = '''a\nb'''\n";

    #[derive(Debug, serde::Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    #[derive(Default)]
    struct Scales {
        #[schemars(range(min = 0, max = 100))]
        rows: u32,
        tip: BTreeMap<String, f32>,
    }

    /// Everything the room does, on a text; every span it tells must lie in the sources.
    fn all_of_it(bytes: &[u8], setting: &str) {
        let mut document =
            match Document::load_text(Loaded { name: "p".into(), bytes: bytes.to_vec() }, &Never) {
                Ok(document) => document,
                Err(error) => {
                    assert!(!error.diagnostics.is_empty() && !error.to_string().is_empty());
                    return within(&error.diagnostics, &error.sources);
                }
            };
        let mut diagnostics = Diagnostics::new();
        overrides::apply(&mut document, setting, &mut diagnostics);
        for value in document.root.values() {
            let _: Option<Scales> = section::read(value, "[scales]", &mut diagnostics);
        }
        within(diagnostics.list(), &document.sources);
    }

    struct Never;

    impl Loader for Never {
        fn load(&self, path: &str, _: &str) -> Result<Loaded, String> {
            if path == "x" {
                Ok(Loaded { name: "x".into(), bytes: b"[scales]\nrows = 1".to_vec() })
            } else {
                Err("no such preset".into())
            }
        }
    }

    fn within(diagnostics: &[Diagnostic], sources: &SourceMap) {
        let end = sources.sources().last().map_or(0, |s| s.base + s.text.len());
        for label in diagnostics.iter().flat_map(|d| &d.labels) {
            assert!(label.span.start <= label.span.end && label.span.end <= end, "{label:?} beyond {end}");
            assert!(sources.locate(label.span.start).is_some());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), setting in ".{0,40}") {
            all_of_it(&bytes, &setting);
        }

        #[test]
        fn random_toml_like_texts_never_panic(text in "[\\[\\]{}=.,a-c\"' \n#0-9_]{0,120}", setting in "[a-c.=\\[{'\"0-9]{0,20}") {
            all_of_it(text.as_bytes(), &setting);
        }

        #[test]
        fn mutated_presets_never_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), 0..3u8, any::<prop::sample::Index>()), 1..12)) {
            const BYTES: &[u8] = b"[]{}=.,'\"\n# -+_\\0x9ae\xff\xc3\0";
            let mut bytes = PRESET.as_bytes().to_vec();
            for (at, kind, byte) in edits {
                let (at, byte) = (at.index(bytes.len()), BYTES[byte.index(BYTES.len())]);
                match kind {
                    0 => bytes[at] = byte,
                    1 => bytes.insert(at, byte),
                    _ => { if bytes.len() > 1 { bytes.remove(at); } }
                }
            }
            all_of_it(&bytes, "scales.rows=5");
        }
    }
}
