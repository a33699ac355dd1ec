//! Pictures whose pixels are known in closed form, and what must not change them.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec2, Vec3, Vec4};

use super::*;
use crate::base::{LinearRgb, simd};
use crate::optics::layered::{Albedo, Constants};
use crate::optics::{Film as ThinFilm, FilmColor, Method};
use crate::scene::{Camera, Environment, Light, Material, Mesh, Object, Scene};

/// A square of side 2 `half` at y = 0 that faces up.
pub(super) fn floor(half: f32) -> Mesh {
    let at = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    Mesh {
        positions: vec![at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)],
        normals: vec![Vec3::Y; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Nothing reflects but a white matt base.
pub(super) fn matt() -> Constants {
    Constants { indices: [1.0; 3], albedo: Albedo::Intrinsic, ..Constants::default() }
}

pub(super) fn skin(constants: Constants, albedo: f32, roughness: f32, thickness_nm: f32) -> Material {
    Material { constants, color: LinearRgb([albedo; 3]), roughness, thickness_nm, maps: None }
}

/// A floor seen from straight above, from so far that all of the picture is its middle.
pub(super) fn scene(material: Material, lights: Vec<Light>, radiance: f32) -> Scene {
    Scene {
        name: "floor".into(),
        mm_per_unit: 1.0,
        objects: vec![Object { name: "floor".into(), mesh: floor(1.0), material: 0 }],
        materials: vec![material],
        camera: Camera {
            position: Vec3::new(0.0, 2.0, 0.0),
            target: Vec3::ZERO,
            up: Vec3::Z,
            field_of_view_rad: 0.002,
            aperture: 0.0,
            focus_distance: 2.0,
        },
        lights,
        environment: Environment::Constant(LinearRgb([radiance; 3])),
        exposure_ev: 0.0,
    }
}

fn settings(samples: u32) -> Settings {
    Settings { width: 8, height: 8, samples, ..Settings::default() }
}

/// Mean colour of a picture, and its standard error.
fn mean(scene: &Scene, settings: &Settings) -> ([f64; 3], f64) {
    let film = Renderer::new(scene).expect("sound").render(settings, Control::default());
    let n = film.pixels.len() as f64;
    let rgb = film.rgb();
    let mean = std::array::from_fn(|c| rgb.iter().map(|p| f64::from(p[c])).sum::<f64>() / n);
    (mean, film.noise() / n.sqrt())
}

/// Whether every channel of the picture's mean is what it should be, but for noise and rounding; else what it is.
fn compare(scene: &Scene, settings: &Settings, expected: [f64; 3]) -> Result<(), String> {
    let (mean, error) = mean(scene, settings);
    let near = |c: usize| (mean[c] - expected[c]).abs() < 4.0 * error + 2e-5 * expected[c].abs() + 1e-7;
    if (0..3).all(near) {
        return Ok(());
    }
    Err(format!("{mean:?} for {expected:?}, noise {error}, {settings:?}"))
}

fn close(scene: &Scene, settings: &Settings, expected: [f64; 3]) {
    compare(scene, settings, expected).unwrap();
}

#[test]
fn a_matt_floor_under_one_light_has_the_radiance_of_the_cosine_law() {
    let direction = Vec3::new(0.6, 0.8, 0.0);
    for angular_radius_rad in [0.0, 0.005] {
        let light = Light::Directional { direction, irradiance: LinearRgb([2.0; 3]), angular_radius_rad };
        let scene = scene(skin(matt(), 0.5, 0.3, 0.0), vec![light], 0.0);
        let expected = [0.5 / std::f64::consts::PI * 2.0 * 0.8; 3];
        close(
            &scene,
            &Settings { transport: Transport::Direct { environment_shadows: true }, ..settings(4) },
            expected,
        );
        close(&scene, &settings(256), expected);
    }
}

#[test]
fn a_rectangle_overhead_gives_the_irradiance_of_its_form_factor() {
    // A rectangle 2a x 2b at distance h, parallel, seen from below its middle: four times the form factor of a corner
    // (Modest, Radiative Heat Transfer, configuration 11).
    let (a, b, h) = (0.7f64, 0.4f64, 1.1f64);
    let corner = |x: f64, y: f64| {
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * std::f64::consts::PI)
    };
    let factor = 4.0 * corner(a / h, b / h);
    let light = Light::Area {
        center: Vec3::new(0.0, h as f32, 0.0),
        u: Vec3::new(a as f32, 0.0, 0.0),
        // u x v down.
        v: Vec3::new(0.0, 0.0, b as f32),
        radiance: LinearRgb([3.0; 3]),
    };
    // The eye below the lamp.
    let mut scene = scene(skin(matt(), 0.8, 0.3, 0.0), vec![light], 0.0);
    scene.camera.position.y = 1.0;
    for technique in [Technique::Bsdf, Technique::NextEvent, Technique::Mis] {
        let direct = Transport::Direct { environment_shadows: true };
        close(&scene, &Settings { transport: direct, technique, ..settings(256) }, [0.8 * 3.0 * factor; 3]);
    }
}

#[test]
fn the_error_of_independent_samples_falls_as_chance_says_and_that_of_sobol_points_faster() {
    let lamp = Light::Area {
        center: Vec3::new(0.3, 0.9, 0.0),
        u: Vec3::new(0.4, 0.0, 0.0),
        v: Vec3::new(0.0, 0.0, 0.4),
        radiance: LinearRgb([3.0; 3]),
    };
    let mut scene = scene(skin(matt(), 0.8, 0.3, 0.0), vec![lamp], 0.0);
    scene.camera.position.y = 0.8;
    let direct = Transport::Direct { environment_shadows: true };
    let of = |sampler, samples| {
        let settings = Settings { transport: direct, width: 64, height: 64, sampler, ..settings(samples) };
        Renderer::new(&scene).expect("sound").render(&settings, Control::default()).rgb()
    };
    let exact = of(SamplerKind::Sobol, 1 << 11).iter().map(|p| f64::from(p[0])).sum::<f64>() / 4096.0;
    let slope = |sampler| {
        let logs: Vec<(f64, f64)> = (0..5)
            .map(|i| 4u32.pow(i + 1))
            .map(|n| {
                let sum: f64 = of(sampler, n).iter().map(|p| (f64::from(p[0]) - exact).powi(2)).sum();
                (f64::from(n).ln(), (sum / 4096.0).ln())
            })
            .collect();
        let (mx, my) =
            (logs.iter().map(|p| p.0).sum::<f64>() / 5.0, logs.iter().map(|p| p.1).sum::<f64>() / 5.0);
        logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
            / logs.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
    };
    let independent = slope(SamplerKind::Independent);
    assert!((independent + 1.0).abs() < 0.05, "{independent}");
    let sobol = slope(SamplerKind::Sobol);
    assert!(sobol < -1.3, "{sobol}");
}

#[test]
fn a_film_under_a_white_sky_has_the_colour_of_the_exact_series() {
    let settings = Settings { stage: Stage::Film, ..settings(1024) };
    for d in [0.0, 400.0, 600.0, 2.4e6] {
        let of = |d| scene(skin(Constants::default(), 0.0, 0.0, d), vec![], 1.0);
        let film = ThinFilm::new(1.0, 1.55, 2.0, f64::from(d)).expect("a film");
        let expected = FilmColor::<f64>::new(Method::REFERENCE).color(&film, 1.0);
        close(&of(d), &settings, expected);
        // The comparison tells a film apart that is 5 % thicker, where thickness has a colour.
        if (1.0..1e4).contains(&d) {
            compare(&of(1.05 * d), &settings, expected).expect_err("another film");
        }
    }
}

#[test]
fn a_white_furnace_is_white_at_any_roughness() {
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        for d in [0.0, 400.0, 3000.0] {
            let mut scene = scene(skin(Constants::default(), 1.0, roughness, d), vec![], 1.0);
            // Also at a slant.
            for position in [Vec3::new(0.0, 2.0, 0.0), Vec3::new(1.8, 0.6, 0.3)] {
                scene.camera.position = position;
                let (mean, error) = mean(&scene, &settings(256));
                for c in mean {
                    // Energy of a rough film is from a table: its error is that of the table.
                    assert!(
                        (c - 1.0).abs() < 4.0 * error + 2e-3,
                        "{roughness} {d} {position} {mean:?} {error}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_way_to_find_lights_gives_the_same_picture() {
    let lamp = Light::Area {
        center: Vec3::new(0.8, 0.9, 0.3),
        u: Vec3::new(0.3, 0.0, 0.0),
        v: Vec3::new(0.0, 0.0, 0.3),
        radiance: LinearRgb([4.0, 2.0, 1.0]),
    };
    let mut scene = scene(skin(Constants::default(), 0.4, 0.4, 350.0), vec![lamp], 0.3);
    // A second floor above one half: light goes to and fro.
    let mut roof = floor(0.5);
    roof.positions.iter_mut().for_each(|p| *p += Vec3::new(-0.6, 0.4, 0.0));
    scene.objects.push(Object { name: "roof".into(), mesh: roof, material: 0 });
    let truth = mean(&scene, &settings(4096));
    for technique in [Technique::Bsdf, Technique::NextEvent] {
        for sampler in [SamplerKind::Sobol, SamplerKind::Independent] {
            let (mean, error) = mean(&scene, &Settings { technique, sampler, ..settings(2048) });
            for c in 0..3 {
                let tolerance = 4.0 * (error * error + truth.1 * truth.1).sqrt();
                assert!(
                    (mean[c] - truth.0[c]).abs() < tolerance,
                    "{technique:?} {sampler:?} {mean:?} {truth:?} {error}"
                );
            }
        }
    }
}

#[test]
fn the_environment_shines_through_a_roof_where_it_is_told_to_and_a_sun_does_not() {
    let sun =
        Light::Directional { direction: Vec3::Y, irradiance: LinearRgb([2.0; 3]), angular_radius_rad: 0.5 };
    let mut scene = scene(skin(matt(), 0.5, 0.3, 0.0), vec![sun], 0.3);
    let settings = |technique| Settings {
        transport: Transport::Direct { environment_shadows: false },
        technique,
        ..settings(256)
    };
    let sky = [0.5 * 0.3; 3];
    for technique in [Technique::Bsdf, Technique::NextEvent, Technique::Mis] {
        compare(&scene, &settings(technique), sky).expect_err("sun and sky");
    }
    let mut roof = floor(20.0);
    roof.positions.iter_mut().for_each(|p| p.y = 3.0);
    scene.objects.push(Object { name: "roof".into(), mesh: roof, material: 0 });
    for technique in [Technique::Bsdf, Technique::NextEvent, Technique::Mis] {
        close(&scene, &settings(technique), sky);
    }
}

#[test]
fn the_picture_does_not_depend_on_threads_or_instruction_set_and_does_on_the_seed() {
    let scene = scene(skin(Constants::default(), 0.4, 0.4, 350.0), vec![], 1.0);
    let render = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let settings = Settings { width: 40, height: 24, seed, ..settings(4) };
        pool.install(|| Renderer::new(&scene).expect("sound").render(&settings, Control::default()))
    };
    let one = render(1, 5);
    assert!(one == render(3, 5));
    assert!(one != render(1, 6));
    let level = simd::level();
    simd::force(simd::Level::Baseline);
    let plain = render(2, 5);
    simd::force(level);
    assert!(one == plain);
}

#[test]
fn a_stopped_picture_is_whole_and_refining_goes_on_where_it_ended() {
    let scene = scene(skin(Constants::default(), 0.4, 0.4, 350.0), vec![], 1.0);
    let renderer = Renderer::new(&scene).expect("sound");
    let stop = AtomicBool::new(false);
    let told = |share: f32| stop.store(share > 0.3, Ordering::Relaxed);
    let control = Control { cancel: Some(&stop), progress: Some(&told) };
    let film = renderer.render(&Settings { width: 64, height: 48, ..settings(64) }, control);
    assert!(film.samples_per_pixel() < 64.0);
    assert!(film.pixels.iter().all(|p| p.count > 0 && p.rgb()[0] > 0.0));

    let whole = renderer.render(&settings(8), Control::default());
    let mut parts = Film::new(8, 8);
    renderer.refine(&mut parts, &settings(8), 0..3, Control::default());
    renderer.refine(&mut parts, &settings(8), 3..8, Control::default());
    assert!(whole == parts);
}

#[test]
fn a_scene_of_nothing_is_its_environment_and_odd_sizes_work() {
    let mut empty = scene(skin(matt(), 0.5, 0.5, 0.0), vec![], 0.25);
    empty.objects.clear();
    close(&empty, &Settings { width: 1, height: 17, ..settings(16) }, [0.25; 3]);
    empty.environment = Environment::Constant(LinearRgb([0.0; 3]));
    close(&empty, &settings(1), [0.0; 3]);
}
