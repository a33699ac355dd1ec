//! Presets end to end, 512 texels on the longer side: `cargo bench --bench presets [-- FILTER]`.
//!
//! Each step of `ophidian generate` apart (plan; evaluate and write the five maps of the thesis as PNG), on one thread
//! and on all. In the same run, on the same number of texels, what two known crates take for one octave sum and one
//! blur, beside ours.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use noise::{MultiFractal, NoiseFn};
use ophidian::base::{Domain, MapKind};
use ophidian::eval::{self, Control, Input, run_node};
use ophidian::graph::{self, Graph};
use ophidian::io::{WriteOptions, write_set};
use ophidian::maps::{SetId, TextureSet, assemble};
use ophidian::node::Assets;
use ophidian::node::filter::GaussianBlur;
use ophidian::node::generate::{Basis, Fractal, Sum};
use ophidian::plan::Plan;
use ophidian::preset::builtin;
use rayon::ThreadPoolBuilder;

const SIZE: usize = 512;
const PRESETS: [&str; 3] = ["lampropeltis_triangulum", "python_regius", "xenopeltis_unicolor"];
/// Standard deviation of the blurs, texels.
const SIGMA: f32 = 8.0;

fn read(name: &str) -> Graph {
    let document = builtin::document(name).expect("a built-in preset");
    graph::from_document(&document, None).expect("a sound preset")
}

fn plan(graph: &Graph) -> Plan {
    let domain = Domain::from_longer_side(SIZE, graph.girth_mm, graph.length_mm);
    Plan::new(graph, &MapKind::FIVE, domain, None).expect("without a budget any size is planned")
}

fn texture_set(graph: &Graph, plan: &Plan) -> TextureSet {
    let evaluation = eval::run(plan, Control::default()).expect("nobody cancels");
    assemble(evaluation, SetId::new(graph, plan.domain))
}

fn presets(c: &mut Criterion) {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let dir = tempfile::tempdir().expect("a directory for files");
    let mut group = c.benchmark_group("presets");
    group.sample_size(10);
    for name in PRESETS {
        group.bench_function(BenchmarkId::new("read", name), |b| b.iter(|| read(black_box(name))));
        let graph = read(name);
        group.bench_function(BenchmarkId::new("plan", name), |b| b.iter(|| plan(black_box(&graph))));
        let plan = plan(&graph);
        let set = texture_set(&graph, &plan);
        for threads in [1, all].into_iter().take(if all > 1 { 2 } else { 1 }) {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            group.bench_function(BenchmarkId::new(format!("evaluate/{threads} threads"), name), |b| {
                b.iter(|| pool.install(|| eval::run(black_box(&plan), Control::default())));
            });
            group.bench_function(BenchmarkId::new(format!("write/{threads} threads"), name), |b| {
                let options = WriteOptions::default();
                b.iter(|| pool.install(|| write_set(black_box(&set), dir.path(), &options, &|_| {})));
            });
        }
    }
    group.finish();
}

fn peers(c: &mut Criterion) {
    let domain = Domain::square(SIZE);
    let assets = Assets::new();
    let mut group = c.benchmark_group("peers");
    group.sample_size(10);

    let fractal = Fractal {
        basis: Basis::Perlin,
        sum: Sum::Fbm,
        cells_u: 16,
        cells_v: 16,
        octaves: 6,
        ..Fractal::default()
    };
    group.bench_function("fbm/ours", |b| {
        b.iter(|| run_node(black_box(&fractal), &domain, 1, &[], &assets, 64));
    });
    let fbm = noise::Fbm::<noise::Perlin>::new(1).set_octaves(6).set_frequency(1.0);
    group.bench_function("fbm/crate noise", |b| {
        let scale = 16.0 / SIZE as f64;
        let at = |i: usize| (i as f64 + 0.5) * scale;
        b.iter(|| -> Vec<f32> {
            (0..SIZE * SIZE).map(|i| black_box(&fbm).get([at(i % SIZE), at(i / SIZE)]) as f32).collect()
        });
    });

    let plane = run_node(&fractal, &domain, 1, &[], &assets, 0).swap_remove(0);
    let blur = GaussianBlur { radius: SIGMA / SIZE as f32 };
    group.bench_function("gaussian_blur/ours", |b| {
        b.iter(|| run_node(&blur, &domain, 1, &[Input::Plane(black_box(&plane))], &assets, 64));
    });
    let buffer: image::ImageBuffer<image::Luma<f32>, Vec<f32>> =
        image::ImageBuffer::from_raw(SIZE as u32, SIZE as u32, plane.data().to_vec())
            .expect("one value per texel");
    group.bench_function("gaussian_blur/crate image", |b| {
        b.iter(|| image::imageops::blur(black_box(&buffer), SIGMA));
    });
    group.finish();
}

criterion_group!(benches, presets, peers);
criterion_main!(benches);
