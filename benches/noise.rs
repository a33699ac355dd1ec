//! Noise nodes and, in the same run, the `noise` crate's (f64, one point at a time, not periodic).
//!
//! One thread, 16 cells per side, six octaves where there are octaves.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use noise::{MultiFractal, NoiseFn};
use ophidian::base::Domain;
use ophidian::base::simd::{self, Level};
use ophidian::eval::run_node;
use ophidian::node::generate::{
    Basis, BlueNoise, Fractal, Metric, PerlinNoise, SimplexNoise, Sum, ValueNoise, WhiteNoise, Worley,
};
use ophidian::node::{Assets, Node};

const CELLS: u32 = 16;

fn ours() -> Vec<(&'static str, Box<dyn Node>)> {
    let (cells_u, cells_v) = (CELLS, CELLS);
    let fractal = |basis, sum| Fractal { basis, sum, cells_u, cells_v, octaves: 6, ..Fractal::default() };
    let worley = |metric| Worley { cells_u, cells_v, metric, jitter: 1.0 };
    vec![
        ("value", Box::new(ValueNoise { cells_u, cells_v })),
        ("perlin", Box::new(PerlinNoise { cells_u, cells_v })),
        ("simplex", Box::new(SimplexNoise { cells_u, cells_v })),
        ("white", Box::new(WhiteNoise { cells_u, cells_v })),
        ("blue_64", Box::new(BlueNoise { cells_u: 64, cells_v: 64 })),
        ("worley_euclidean", Box::new(worley(Metric::Euclidean))),
        ("worley_manhattan", Box::new(worley(Metric::Manhattan))),
        ("fbm_perlin", Box::new(fractal(Basis::Perlin, Sum::Fbm))),
        ("ridged_perlin", Box::new(fractal(Basis::Perlin, Sum::Ridged))),
        ("fbm_simplex", Box::new(fractal(Basis::Simplex, Sum::Fbm))),
    ]
}

fn theirs() -> Vec<(&'static str, Box<dyn NoiseFn<f64, 2>>)> {
    vec![
        ("value", Box::new(noise::Value::new(1))),
        ("perlin", Box::new(noise::Perlin::new(1))),
        ("simplex", Box::new(noise::OpenSimplex::new(1))),
        (
            "worley_euclidean",
            Box::new(noise::Worley::new(1).set_return_type(noise::core::worley::ReturnType::Distance)),
        ),
        ("fbm_perlin", Box::new(noise::Fbm::<noise::Perlin>::new(1).set_octaves(6).set_frequency(1.0))),
        (
            "ridged_perlin",
            Box::new(noise::RidgedMulti::<noise::Perlin>::new(1).set_octaves(6).set_frequency(1.0)),
        ),
    ]
}

/// The whole plane by the crate, in f32 like ours.
fn fill(source: &dyn NoiseFn<f64, 2>, size: usize) -> Vec<f32> {
    let scale = f64::from(CELLS) / size as f64;
    let mut out = Vec::with_capacity(size * size);
    for y in 0..size {
        for x in 0..size {
            out.push(source.get([(x as f64 + 0.5) * scale, (y as f64 + 0.5) * scale]) as f32);
        }
    }
    out
}

fn benches(c: &mut Criterion) {
    for size in [256, 1024] {
        let mut group = c.benchmark_group("noise");
        group.throughput(Throughput::Elements((size * size) as u64)).sample_size(10);
        let domain = Domain::square(size);
        let assets = Assets::new();
        for (name, node) in ours() {
            group.bench_function(BenchmarkId::new(name, size), |b| {
                b.iter(|| run_node(black_box(&*node), &domain, 1, &[], &assets, 64));
            });
        }
        for (name, source) in theirs() {
            group.bench_function(BenchmarkId::new(format!("{name}/crate_noise"), size), |b| {
                b.iter(|| fill(black_box(&*source), size));
            });
        }
        group.finish();
    }
}

/// The goals of the kernels, at each SIMD level that this machine has: `cargo bench --bench noise -- simd`.
fn levels(c: &mut Criterion) {
    const SIZE: usize = 2048;
    let mut group = c.benchmark_group("simd");
    group.throughput(Throughput::Elements((SIZE * SIZE) as u64)).sample_size(10);
    let (domain, assets) = (Domain::square(SIZE), Assets::new());
    for (name, node) in ours() {
        if !["perlin", "fbm_perlin", "fbm_simplex", "worley_euclidean"].contains(&name) {
            continue;
        }
        for level in Level::ALL {
            if simd::force(level) == level {
                group.bench_function(BenchmarkId::new(name, level.name()), |b| {
                    b.iter(|| run_node(black_box(&*node), &domain, 1, &[], &assets, 64));
                });
            }
        }
    }
    simd::force(Level::Avx512);
    group.finish();
}

criterion_group!(noise_benches, benches, levels);
criterion_main!(noise_benches);
