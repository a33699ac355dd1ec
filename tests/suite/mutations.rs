//! Random and mutated presets go from text to a plan, and small ones to maps: an answer or a diagnostic, never a
//! panic.

use std::sync::LazyLock;

use ophidian::base::{Domain, MapKind};
use ophidian::eval::{self, Control};
use ophidian::graph::{self, Graph};
use ophidian::node::{self, Fallback, InputSpec, Op};
use ophidian::plan::Plan;
use ophidian::preset::builtin::BUILTIN;
use ophidian::preset::{Document, PresetError};
use proptest::prelude::*;

/// Text to plan, as the command does it. Every diagnostic must be printable and lie inside the text.
fn text_to_plan(bytes: &[u8]) -> Option<Plan> {
    let built = Document::parse_bytes("random.toml", bytes).and_then(|document| graph::build(&document));
    match built {
        Ok((graph, _)) => plan(&graph),
        Err(error) => {
            told(&error);
            None
        }
    }
}

fn told(error: &PresetError) {
    assert!(!error.diagnostics.is_empty());
    assert!(!error.to_string().is_empty());
    let end = error.sources.sources().iter().map(|s| s.base + s.text.len()).max().unwrap_or(0);
    for label in error.diagnostics.iter().flat_map(|d| &d.labels) {
        assert!(label.span.start <= label.span.end && label.span.end <= end + 1, "{error}");
    }
}

fn plan(graph: &Graph) -> Option<Plan> {
    let wanted: Vec<MapKind> = graph.maps.keys().copied().collect();
    let domain = Domain::from_longer_side(12, graph.girth_mm, graph.length_mm);
    Plan::new(graph, &wanted, domain, Some(1 << 28)).ok()
}

/// Evaluate what is quick enough, and hold the maps to be finite.
fn evaluate(plan: &Plan, text: &str) {
    // Time that does not depend on the size (iterations) is in the cost, too.
    if plan.cost_ms() > 50.0 || !plan.assets.is_empty() {
        return;
    }
    let made = eval::run(plan, Control::default()).expect("nobody cancels");
    for (kind, map) in made.maps {
        let finite = map.planes.iter().all(|p| p.data().iter().all(|v| v.is_finite()));
        assert!(finite, "{kind} is not finite\n{text}");
    }
}

/// Texts to mutate: the built-in presets, and one that names every operation.
static TEXTS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let mut texts: Vec<String> = BUILTIN.iter().map(|(_, text)| (*text).to_owned()).collect();
    let mut all =
        String::from("seed = 3\n[maps]\ncolor = '#9C3B24'\nheight = {from = 'stripes', range = [0, 2]}\n");
    for op in node::ops().filter(|op| op.spec.name != "image") {
        all.push_str(&format!("[nodes.{0}]\nop = '{0}'\n", op.spec.name));
        let settings = toml::Value::Table((op.default)().settings());
        if let toml::Value::Table(table) = settings {
            for (key, value) in table {
                all.push_str(&format!("{key} = {value}\n"));
            }
        }
        for input in op.spec.inputs {
            all.push_str(&format!("{} = 'constant'\n", input.name));
        }
    }
    texts.push(all);
    texts
});

/// Pieces that presets are made of, and some that they are not.
const PIECES: &[&str] = &[
    "[",
    "]",
    "[[",
    "{",
    "}",
    "=",
    ".",
    ",",
    "\n",
    "\"",
    "'",
    "#",
    "-1",
    "0",
    "1e30",
    "-1e-40",
    "nan",
    "inf",
    "true",
    "9223372036854775807",
    "[nodes.x]\n",
    "op = 'mix'\n",
    "[maps]\n",
    "[tile]\n",
    "color = ",
    "height = ",
    "'x'",
    "'x.y'",
    "include = 'x'\n",
    "seed = 1\n",
    "\u{feff}",
    "\u{0}",
    "é",
    "\r\n",
    "range = [0, 0]\n",
    "[1, 2, 3]",
];

#[derive(Clone, Debug)]
enum Edit {
    Delete(usize, usize),
    Insert(usize, usize),
    Byte(usize, u8),
    /// Copy a stretch to another place.
    Copy(usize, usize, usize),
}

fn edit() -> impl Strategy<Value = Edit> {
    let at = any::<usize>();
    prop_oneof![
        (at, 0usize..40).prop_map(|(a, n)| Edit::Delete(a, n)),
        (at, 0..PIECES.len()).prop_map(|(a, p)| Edit::Insert(a, p)),
        (at, any::<u8>()).prop_map(|(a, b)| Edit::Byte(a, b)),
        (at, 0usize..200, at).prop_map(|(a, n, b)| Edit::Copy(a, n, b)),
    ]
}

