//! The path tracer: `cargo bench --bench render [-- FILTER]`.
//!
//! A coiled snake of 524,288 triangles with a film of 400 nm over an absorbing layer, one rectangular lamp and a sky, seen
//! at 960 x 540: criterion's throughput is pixels times samples in a second. Then, at 480 x 270, the mean square error
//! against 4096 samples per pixel beside the seconds that it took. The triangles are sorted beforehand.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use std::sync::Arc;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use ophidian::base::LinearRgb;
use ophidian::optics::layered::Constants;
use ophidian::reference::{Control, Film, Renderer, Settings, Transport};
use ophidian::scene::snake::Snake;
use ophidian::scene::{Camera, Environment, EnvironmentImage, Light, Material, Object, Scene};

fn scene() -> Scene {
    let mesh = Snake { triangles: 524_288, ..Snake::default() }.mesh().expect("a snake");
    let [low, high] = mesh.bounds();
    let (center, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
    let sky = EnvironmentImage::from_fn(512, 256, |d| {
        let up = 0.5 + 0.5 * d.y;
        LinearRgb([0.2 + 0.3 * up, 0.25 + 0.4 * up, 0.3 + 0.7 * up])
    });
    let u = Vec3::new(0.5, 0.0, -0.75) * radius * 0.5;
    let towards = Vec3::new(1.5, 2.0, 1.0);
    Scene {
        name: "bench".into(),
        mm_per_unit: 20.0,
        objects: vec![Object { name: "snake".into(), mesh, material: 0 }],
        materials: vec![Material {
            constants: Constants { absorption: [0.1, 0.2, 0.3], ..Constants::default() },
            color: LinearRgb([0.3, 0.2, 0.1]),
            roughness: 0.25,
            thickness_nm: 400.0,
            maps: None,
        }],
        camera: Camera {
            position: center + Vec3::new(0.0, 1.2, 1.5) * radius,
            target: center,
            up: Vec3::Y,
            field_of_view_rad: 0.7,
            aperture: 0.0,
            focus_distance: 1.0,
        },
        lights: vec![Light::Area {
            center: center + towards * radius,
            u,
            v: -towards.cross(u).normalize() * u.length(),
            radiance: LinearRgb([8.0; 3]),
        }],
        environment: Environment::Image(Arc::new(sky)),
        exposure_ev: 0.0,
    }
}

fn throughput(c: &mut Criterion) {
    let scene = scene();
    let renderer = Renderer::new(&scene).expect("sound");
    let mut group = c.benchmark_group("coil of 524288 triangles, 960x540");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    let settings = Settings { samples: 64, ..Settings::default() };
    group.throughput(Throughput::Elements(
        u64::from(settings.samples) * (settings.width * settings.height) as u64,
    ));
    let direct = Transport::Direct { environment_shadows: true };
    for (name, transport) in
        [("all light, four wavelengths", settings.transport), ("direct light, RGB", direct)]
    {
        let settings = Settings { transport, ..settings };
        // Tables are made at first use.
        renderer.render(&Settings { samples: 1, ..settings }, Control::default());
        group.bench_function(BenchmarkId::new(name, "64 spp"), |b| {
            b.iter(|| renderer.render(&settings, Control::default()));
        });
    }
    group.finish();

    // Only where the whole bench was asked for: it takes a minute.
    if std::env::args().all(|a| a.starts_with('-') || !a.contains("coil")) {
        errors(&renderer);
    }
}

fn errors(renderer: &Renderer<'_>) {
    let settings = Settings { width: 480, height: 270, seed: 1, ..Settings::default() };
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let exact = renderer.render(&Settings { samples: 4096, seed: 2, ..settings }, Control::default());
    for samples in [4, 16, 64, 256] {
        let start = Instant::now();
        let film = renderer.render(&Settings { samples, ..settings }, Control::default());
        let seconds = start.elapsed().as_secs_f64();
        println!("480x270, {samples:>3} spp: {seconds:.2} s, MSE {:.2e}", mse(&film, &exact));
    }
}

fn mse(film: &Film, exact: &Film) -> f64 {
    let (a, b) = (film.rgb(), exact.rgb());
    let sum: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    sum / (3 * a.len()) as f64
}

criterion_group!(benches, throughput);
criterion_main!(benches);
