//! Every operation of the registry at its default settings: `cargo bench --bench nodes [-- FILTER]`.
//!
//! Required inputs read noise, the others their defaults; every output is wanted; one thread. 256 x 256 texels, and
//! 2048 x 2048 as well where `OPHIDIAN_BENCH_LARGE` is set; at each SIMD level that this machine has where
//! `OPHIDIAN_BENCH_LEVELS` is set.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use ophidian::base::simd::{self, Level};
use ophidian::base::{Domain, Plane};
use ophidian::eval::{Input, run_node};
use ophidian::node::generate::Fractal;
use ophidian::node::{Assets, Fallback, PortKind, ops};

fn nodes(c: &mut Criterion) {
    let [large, levels] =
        ["OPHIDIAN_BENCH_LARGE", "OPHIDIAN_BENCH_LEVELS"].map(|name| std::env::var_os(name).is_some());
    for size in [256, 2048].into_iter().take(if large { 2 } else { 1 }) {
        let domain = Domain::square(size);
        let noise: Vec<Plane> = (0..3)
            .flat_map(|seed| {
                run_node(&Fractal::default(), &domain, seed, &[], &Assets::new(), 0).into_iter().take(1)
            })
            .collect();
        let mut group = c.benchmark_group("nodes");
        group
            .throughput(Throughput::Elements((size * size) as u64))
            .sample_size(10)
            .sampling_mode(SamplingMode::Flat)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_secs(1));
        for op in ops() {
            let node = (op.default)();
            let inputs: Vec<Input<'_>> = op
                .spec
                .inputs
                .iter()
                .map(|input| match (input.fallback, input.kind) {
                    (Fallback::Required, PortKind::Color) => Input::Color([&noise[0], &noise[1], &noise[2]]),
                    (Fallback::Required, _) => Input::Plane(&noise[0]),
                    _ => Input::Unset,
                })
                .collect();
            let mut bench = |id| {
                group.bench_function(id, |b| {
                    b.iter(|| run_node(black_box(&*node), &domain, 1, &inputs, &Assets::new(), 64));
                });
            };
            if !levels {
                bench(BenchmarkId::new(op.spec.name, size));
                continue;
            }
            for level in Level::ALL.into_iter().filter(|level| simd::force(*level) == *level) {
                bench(BenchmarkId::new(op.spec.name, format!("{size}/{}", level.name())));
            }
        }
        group.finish();
    }
    simd::force(Level::Avx512);
}

criterion_group!(benches, nodes);
criterion_main!(benches);