fn mutate(text: &str, edits: &[Edit]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for edit in edits {
        let length = bytes.len();
        let place = |at: usize| at % (length + 1);
        match *edit {
            Edit::Delete(at, n) => drop(bytes.drain(place(at)..(place(at) + n).min(length))),
            Edit::Insert(at, piece) => {
                bytes.splice(place(at)..place(at), PIECES[piece].bytes());
            }
            Edit::Byte(at, byte) if length > 0 => bytes[at % length] = byte,
            Edit::Byte(..) => {}
            Edit::Copy(from, n, to) => {
                let copied = bytes[place(from)..(place(from) + n).min(length)].to_vec();
                bytes.splice(place(to)..place(to), copied);
            }
        }
    }
    bytes
}

/// A value for an input: in its range, at its ends, an earlier node, or wrong.
fn input(spec: &'static InputSpec, nodes: usize) -> BoxedStrategy<String> {
    let (low, high) = (spec.min.max(-4.0), spec.max.min(4.0));
    let number = (0.0f32..=1.0).prop_map(move |t| format!("{:?}", low + (high - low).max(0.0) * t));
    let node = (0..nodes.max(1)).prop_map(|i| format!("\"n{i}\""));
    // Images are mostly wired and numbers mostly set; one value in twenty is likely wrong.
    let image = spec.fallback == Fallback::Required;
    prop_oneof![
        if image { 8 } else { 30 } => number,
        if image { 30 } else { 4 } => node,
        1 => Just(format!("{:?}", spec.min)),
        1 => Just(format!("{:?}", spec.max)),
        1 => Just("\"#9C3B24\"".to_owned()),
        1 => Just("1e30".to_owned()),
    ]
    .boxed()
}

/// Node `index` of a random graph: any operation, with inputs that read earlier nodes.
fn random_node(index: usize) -> impl Strategy<Value = String> {
    let ops: Vec<&'static Op> = node::ops().filter(|op| op.spec.name != "image").collect();
    proptest::sample::select(ops.iter().map(|op| op.spec.name).collect::<Vec<_>>()).prop_flat_map(
        move |name| {
            let op = node::find(name).expect("a registered operation");
            let inputs: Vec<_> = op
                .spec
                .inputs
                .iter()
                .map(|spec| {
                    (
                        Just(spec.name),
                        proptest::bool::weighted(if spec.fallback == Fallback::Required {
                            0.99
                        } else {
                            0.5
                        }),
                        input(spec, index),
                    )
                })
                .collect();
            inputs.prop_map(move |inputs| {
                let mut text = format!("[nodes.n{index}]\nop = \"{name}\"\n");
                for (input, _, value) in inputs.iter().filter(|(_, set, _)| *set) {
                    text.push_str(&format!("{input} = {value}\n"));
                }
                text
            })
        },
    )
}

fn random_graph() -> impl Strategy<Value = String> {
    (1usize..8, any::<u64>(), 1.0f32..200.0, 1.0f32..200.0).prop_flat_map(|(count, seed, girth, length)| {
        let nodes: Vec<_> = (0..count).map(random_node).collect();
        nodes.prop_map(move |nodes| {
            let last = count - 1;
            format!(
                "seed = {}\n[tile]\ngirth_mm = {girth:?}\nlength_mm = {length:?}\n[maps]\ncolor = \"n{last}\"\n\
                 {}",
                seed >> 1,
                nodes.concat()
            )
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, max_shrink_iters: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_presets_are_planned_or_refused(
        text in any::<proptest::sample::Index>(),
        edits in proptest::collection::vec(edit(), 1..6),
    ) {
        let bytes = mutate(&TEXTS[text.index(TEXTS.len())], &edits);
        text_to_plan(&bytes);
    }

    #[test]
    fn pieces_of_presets_are_planned_or_refused(
        pieces in proptest::collection::vec(0..PIECES.len(), 0..40),
    ) {
        let text: String = pieces.iter().map(|&p| PIECES[p]).collect();
        text_to_plan(text.as_bytes());
    }

    #[test]
    fn random_graphs_are_made_or_refused(text in random_graph()) {
        if let Some(plan) = text_to_plan(text.as_bytes()) {
            evaluate(&plan, &text);
        }
    }
}

/// The tests above mean something only if a good part of what they make is sound.
#[test]
fn many_random_graphs_are_sound() {
    use proptest::strategy::ValueTree as _;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let strategy = random_graph();
    let sound = (0..100)
        .filter(|_| {
            let text = strategy.new_tree(&mut runner).expect("a graph").current();
            text_to_plan(text.as_bytes()).is_some()
        })
        .count();
    assert!(sound >= 10, "{sound} of 100");
    assert!(TEXTS.iter().all(|text| Document::parse("t", text).is_ok()));
}
