//! Tests of the room: presets to graphs, what is refused, and graphs printed back.

use super::*;
use crate::base::{Domain, LinearRgb};
use crate::eval;
use crate::node::PortKind;
use crate::node::draft::{Draft, Wire};
use crate::plan::Plan;
use crate::preset::Document;

const PRESET: &str = r##"
seed = 7
[tile]
girth_mm = 30
length_mm = 60
[nodes.bands]
op = "stripes"
count = 3
softness = 0.1
[nodes.spot]
op = "disc"
du = "bands.phase"
[nodes.skin]
op = "mix"
a = "#9C3B24"
b = [0.1, 0.25, 0.3]
mask = "bands"
[nodes.both]
op = "mix"
a = "skin"
b = "spot.mask"
mask = 0.3
[maps]
color = "both"
height = { from = "spot.distance", range = [-1.5, 2] }
roughness = 0.4
"##;

fn graph(text: &str) -> Graph {
    let document = Document::parse("p", text).expect("valid TOML");
    build(&document).unwrap_or_else(|e| panic!("{e}")).0
}

/// `line:column code message (help)` of everything that is wrong.
fn told(text: &str) -> Vec<String> {
    let document = Document::parse("p", text).expect("valid TOML");
    let error = build(&document).expect_err("it is wrong");
    let show = |d: &crate::preset::Diagnostic| {
        let at = d.span().and_then(|s| error.sources.locate(s.start)).expect("every problem has a place");
        let help = d.help.as_deref().unwrap_or("");
        format!("{}:{} {} {} ({help})", at.line, at.column, d.code, d.message)
    };
    error.diagnostics.iter().map(show).collect()
}

fn bits(graph: &Graph) -> Vec<(MapKind, Vec<u32>)> {
    let wanted: Vec<MapKind> = graph.maps.keys().copied().collect();
    let domain = Domain::from_longer_side(48, graph.girth_mm, graph.length_mm);
    let plan = Plan::new(graph, &wanted, domain, None).expect("a plan");
    let done = eval::run(&plan, eval::Control::default()).expect("not cancelled");
    let texels = |p: &crate::base::Plane| p.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    done.maps.into_iter().map(|(k, m)| (k, m.planes.iter().flat_map(texels).collect())).collect()
}

#[test]
fn a_preset_of_nodes_becomes_a_graph() {
    let graph = graph(PRESET);
    assert_eq!((graph.seed, graph.girth_mm, graph.length_mm), (7, 30.0, 60.0));
    let names: Vec<&str> = graph.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(names, ["bands", "spot", "skin", "both"]);
    let skin = &graph.nodes[2];
    assert_eq!(skin.kind, Kind::Color);
    assert_eq!(skin.inputs[1], Source::Color([0.1, 0.25, 0.3]));
    assert_eq!(graph.output_name(OutputRef { node: 0, port: 2 }), "bands.phase");
    assert_eq!(graph.maps[&MapKind::Height].range, [-1.5, 2.0]);
    assert_eq!(graph.maps[&MapKind::Roughness].source, Source::Scalar(0.4));
}

#[test]
fn a_printed_graph_evaluates_to_the_same_bytes() {
    let original = graph(PRESET);
    let text = to_toml(&original);
    let again = graph(&text);
    assert_eq!(bits(&original), bits(&again), "{text}");
    assert_eq!(to_toml(&again).split_once('\n').map(|t| t.1), text.split_once('\n').map(|t| t.1));
    // The comparison can fail.
    let other = graph(&text.replace("softness = 0.1", "softness = 0.2"));
    assert_ne!(bits(&original), bits(&other));
}

#[test]
fn every_operation_prints_and_reads_back() {
    for op in crate::node::ops() {
        let mut draft = Draft::default();
        let mut inputs = Vec::new();
        let image = draft.add("image", crate::node::generate::Disc::default(), &[]);
        for input in op.spec.inputs {
            let wire = match input.kind {
                PortKind::Color => LinearRgb([0.1, 0.7, 1.0 / 3.0]).into(),
                _ if input.min > -1e30 => Wire::Scalar(0.3 * input.min + 0.7 * input.max),
                _ => image.clone(),
            };
            inputs.push(crate::node::draft::InputDraft { name: input.name.into(), wire, span: None });
        }
        let node = (op.default)();
        draft.put(crate::node::draft::NodeDraft { name: "it".into(), node, inputs, span: None });
        let sketch =
            Sketch { name: "p".into(), seed: u64::MAX, size_mm: [12.3, 45.6], draft, maps: BTreeMap::new() };
        let first = resolve(&sketch).unwrap_or_else(|e| panic!("{}: {e:?}", op.spec.name));
        let text = to_toml(&first);
        let again = graph(&text);
        assert_eq!(again.seed, u64::MAX);
        let (a, b) = (&first.nodes[first.nodes.len() - 1], &again.nodes[again.nodes.len() - 1]);
        assert_eq!(a.inputs, b.inputs, "{text}");
        assert_eq!(a.node.settings(), b.node.settings(), "{text}");
        assert_eq!((a.seed, a.kind), (b.seed, b.kind), "{text}");
    }
}

