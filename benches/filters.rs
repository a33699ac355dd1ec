//! Filters at 1024 x 1024, and the `image` crate's blur beside ours: `cargo bench --bench filters`.
//!
//! `image` does not wrap its blur at the borders; the sigma and the data are the same.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use ophidian::base::{Domain, Plane, hash};
use ophidian::eval::{Input, run_node};
use ophidian::node::filter::{
    DirectionalBlur, Distance, EdgeDetect, GaussianBlur, Levels, Threshold, Transform, Warp,
};
use ophidian::node::{Assets, Node};

const SIZE: usize = 1024;
/// Standard deviation of the blurs, texels.
const SIGMA: f32 = 8.0;

fn filters(c: &mut Criterion) {
    let plane = Plane::from_fn(SIZE, SIZE, |x, y| {
        // Blotches with detail, so that masks have outlines to find.
        0.9 * hash::unit(hash::hash2(1, x as u32 / 40, y as u32 / 40))
            + 0.1 * hash::unit(hash::hash2(2, x as u32, y as u32))
    });
    let nodes: [(&str, Box<dyn Node>); 8] = [
        ("gaussian_blur", Box::new(GaussianBlur { radius: SIGMA / SIZE as f32 })),
        ("directional_blur", Box::new(DirectionalBlur::default())),
        ("levels", Box::new(Levels::default())),
        ("threshold", Box::new(Threshold::default())),
        ("edge_detect", Box::new(EdgeDetect::default())),
        ("distance", Box::new(Distance::default())),
        ("warp", Box::new(Warp::default())),
        ("transform", Box::new(Transform { angle: 30.0, ..Transform::default() })),
    ];
    let mut group = c.benchmark_group("filters");
    group.sample_size(10);
    for (name, node) in &nodes {
        group.bench_function(*name, |b| {
            b.iter(|| {
                let inputs = [Input::Plane(black_box(&plane))];
                run_node(&**node, &Domain::square(SIZE), 1, &inputs, &Assets::new(), 64)
            });
        });
    }
    let peer = image::ImageBuffer::<image::Luma<f32>, Vec<f32>>::from_raw(
        SIZE as u32,
        SIZE as u32,
        plane.data().to_vec(),
    )
    .expect("one value per texel");
    group.bench_function("gaussian_blur, image crate", |b| {
        b.iter(|| image::imageops::blur(black_box(&peer), SIGMA));
    });
    group.finish();
}

criterion_group!(benches, filters);
criterion_main!(benches);
