//! The checks that every operation passes, by looping over the registry: see the node room's contract.

use std::sync::Arc;

use ophidian::base::simd::{self, Level};
use ophidian::base::{Domain, Plane, Rows};
use ophidian::eval::{Input, run_node};
use ophidian::graph::reference;
use ophidian::node::{
    self, Asset, Assets, Category, Cx, Fallback, InputSpec, Inputs, Node, Op, OutputKind, OutputSpec,
    Outputs, PortKind, Reach,
};
use rayon::prelude::*;

const SEED: u32 = 0x5eed;

/// Run `check` for every operation and fail with everything that is wrong with any.
fn for_every_op(check: impl Fn(&'static Op) -> Vec<String> + Sync) {
    let ops: Vec<&'static Op> = node::ops().collect();
    let failures: Vec<String> = ops
        .par_iter()
        .flat_map_iter(|op| {
            let started = std::time::Instant::now();
            let failures = check(op);
            if started.elapsed().as_secs() >= 5 {
                // Shown where the test fails or with --nocapture: who makes the suite slow.
                println!("{} took {:?}", op.spec.name, started.elapsed());
            }
            failures.into_iter().map(|f| format!("{}: {f}", op.spec.name))
        })
        .collect();
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

/// A node with one setting moved, and what was moved.
struct Variant {
    what: String,
    node: Arc<dyn Node>,
}

fn parse(op: &Op, settings: &toml::Table) -> Result<Arc<dyn Node>, String> {
    let text = toml::Value::Table(settings.clone()).to_string();
    let value = toml::de::ValueDeserializer::parse(&text).map_err(|e| e.to_string())?;
    (op.parse)(value).map_err(|e| format!("{e} in {text}"))
}

/// The default; each choice of each setting; and, with `ends`, each number at both ends of its range.
fn variants(op: &'static Op, ends: bool) -> Vec<Variant> {
    let mut settings = (op.default)().settings();
    let schema = (op.schema)();
    let docs = reference::settings(op);
    // A file's name: the one that `assets` has.
    for setting in docs.iter().filter(|s| s.kind == "text") {
        settings.insert(setting.name.clone(), toml::Value::String("test".into()));
    }
    // A model of pigment is solved on a grid of its own, thousands of times: the smallest shows as much.
    let model = op.spec.category == Category::Pattern;
    if model && settings.contains_key("cells") {
        settings.insert("cells".into(), 2.into());
    }
    let mut tables = vec![("default".to_owned(), settings.clone())];
    let mut put = |key: &str, value: toml::Value| {
        let mut table = settings.clone();
        let what = format!("{key} = {value}");
        table.insert(key.to_owned(), value);
        tables.push((what, table));
    };
    for setting in &docs {
        let key = setting.name.as_str();
        let property = schema.as_value().pointer(&format!("/properties/{key}"));
        let schemas =
            property.map(|p| ophidian::base::params::alternatives(schema.as_value(), p)).unwrap_or_default();
        match setting.kind.as_str() {
            "choice" => {
                let consts = schemas.iter().filter_map(|s| s.get("const")?.as_str());
                let enums = schemas.iter().filter_map(|s| s.get("enum")?.as_array()).flatten();
                for name in consts.chain(enums.filter_map(|v| v.as_str())) {
                    put(key, toml::Value::String(name.into()));
                }
            }
            "true or false" => {
                put(key, true.into());
                put(key, false.into());
            }
            "whole number" if model => {}
            "number" | "whole number" if ends => {
                let bound = |name: &str| schemas.iter().find_map(|s| s.get(name)?.as_i64());
                if let (Some(min), Some(max)) = (bound("minimum"), bound("maximum"))
                    && setting.kind == "whole number"
                    && max - min <= 8
                {
                    (min..=max).for_each(|n| put(key, n.into()));
                    continue;
                }
                for bound in ["minimum", "maximum"] {
                    let Some(bound) = schemas.iter().find_map(|s| s.get(bound)) else { continue };
                    let value = match bound.as_i64() {
                        Some(whole) if setting.kind == "whole number" => whole.into(),
                        _ => bound.as_f64().expect("a bound is a number").into(),
                    };
                    put(key, value);
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    for (what, table) in tables {
        let node = parse(op, &table).unwrap_or_else(|e| panic!("{}: {what}: {e}", op.spec.name));
        // Ends that contradict another setting are refused, as they should be.
        if node.check().is_empty() {
            found.push(Variant { what, node });
        }
    }
    found
}

fn assets() -> Assets {
    let channel = |k: usize| Plane::from_fn(7, 5, |x, y| ((x * 3 + y * 5 + k) % 11) as f32 / 10.0);
    let asset = Asset { channels: (0..3).map(channel).collect(), alpha: Some(channel(4)) };
    [("test".to_owned(), Arc::new(asset))].into()
}

/// Outputs that number things: they jump by design, also where the numbering begins.
const NUMBERS: [&str; 6] = ["id", "index", "row", "column", "phase", "random"];

/// Inputs that matter only where two settings are not at their defaults.
const NEEDS_TWO: [(&str, &str); 5] = [
    // A stripe along the body is the same everywhere along it, as long as nothing else changes it.
    ("body_stripe", "dv"),
    ("tile_sampler", "pattern_2"),
    ("tile_sampler", "pattern_3"),
    ("tile_sampler", "pattern_4"),
    ("tile_sampler", "pattern_distribution_map"),
];

/// Inputs that tell one scale or tile from another: the same value all over it.
const STEPS: [&str; 3] = ["id", "index", "random"];

/// Settings whose outputs are a saw over the tile by design.
const JUMPS: [(&str, &str); 6] = [
    // Its outputs are places: they begin again at the belly and at the end of the tile.
    ("body_position", "default"),
    ("linear_gradient", "profile = \"ramp\""),
    ("angular_gradient", "profile = \"ramp\""),
    ("tile_sampler", "color_parametrization_mode = \"row_index\""),
    ("tile_sampler", "color_parametrization_mode = \"column_index\""),
    ("tile_sampler", "color_parametrization_mode = \"center_position\""),
];

/// A tileable image within the range of an input, the same picture at any size: smooth, or steps for an identity.
fn probe(input: &InputSpec, index: usize, domain: &Domain) -> Plane {
    let (middle, swing) = match input.fallback {
        Fallback::Scalar(v) if input.min > f32::MIN => {
            let swing = (0.1 * (input.max - input.min)).min((0.5 * v.abs()).max(0.1));
            (v.clamp(input.min + swing, input.max - swing), swing)
        }
        Fallback::Scalar(v) => (v, 0.1),
        _ => (0.5, 0.4),
    };
    let k = index as f32;
    let wave = |t: f32| (std::f32::consts::TAU * t).sin();
    Plane::from_fn(domain.width, domain.height, |x, y| {
        let (u, v) = (domain.u(x), domain.v(y as i64));
        if input.name == "mask" && input.fallback == Fallback::Required {
            // Islands that do not touch, so that every size sees as many.
            return 0.5 + 0.4 * (wave(2.0 * u + 0.13 * k) * wave(2.0 * v + 0.07) - 0.3);
        }
        let a = wave(2.0 * u + v + 0.13 * k);
        let b = wave(u - 3.0 * v + 0.41 * k);
        if STEPS.contains(&input.name) {
            0.25 * (2.0 + a + b).floor()
        } else {
            middle + swing * 0.5 * (a + b)
        }
    })
}

/// The lanes of one input: three different ones for a colour, else the first is meant.
type Lanes = [Plane; 3];

fn lanes(input: &InputSpec, index: usize, domain: &Domain) -> Lanes {
    let used = |k: usize| k == 0 || input.kind == PortKind::Color;
    std::array::from_fn(|k| if used(k) { probe(input, index + 3 * k, domain) } else { Plane::default() })
}

fn probes(node: &dyn Node, domain: &Domain) -> Vec<Lanes> {
    node.spec().inputs.iter().enumerate().map(|(i, input)| lanes(input, i, domain)).collect()
}

fn input<'a>(spec: &InputSpec, lanes: &'a Lanes) -> Input<'a> {
    match spec.kind {
        PortKind::Color => Input::Color(lanes.each_ref()),
        _ => Input::Plane(&lanes[0]),
    }
}

fn run(node: &dyn Node, domain: &Domain, planes: &[Lanes], band: usize) -> Vec<Plane> {
    let inputs: Vec<Input<'_>> = node.spec().inputs.iter().zip(planes).map(|(s, p)| input(s, p)).collect();
    run_node(node, domain, SEED, &inputs, &assets(), band)
}

/// The name of each output lane.
fn lane_names(op: &Op) -> Vec<&'static str> {
    let lanes = |o: &OutputSpec| if o.kind == OutputKind::Color { 3 } else { 1 };
    op.spec.outputs.iter().flat_map(|o| std::iter::repeat_n(o.name, lanes(o))).collect()
}

fn bits(planes: &[Plane]) -> Vec<u32> {
    planes.iter().flat_map(|p| p.data()).map(|v| v.to_bits()).collect()
}

/// Greatest minus least value.
fn spread(plane: &Plane) -> f32 {
    let (low, high) =
        plane.data().iter().fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    high - low
}

/// Root mean square of the difference, in units of the first plane's spread (or of 1, where that is nothing).
fn difference(a: &Plane, b: &Plane) -> f32 {
    let sum: f64 = a.data().iter().zip(b.data()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let spread = spread(a);
    (sum / a.data().len() as f64).sqrt() as f32 / if spread > 1e-6 { spread } else { 1.0 }
}

#[test]
fn every_declaration_is_complete() {
    for_every_op(|op| {
        let spec = op.spec;
        let mut failures = Vec::new();
        let mut fail = |what: String| failures.push(what);
        let snake = |name: &str| {
            let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            !name.is_empty() && name.chars().all(fine)
        };
        let sentence = |text: &str| text.len() > 3 && text.ends_with(['.', '?', '!', ')']);
        let settings = reference::settings(op);
        let names: Vec<&str> =
            spec.inputs.iter().map(|i| i.name).chain(settings.iter().map(|s| s.name.as_str())).collect();
        for name in std::iter::once(&spec.name).chain(&names) {
            if !snake(name) || *name == "op" {
                fail(format!("bad name {name:?}"));
            }
        }
        let mut sorted = names.clone();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted.len() != names.len() {
            fail(format!("two of the same name among {names:?}"));
        }
        if node::ops().filter(|other| other.spec.name == spec.name).count() != 1 {
            fail("the name is taken twice".into());
        }
        if spec.outputs.is_empty() || !sentence(spec.summary) {
            fail(format!("no outputs, or a summary that is no sentence: {:?}", spec.summary));
        }
        for input in spec.inputs {
            if !sentence(input.doc) {
                fail(format!("input {} has no doc: {:?}", input.name, input.doc));
            }
            let fallback = match input.fallback {
                Fallback::Scalar(v) => v >= input.min && v <= input.max,
                _ => true,
            };
            if input.min.partial_cmp(&input.max) != Some(std::cmp::Ordering::Less) || !fallback {
                fail(format!("input {}: {:?} in {} to {}", input.name, input.fallback, input.min, input.max));
            }
        }
        for output in spec.outputs {
            if !snake(output.name) || !sentence(output.doc) {
                fail(format!("output {} has no doc: {:?}", output.name, output.doc));
            }
        }
        let schema = (op.schema)();
        for setting in &settings {
            if !sentence(&setting.doc) {
                fail(format!("setting {} has no doc: {:?}", setting.name, setting.doc));
            }
            if setting.default.is_empty() {
                fail(format!("setting {} has no default", setting.name));
            }
            let numeric = ["number", "whole number"].contains(&setting.kind.as_str());
            if numeric && !setting.range.contains(" to ") {
                fail(format!("setting {} has no range: {:?}", setting.name, setting.range));
            }
        }
        let node = (op.default)();
        for error in ophidian::node::params::check_ranges(&schema, &node.settings()) {
            fail(format!("the default is out of range: {error}"));
        }
        for error in node.check() {
            fail(format!("the default is refused: {error}"));
        }
        if !(node.cost_ns() > 0.0 && node.cost_ns().is_finite()) {
            fail(format!("cost {} ns", node.cost_ns()));
        }
        failures
    });
}

#[test]
fn settings_survive_being_written_and_read() {
    for_every_op(|op| {
        let mut failures = Vec::new();
        for variant in variants(op, true) {
            let written = variant.node.settings();
            match parse(op, &written) {
                Ok(read)
                    if read.settings() == written && format!("{read:?}") == format!("{:?}", variant.node) => {
                }
                Ok(read) => failures.push(format!("{}: {:?} became {read:?}", variant.what, variant.node)),
                Err(error) => failures.push(format!("{}: {error}", variant.what)),
            }
        }
        failures
    });
}

#[test]
fn outputs_are_finite_for_any_finite_input_and_setting() {
    let wide = Domain { width: 12, height: 9, girth_mm: 40.0, length_mm: 30.0 };
    let one = Domain { width: 1, height: 1, girth_mm: 40.0, length_mm: 30.0 };
    for_every_op(|op| {
        let mut failures = Vec::new();
        for (v, variant) in variants(op, true).iter().enumerate() {
            let node = variant.node.as_ref();
            let constant = |f: &dyn Fn(&InputSpec) -> f32, domain: &Domain| -> Vec<Lanes> {
                let plane =
                    |i: &InputSpec| std::array::from_fn(|_| Plane::filled(domain.width, domain.height, f(i)));
                node.spec().inputs.iter().map(plane).collect()
            };
            for domain in [wide, one] {
                if v > 0 && domain == one && op.spec.category == Category::Place {
                    continue;
                }
                let ramp = |k: f32| -> Vec<Lanes> {
                    let at = |x: usize, y: usize| {
                        k * (x as f32 + 1.0) * if (x + y).is_multiple_of(2) { 1.0 } else { -1.0 }
                    };
                    let plane = || Plane::from_fn(domain.width, domain.height, at);
                    node.spec().inputs.iter().map(|_| std::array::from_fn(|_| plane())).collect()
                };
                let mut tried = vec![
                    ("probes", probes(node, &domain)),
                    ("0", constant(&|_| 0.0, &domain)),
                    ("1e30", constant(&|_| 1e30, &domain)),
                    ("least", constant(&|i| i.min.max(-1e30), &domain)),
                    ("greatest", constant(&|i| i.max.min(1e30), &domain)),
                ];
                // A lattice at the end of its range has a million scales.
                let dear = v > 0 && op.spec.category == Category::Place;
                if dear {
                    tried.truncate(3);
                } else if v == 0 || node.spec().inputs.len() < 6 {
                    tried.extend([
                        ("1", constant(&|_| 1.0, &domain)),
                        ("-1e30", constant(&|_| -1e30, &domain)),
                        ("denormal", constant(&|_| 1e-40, &domain)),
                        ("ramp", ramp(0.3)),
                        ("ramp of 1e29", ramp(1e29)),
                        ("ramp of denormals", ramp(1e-41)),
                    ]);
                }
                for (what, planes) in tried {
                    for (lane, out) in run(node, &domain, &planes, 0).iter().enumerate() {
                        if let Some(bad) = out.data().iter().find(|v| !v.is_finite()) {
                            let size = domain.width;
                            failures.push(format!(
                                "{}, inputs {what}, width {size}: lane {lane} is {bad}",
                                variant.what
                            ));
                        }
                    }
                }
            }
        }
        failures
    });
}

#[test]
fn bands_of_any_height_give_the_same_bits() {
    let domain = Domain { width: 37, height: 29, girth_mm: 74.0, length_mm: 58.0 };
    for_every_op(|op| {
        let mut failures = Vec::new();
        for variant in variants(op, false) {
            let node = variant.node.as_ref();
            let planes = probes(node, &domain);
            let whole = bits(&run(node, &domain, &planes, 0));
            for band in [1, 7] {
                if bits(&run(node, &domain, &planes, band)) != whole {
                    failures.push(format!("{}: bands of {band} rows differ", variant.what));
                }
            }
        }
        failures
    });
}

#[test]
fn every_simd_level_gives_the_same_bits() {
    let _alone = crate::made::LEVEL.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let domain = Domain { width: 61, height: 23, girth_mm: 61.0, length_mm: 23.0 };
    let all = |level: Level| -> Vec<(String, Vec<u32>)> {
        simd::force(level);
        node::ops()
            .flat_map(|op| variants(op, false).into_iter().map(move |v| (op, v)))
            .map(|(op, v)| {
                let out = run(v.node.as_ref(), &domain, &probes(v.node.as_ref(), &domain), 0);
                (format!("{} {}", op.spec.name, v.what), bits(&out))
            })
            .collect()
    };
    let base = all(Level::Baseline);
    for level in Level::ALL {
        for ((what, a), (_, b)) in base.iter().zip(all(level)) {
            assert!(*a == b, "{what} differs at {level:?}");
        }
    }
    simd::force(Level::Avx512);
}

#[test]
fn an_output_written_over_its_input_has_the_same_bits() {
    let domain = Domain { width: 150, height: 4, girth_mm: 150.0, length_mm: 4.0 };
    let found = std::sync::atomic::AtomicUsize::new(0);
    for_every_op(|op| {
        let mut failures = Vec::new();
        for variant in variants(op, true) {
            let node = variant.node.as_ref();
            let Some(over) = node.overwrites() else { continue };
            found.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let images = probes(node, &domain);
            // Every other input as an image, and as a number: its first texel.
            for numbers in [false, true] {
                let input = |i: usize| match numbers && i != over {
                    true => Input::Value(images[i][0].data()[0]),
                    false => Input::Plane(&images[i][0]),
                };
                let inputs: Vec<_> = (0..images.len()).map(input).collect();
                let apart = run_node(node, &domain, SEED, &inputs, &assets(), 0).remove(0);
                let constants: Vec<_> = images.iter().map(|i| vec![i[0].data()[0]; domain.width]).collect();
                let lane = |i: usize| match numbers {
                    _ if i == over => Rows::window(&[], domain.width, domain.height, 0),
                    true => Rows::broadcast(&constants[i]),
                    false => images[i][0].rows(),
                };
                let lanes: Vec<_> = (0..images.len()).map(lane).collect();
                let offsets: Vec<_> = (0..=images.len()).collect();
                let mut own = images[over][0].clone();
                let mut outs =
                    Outputs::new(&[0, 1], [Some(own.data_mut())].into_iter().collect(), domain.width, 0);
                let cx = Cx { domain, seed: SEED, assets: &assets(), prepared: None };
                let ins = Inputs::new(&offsets, &lanes).over(Some(over));
                node.eval(&cx, 0..domain.height as i64, &ins, &mut outs);
                drop(outs);
                if bits(&[own]) != bits(&[apart]) {
                    failures.push(format!("{} numbers {numbers}", variant.what));
                }
            }
        }
        failures
    });
    assert!(found.into_inner() >= 10, "nodes that write over an input");
}

#[test]
fn a_node_reads_no_further_than_it_says() {
    let domain = Domain { width: 64, height: 48, girth_mm: 64.0, length_mm: 48.0 };
    let (px, py) = (5_i64, 45_i64);
    let far = |a: i64, b: i64, n: i64| {
        let d = (a - b).rem_euclid(n);
        d.min(n - d) as usize
    };
    for_every_op(|op| {
        let mut failures = Vec::new();
        for variant in variants(op, false) {
            let node = variant.node.as_ref();
            let reach = match node.reach(&domain) {
                Reach::Point => Some((0, 0)),
                Reach::Around { x, y } => Some((x, y)),
                Reach::Anywhere | Reach::Whole => None,
            };
            let planes = probes(node, &domain);
            let before = run(node, &domain, &planes, 0);
            for (i, input) in op.spec.inputs.iter().enumerate() {
                // One texel: it may matter only near by.
                let Some((rx, ry)) = reach else { continue };
                let mut poked = planes.clone();
                let at = py as usize * domain.width + px as usize;
                for lane in poked[i].iter_mut().filter(|lane| lane.width() > 0) {
                    let value = lane.data()[at];
                    lane.data_mut()[at] += if value > 0.5 { -0.37 } else { 0.37 };
                }
                for (a, b) in before.iter().zip(run(node, &domain, &poked, 0)) {
                    let changed =
                        (0..domain.texels()).filter(|&k| a.data()[k].to_bits() != b.data()[k].to_bits());
                    let outside = changed
                        .map(|k| (k % domain.width, k / domain.width))
                        .find(|&(x, y)| far(x as i64, px, 64) > rx || far(y as i64, py, 48) > ry);
                    if let Some((x, y)) = outside {
                        let what = &variant.what;
                        let name = input.name;
                        failures.push(format!(
                            "{what}: {name} at ({px}, {py}) changes ({x}, {y}), beyond {rx} x {ry}"
                        ));
                        break;
                    }
                }
            }
        }
        failures
    });
}

#[test]
fn every_input_matters() {
    let domain = Domain { width: 48, height: 32, girth_mm: 48.0, length_mm: 32.0 };
    for_every_op(|op| {
        let mut open: Vec<usize> = (0..op.spec.inputs.len()).collect();
        open.retain(|&i| !NEEDS_TWO.contains(&(op.spec.name, op.spec.inputs[i].name)));
        // The two simplest sets of variants first: most inputs matter in the default already.
        for variant in variants(op, false).into_iter().chain(variants(op, true)) {
            if open.is_empty() {
                break;
            }
            let node = variant.node.as_ref();
            let planes = probes(node, &domain);
            let before = bits(&run(node, &domain, &planes, 0));
            open.retain(|&i| {
                let spec = &op.spec.inputs[i];
                let wide = |k: usize, sign: f32| {
                    let mut plane = probe(spec, i + k, &domain);
                    plane
                        .data_mut()
                        .iter_mut()
                        .for_each(|v| *v = (sign * 20.0 * (*v - 0.5)).clamp(spec.min, spec.max));
                    plane
                };
                let others: [Lanes; 3] = [
                    lanes(spec, i + 7, &domain),
                    std::array::from_fn(|k| wide(k, 1.0)),
                    std::array::from_fn(|k| wide(k, -1.0)),
                ];
                others.into_iter().all(|other| {
                    let mut changed = planes.clone();
                    changed[i] = other;
                    bits(&run(node, &domain, &changed, 0)) == before
                })
            });
        }
        open.into_iter().map(|i| format!("input {} changes nothing", op.spec.inputs[i].name)).collect()
    });
}

#[test]
fn a_shift_on_the_torus_shifts_the_output() {
    let domain = Domain { width: 80, height: 48, girth_mm: 80.0, length_mm: 48.0 };
    for_every_op(|op| {
        let mut failures = Vec::new();
        let offsets = op.spec.input("du").zip(op.spec.input("dv"));
        for variant in variants(op, false) {
            let node = variant.node.as_ref();
            let (before, after, dx, dy) = match offsets {
                // A generator: another place of evaluation.
                Some((du, dv)) if op.spec.positional => {
                    let mut inputs = vec![Input::Unset; op.spec.inputs.len()];
                    let before = run_node(node, &domain, SEED, &inputs, &assets(), 0);
                    inputs[du] = Input::Value(0.25);
                    inputs[dv] = Input::Value(-0.125);
                    (before, run_node(node, &domain, SEED, &inputs, &assets(), 0), -20, 6)
                }
                _ if op.spec.positional || op.spec.random => continue,
                _ => {
                    let planes = probes(node, &domain);
                    let shifted: Vec<Lanes> =
                        planes.iter().map(|lanes| lanes.each_ref().map(|p| p.shifted(-20, 6))).collect();
                    (run(node, &domain, &planes, 0), run(node, &domain, &shifted, 0), -20, 6)
                }
            };
            for (lane, (a, b)) in before.iter().zip(&after).enumerate() {
                let d = difference(&a.shifted(dx, dy), b);
                if d > 2e-3 {
                    failures.push(format!("{}: lane {lane} differs by {d}", variant.what));
                }
            }
        }
        failures
    });
}

/// Mean step between neighbouring columns: greatest inside, and across the seam.
fn steps(p: &Plane) -> (f64, f64) {
    let step = |x: i64| -> f64 {
        let rows = 0..p.height() as i64;
        rows.map(|y| f64::from((p.at(x + 1, y) - p.at(x, y)).abs())).sum::<f64>() / p.height() as f64
    };
    let inside = (0..p.width() as i64 - 1).map(step).fold(0.0, f64::max);
    (inside, step(p.width() as i64 - 1))
}

#[test]
fn generators_are_continuous_over_the_seam() {
    let domain = Domain { width: 96, height: 64, girth_mm: 96.0, length_mm: 64.0 };
    for_every_op(|op| {
        let mut failures = Vec::new();
        if !op.spec.positional && !op.spec.random {
            return failures;
        }
        for variant in variants(op, false) {
            let node = variant.node.as_ref();
            // What artists do not drive stays as it is: only images are needed.
            let planes = probes(node, &domain);
            let required = op.spec.inputs.iter().zip(&planes).map(|(spec, p)| match spec.fallback {
                Fallback::Required => input(spec, p),
                _ => Input::Unset,
            });
            let inputs: Vec<Input<'_>> = required.collect();
            if JUMPS.contains(&(op.spec.name, variant.what.as_str())) {
                continue;
            }
            let outs = run_node(node, &domain, SEED, &inputs, &assets(), 0);
            for (lane, out) in
                lane_names(op).into_iter().zip(&outs).filter(|(name, _)| !NUMBERS.contains(name))
            {
                let turned = Plane::from_fn(out.height(), out.width(), |x, y| out.at(y as i64, x as i64));
                for (seam, p) in [("u", out), ("v", &turned)] {
                    let (inside, across) = steps(p);
                    if across > 1.5 * inside + 1e-6 * f64::from(spread(out)) {
                        let what = &variant.what;
                        failures.push(format!(
                            "{what}: lane {lane} steps {across} over the {seam} seam, {inside} inside"
                        ));
                    }
                }
            }
        }
        failures
    });
}

#[test]
fn the_same_picture_at_256_and_1024() {
    for_every_op(|op| {
        let node = (op.default)();
        let mut failures = Vec::new();
        // A model of pigment takes many passes: same claim at a quarter of the size.
        let size = if op.spec.category == Category::Pattern { 64 } else { 256 };
        let grid = |n: usize| Domain { width: n, height: n, girth_mm: 60.0, length_mm: 60.0 };
        let (low, high) = (grid(size), grid(4 * size));
        let coarse = run(node.as_ref(), &low, &probes(node.as_ref(), &low), 0);
        let fine = run(node.as_ref(), &high, &probes(node.as_ref(), &high), 0);
        for (lane, (a, b)) in coarse.iter().zip(&fine).enumerate() {
            let d = difference(a, &b.halved().halved());
            if d > op.spec.scale_tolerance {
                failures.push(format!("lane {lane} differs by {d}, allowed {}", op.spec.scale_tolerance));
            }
        }
        failures
    });
}

/// The measures above must be able to fail.
#[test]
fn the_measures_see_what_they_should() {
    let saw = Plane::from_fn(32, 32, |x, _| x as f32);
    let (inside, across) = steps(&saw);
    assert!(across > 10.0 * inside);
    let other = saw.shifted(1, 0);
    assert!(difference(&saw, &other) > 0.1 && difference(&saw, &saw) == 0.0);
    let mix = node::find("mix").expect("mix");
    assert!(variants(mix, true).len() == 1);
}