#[test]
fn every_problem_of_the_text_is_told_at_once() {
    assert_eq!(
        told(
            "sead = 1\nseed = -1\n[nodes.a]\nop = 'mixx'\n[nodes.b]\nop = 'stripes'\ncuont = 3\nsoftness = 9\nduty = true\n\
             [nodes.'c.d']\nop = 'mix'\n[nodes.e]\n[nodes]\nf = 1\n[tile]\ngirth_mm = 0\n\
             [maps]\ncolour = 'b'\nheight = { range = [1, 0], from = '#12' }\nroughness = {}"
        ),
        [
            "1:1 unknown-key unknown key `sead` (did you mean `seed`?)",
            "2:8 wrong-type expected a whole number, not negative, found -1 ()",
            "16:12 out-of-range girth_mm = 0 is out of range (allowed: 0.1 to 10000 mm)",
            "4:6 unknown-op there is no operation `mixx` (did you mean `mix`?)",
            "9:8 wrong-type b.duty is true or false (write a number, a colour \"#rrggbb\" or [r, g, b], or a node's name)",
            "7:1 unknown-key unknown key `cuont` in node b (stripes) (did you mean `count`?)",
            "8:12 out-of-range softness = 9 is out of range (allowed: 0 to 1)",
            "10:8 bad-name `c.d` cannot name a node (use letters, digits, `_` and `-`)",
            "12:1 missing-key node e has no `op` (add op = \"…\"; `ophidian nodes` lists the operations)",
            "14:5 wrong-type node f is a number, not a table (write [nodes.f] and below it op = \"…\")",
            "18:1 unknown-key there is no map `colour` (did you mean `color`?)",
            "19:35 bad-color \"#12\" is not a colour: write \"#rrggbb\", sRGB in hexadecimal, such as \"#9C3B24\" ()",
            "20:13 missing-key maps.roughness has no `from` (add from = \"node\")",
        ]
    );
}

#[test]
fn every_problem_of_the_wiring_is_told_at_its_place() {
    assert_eq!(
        told(
            "[nodes.bands]\nop = 'stripes'\nduty = 2\n[nodes.m]\nop = 'mix'\na = 'band'\nb = 'bands.mast'\nmask = '#fff'\n\
             [nodes.n]\nop = 'mix'\n[maps]\nheight = 'gone'"
        ),
        [
            "3:8 out-of-range node bands: duty = 2 is out of range (allowed: 0 to 1)",
            "6:5 unknown-node node m, input a: there is no node `band` (did you mean `bands`?)",
            "7:5 unknown-port node m, input b: node `bands` (stripes) has no output `mast` (did you mean `mask`?)",
            "8:8 type-mismatch node m: mask takes a number or a scalar output, not a color (write a number)",
            "9:1 missing-input node n (mix) needs `a` (set `a = \"some_node\"`: Shown where the mask is 0.)",
            "9:1 missing-input node n (mix) needs `b` (set `b = \"some_node\"`: Shown where the mask is 1.)",
            "12:10 unknown-node map height: there is no node `gone` (name a node of this preset, `node` or `node.port`)",
        ]
    );
    assert_eq!(
        told("[nodes.a]\nop = 'mix'\na = 'b'\nb = 0\n[nodes.b]\nop = 'mix'\na = 'a'\nb = 1")[0],
        "1:1 cycle nodes read each other in a circle: a reads b reads a \
         (break the circle: a node may only read nodes that do not depend on it)"
    );
}

#[test]
fn a_node_of_the_anatomy_is_replaced_or_changed_by_name() {
    let build = |text: &str| {
        let document = Document::parse("p", text).expect("valid TOML");
        let mut draft = Draft::default();
        let stripes = crate::node::generate::Stripes { count: 5, ..Default::default() };
        let wire = draft.add("bands", stripes, &[("duty", 0.25.into())]);
        let mut maps = BTreeMap::from([(MapKind::Height, MapDraft { wire, range: [0.0, 2.0], span: None })]);
        let mut diagnostics = crate::preset::Diagnostics::new();
        read::read_nodes(&document, &mut draft, &mut diagnostics);
        read::read_maps(&document, &mut maps, &mut diagnostics);
        assert_eq!(diagnostics.list(), []);
        let sketch = Sketch { name: "p".into(), seed: 1, size_mm: [1.0, 1.0], draft, maps };
        let graph = resolve(&sketch).expect("a sound graph");
        let node = &graph.nodes[0];
        (node.node.spec().name, node.node.settings(), node.inputs[0], graph.maps[&MapKind::Height].range)
    };
    let (_, made, duty, range) = build("");
    assert_eq!((duty, range), (Source::Scalar(0.25), [0.0, 2.0]));
    let (_, changed, duty, range) = build("[nodes.bands]\nsoftness = 0.5\n[maps]\nheight = {range = [0, 1]}");
    assert_eq!((duty, range), (Source::Scalar(0.25), [0.0, 1.0]));
    assert_eq!(changed["count"], made["count"]);
    assert_eq!(changed["softness"], toml::Value::Float(0.5));
    let (op, replaced, duty, _) = build("[nodes.bands]\nop = 'stripes'");
    assert_eq!((op, duty), ("stripes", Source::Scalar(0.5)));
    assert_ne!(replaced["count"], made["count"]);
}

#[test]
fn pictures_mark_what_each_map_needs() {
    let graph = graph(&format!("{PRESET}\n[nodes.unread]\nop = 'disc'"));
    let words = |wanted: &[MapKind]| -> Vec<String> {
        let join = |maps: &std::collections::BTreeSet<MapKind>| {
            maps.iter().map(|m| m.name()).collect::<Vec<_>>().join(" ")
        };
        graph
            .nodes
            .iter()
            .zip(needed_by(&graph, wanted))
            .map(|(n, m)| format!("{}: {}", n.name, join(&m)))
            .collect()
    };
    assert_eq!(
        words(&[MapKind::Color, MapKind::Height]),
        ["bands: color height", "spot: color height", "skin: color", "both: color", "unread: "]
    );
    assert_eq!(words(&[MapKind::Height])[2], "skin: ");
    let dot = to_dot(&graph, &[MapKind::Height]);
    assert!(dot.contains("n0 -> n1 [taillabel=\"phase\", headlabel=\"du\"];"), "{dot}");
    assert!(dot.contains("n2 [label=\"skin\\nmix\", tooltip=\"\", style=dashed"), "{dot}");
    assert!(dot.contains("n1 -> map_height;"), "{dot}");
    let mermaid = to_mermaid(&graph, &[MapKind::Height]);
    assert!(
        mermaid.contains("n4[\"unread · disc\"]:::dead")
            && mermaid.contains("n1 --> map_height([\"height\"])"),
        "{mermaid}"
    );
    let json = to_json(&graph, &[MapKind::Height]);
    assert_eq!(json["nodes"][0]["needed_by"], serde_json::json!(["height"]));
    assert_eq!(json["nodes"][1]["inputs"]["du"], "bands.phase");
    assert_eq!(json["maps"]["height"]["from"], "spot.distance");
}

#[test]
fn optics_are_carried_printed_and_part_of_the_hash_only_where_they_are_set() {
    let plain = "seed = 3\n[maps]\nheight = 0.5\n";
    let optics = "[material]\nn_film = 1.5\nabsorption = [0.25, 1, 1.3]\nalbedo = 'intrinsic'\n";
    let (without, with) = (graph(plain), graph(&format!("{plain}{optics}")));
    assert!(without.optics.is_empty() && !to_toml(&without).contains("material"));
    assert_eq!(preset_hash(&graph(&format!("{plain}[material]"))), preset_hash(&without));
    assert_ne!(preset_hash(&with), preset_hash(&without));
    let expected = crate::optics::SkinOptics {
        n_film: Some(1.5),
        n_layer: None,
        absorption: Some([0.25, 1.0, 1.3]),
        albedo: Some(crate::optics::layered::Albedo::Intrinsic),
    };
    assert_eq!(with.optics, expected);
    let text = to_toml(&with);
    assert_eq!(graph(&text).optics, expected, "{text}");
    assert!(text.contains("absorption = [0.25, 1.0, 1.3]"), "short numbers: {text}");
    assert_eq!(preset_hash(&graph(&text)), preset_hash(&with));
    assert_eq!(
        told("[material]\nn_flim = 1.5\nn_layer = 9\nalbedo = 'seen'\n[maps]\nheight = 1"),
        [
            "2:1 unknown-key unknown key `n_flim` in [material] (did you mean `n_film`?)",
            "4:10 unknown-value unknown value \"seen\" in [material] (known: `apparent`, `intrinsic`)",
            "3:11 out-of-range n_layer = 9 is out of range (allowed: 1 to 4)",
        ]
    );
}
