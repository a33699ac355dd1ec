//! `preview` from outside, and its pictures against the path tracer's.
//!
//! Without a graphics adapter (software ones count) the tests that draw print SKIPPED and why; with OPHIDIAN_REQUIRE_GPU=1
//! that fails.

mod traced;

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use ophidian::base::{LinearRgb, num};
use ophidian::optics::cie;
use ophidian::preview::{Gpu, Options, PreviewError, Renderer};
use ophidian::reference::{self, Control, Settings, Transport};
use ophidian::report::metric::ColorErrors;
use ophidian::scene::spec::{SceneSpec, Surroundings};
use ophidian::scene::{Camera, Environment, Inputs, Scene, SkinMaps, Texel, builtin};
use serde_json::Value;

use super::cli::ophidian;

fn gpu() -> Option<Gpu> {
    match Gpu::new(None) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("OPHIDIAN_REQUIRE_GPU").is_none_or(|v| v != "1"), "{error}");
            println!("SKIPPED: {error}");
            None
        }
    }
}

/// A built-in scene of few triangles whose subject is even skin under a film.
fn scene(name: &str) -> (SceneSpec, Scene) {
    let mut spec = builtin::scene(name).expect("a built-in scene");
    spec.subject.triangles = 8000;
    let mut scene = Scene::build(&spec, &Inputs::default()).expect("it can be built");
    let skin = &mut scene.materials[0];
    (skin.color, skin.roughness, skin.thickness_nm) = (LinearRgb([0.3, 0.12, 0.06]), 0.35, 400.0);
    skin.constants.absorption = [0.1, 0.2, 0.4];
    (spec, scene)
}

/// What a screen shows of linear light.
fn shown(spec: &SceneSpec, texel: [f32; 3]) -> [f64; 3] {
    let gain = num::exp2(spec.render.exposure_ev);
    spec.render.tone.map(LinearRgb(texel.map(|c| c * gain))).0.map(f64::from)
}

/// Whether a pixel is no silhouette: where it sees two surfaces, their normals are not one.
fn sees_one_surface(pixel: &reference::Pixel) -> bool {
    let n = pixel.normal.map(|n| n / pixel.count as f32);
    (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt() > 0.98
}

/// What suits the adapter, with the environment's light through everything.
fn open(gpu: &Gpu) -> Options {
    Options { occlusion_slices: 0, ..Options::of(gpu) }
}

/// What a preview draws, by the path tracer.
fn direct_light([width, height]: [usize; 2], samples: u32) -> Settings {
    let transport = Transport::Direct { environment_shadows: false };
    Settings { width, height, samples, transport, ..Settings::default() }
}

/// What things hide of an even sky from the floor around a sphere that lies on it: of light by the cosine (r/d)^3 at a distance d from
/// its middle, a form factor. The sphere's lower half, which no picture from above shows, is in it.
#[test]
fn the_floor_around_a_sphere_loses_what_the_sphere_hides() {
    let Some(gpu) = gpu() else { return };
    let mut spec = builtin::scene("sphere").expect("a built-in scene");
    spec.subject.triangles = 8000;
    spec.environment.kind = Surroundings::Even;
    (spec.camera.elevation_deg, spec.camera.fill) = (50.0, 0.35);
    let scene = Scene::build(&spec, &Inputs::default()).expect("it can be built");
    let size = [120, 90];
    let draw = |occlusion_slices: u32| {
        let options = Options { occlusion_slices, samples: 16, ..Options::of(&gpu) };
        let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
        renderer.render(&scene.camera, size).expect("a picture").texels
    };
    let (with, without) = (draw(Options::SLICES), draw(0));
    let (mut sum, mut plain, mut count) = (0.0, 0.0, 0);
    for (i, (with, without)) in with.iter().zip(&without).enumerate() {
        let at = [(i % size[0]) as f32 + 0.5, (i / size[0]) as f32 + 0.5];
        let (o, d) = scene.camera.ray(at[0] / size[0] as f32, at[1] / size[1] as f32, 4.0 / 3.0, [0.5; 2]);
        let place = o - d * (o.y / d.y);
        let to_middle = Vec3::new(0.0, 0.5, 0.0) - place;
        let middle_of_ray = o + d * (Vec3::new(0.0, 0.5, 0.0) - o).dot(d);
        // Not the sphere, nor its outline.
        if d.y < 0.0 && (middle_of_ray - Vec3::new(0.0, 0.5, 0.0)).length() > 0.53 {
            let hidden = (0.5 / to_middle.length()).powi(3);
            sum += (with[1] / without[1] - (1.0 - hidden)).abs();
            plain += hidden;
            count += 1;
        }
    }
    let (error, plain) = (sum / count as f32, plain / count as f32);
    println!("{error} of {plain} at {count} places");
    assert!(count > 5000 && error < 0.02 && plain > 2.0 * error, "{error} {plain} {count}");
}

/// Where objects hide the environment from each other, a picture in which its depths hide it is nearer to the path tracer's than one
/// through which it shines, and nearer to that of light through everything without.
#[test]
fn occlusion_is_that_of_the_path_tracer() {
    let Some(gpu) = gpu() else { return };
    let (spec, scene) = scene("coil");
    let size = [96, 72];
    let tracer = reference::Renderer::new(&scene).expect("a sound scene");
    let film = |environment_shadows| {
        let transport = Transport::Direct { environment_shadows };
        tracer.render(&Settings { transport, ..direct_light(size, 128) }, Control::default())
    };
    let (hidden, shining) = (film(true), film(false));
    let draw = |occlusion_slices, samples, once| {
        let options = Options { occlusion_slices, samples, once, ..Options::of(&gpu) };
        let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
        let picture = renderer.render(&scene.camera, size).expect("a picture");
        let on = occlusion_slices > 0;
        assert_eq!(renderer.slots().concat().contains(&"open_screen"), on);
        assert_eq!(picture.passes.iter().any(|(name, _)| *name == "occlusion"), on);
        assert_eq!(renderer.resources().iter().any(|(name, _)| name == "occlusion"), on);
        picture.texels
    };
    let apart = |texels: &[[f32; 3]], film: &reference::Film| {
        let mut errors = ColorErrors::default();
        for (texel, pixel) in texels.iter().zip(&film.pixels).filter(|(_, p)| sees_one_surface(p)) {
            errors.add(shown(&spec, *texel), shown(&spec, pixel.rgb()));
        }
        errors.delta_e_mean()
    };
    let plain = draw(0, 1, true);
    let (missing, small) = (apart(&plain, &hidden), apart(&plain, &shining));
    assert!(missing > 2.0 && small < 1.0, "{missing} {small}");
    // Shaded once, in samples, and averaged.
    for (samples, once, most) in [(1, true, 1.5), (1, false, 1.5), (16, true, 1.0)] {
        let occluded = draw(Options::SLICES, samples, once);
        let (right, wrong) = (apart(&occluded, &hidden), apart(&occluded, &shining));
        println!("{samples} {once}: {right} {wrong}");
        assert!(right < most && wrong > 2.0, "{samples} {once}: {right} {wrong}");
    }
}

/// Dressed anew, a renderer draws what one made for that skin draws, to the bit: with another shader, with the same, and back again.
#[test]
fn a_renderer_wears_other_skins() {
    let Some(gpu) = gpu() else { return };
    let (_, scene) = scene("coil");
    let size = [48, 36];
    let mut bare = scene.clone();
    bare.materials[0].thickness_nm = 0.0;
    let mut thick = scene.clone();
    (thick.materials[0].thickness_nm, thick.materials[0].color) = (520.0, LinearRgb([0.1, 0.3, 0.2]));
    let mut mapped = scene.clone();
    let (color, normal) = ([0.4, 0.2, 0.1], [0.0, 0.0, 1.0]);
    let texel = Texel { color, roughness: 0.3, normal, thickness_nm: 300.0 };
    mapped.materials[0].maps = Some(Arc::new(SkinMaps {
        width: 2,
        height: 1,
        texels: vec![texel, Texel { thickness_nm: 500.0, ..texel }],
        height_mm: None,
        size_mm: [30.0, 30.0],
    }));
    let options = Options { occlusion_slices: 1, ..Options::of(&gpu) };
    let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
    let first = renderer.render(&scene.camera, size).expect("a picture").texels;
    for other in [&bare, &thick, &mapped, &scene] {
        renderer.wear(0, &other.materials[0]).expect("a sound skin");
        let worn = renderer.render(&scene.camera, size).expect("a picture").texels;
        let mut own = Renderer::new(&gpu, other, &options).expect("it fits");
        assert_eq!(worn, own.render(&scene.camera, size).expect("a picture").texels);
        assert_eq!((renderer.slots(), renderer.resources()), (own.slots(), own.resources()));
        assert_eq!(worn == first, std::ptr::eq(other, &scene));
    }
    // A bad one is refused, nobody's changes nothing, and the old one stays.
    let mut bad = scene.materials[0].clone();
    bad.constants.indices = [1.0, 0.0, 2.0];
    assert!(matches!(renderer.wear(0, &bad), Err(PreviewError::Material(_))));
    assert_eq!(renderer.wear(9, &bad), Ok(()));
    assert_eq!(renderer.render(&scene.camera, size).expect("a picture").texels, first);
}

/// Shadows that pixels share are nearly those that each looks up alone: nearer than with one small light for all of a
/// rectangle. With more samples, of which each has other small lights, nothing is shared.
#[test]
fn shared_shadows_are_nearly_those_of_each_pixel() {
    let Some(gpu) = gpu() else { return };
    let (spec, scene) = scene("coil");
    let draw = |shared_shadows, rectangle_samples, samples| {
        let options =
            Options { shared_shadows, rectangle_samples, samples, once: true, ..Options::default() };
        let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
        let shared = renderer.slots().concat().contains(&"places_shared");
        (renderer.render(&scene.camera, [160, 120]).expect("a picture").texels, shared)
    };
    let (each, _) = draw(false, 16, 1);
    let apart = |(texels, _): &(Vec<[f32; 3]>, bool)| {
        let mut errors = ColorErrors::default();
        texels.iter().zip(&each).for_each(|(a, b)| errors.add(shown(&spec, *a), shown(&spec, *b)));
        errors.delta_e_mean()
    };
    let (shared, one, more) = (draw(true, 16, 1), draw(true, 1, 1), draw(true, 16, 4));
    assert_eq!((shared.1, one.1, more.1), (true, false, false));
    assert!(apart(&shared) < 0.5 && apart(&one) > 1.0, "{} {}", apart(&shared), apart(&one));
}

#[test]
fn pictures_are_the_same_each_time_at_any_size_and_none_has_no_pixels() {
    let Some(gpu) = gpu() else { return };
    let (_, scene) = scene("sphere");
    let mut renderer = Renderer::new(&gpu, &scene, &Options::default()).expect("it fits");
    let first = renderer.render(&scene.camera, [33, 17]).expect("a picture");
    assert_eq!(renderer.render(&scene.camera, [1, 1]).expect("a picture").texels.len(), 1);
    let again = renderer.render(&scene.camera, [33, 17]).expect("a picture");
    assert_eq!(first.texels, again.texels);
    assert!(first.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
    assert!(first.texels.iter().any(|t| cie::lab(t.map(f64::from))[0] > 20.0));
    assert_eq!(renderer.render(&scene.camera, [0, 5]), Err(PreviewError::Empty(0, 5)));
    let wide = renderer.render(&scene.camera, [1 << 20, 1]).expect_err("no adapter holds it");
    assert!(matches!(wide, PreviewError::TooLarge { needed: 1_048_576, .. }), "{wide}");
    // And it still draws.
    assert_eq!(renderer.render(&scene.camera, [33, 17]).expect("a picture").texels, first.texels);
}

/// One pixel, one column, nothing to be seen and no environment: with occlusion, too, a picture of finite numbers.
#[test]
fn occlusion_of_extreme_pictures_is_finite() {
    let Some(gpu) = gpu() else { return };
    let (_, mut scene) = scene("coil");
    for once in [true, false] {
        let options = Options { occlusion_slices: 3, once, ..Options::default() };
        let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
        let first = renderer.render(&scene.camera, [33, 17]).expect("a picture");
        let away = Camera { target: scene.camera.position + Vec3::Y, ..scene.camera };
        let beside = Camera { position: Vec3::new(0.3, 0.01, 0.2), ..scene.camera };
        for (camera, size) in
            [(scene.camera, [1, 1]), (scene.camera, [1, 40]), (away, [8, 8]), (beside, [24, 16])]
        {
            let picture = renderer.render(&camera, size).expect("a picture");
            assert!(picture.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{size:?}");
        }
        assert_eq!(renderer.render(&scene.camera, [33, 17]).expect("a picture").texels, first.texels);
    }
    // Nothing to hide: no pass.
    scene.environment = Environment::Constant(LinearRgb([0.0; 3]));
    let options = Options { occlusion_slices: 3, ..Options::default() };
    let mut renderer = Renderer::new(&gpu, &scene, &options).expect("it fits");
    let picture = renderer.render(&scene.camera, [8, 8]).expect("a picture");
    assert!(picture.passes.iter().all(|(name, _)| *name != "occlusion"));
}

/// Mirrors, no film, a film of millimetres, no light at all: a picture of finite numbers.
#[test]
fn extreme_skins_are_drawn() {
    let Some(gpu) = gpu() else { return };
    let (_, scene) = scene("thesis");
    for (roughness, thickness_nm) in [(0.0, 0.0), (0.0, 2.4e6), (1.0, 300.0), (0.5, 2400.0)] {
        for lights in [0, 1] {
            let mut scene = scene.clone();
            (scene.materials[0].roughness, scene.materials[0].thickness_nm) = (roughness, thickness_nm);
            scene.lights.truncate(lights);
            let mut renderer = Renderer::new(&gpu, &scene, &Options::default()).expect("it fits");
            let picture = renderer.render(&scene.camera, [24, 16]).expect("a picture");
            assert!(picture.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
            assert_eq!(
                picture.texels.iter().flatten().any(|c| *c > 0.0),
                lights > 0,
                "{roughness} {thickness_nm}"
            );
        }
    }
}

struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

fn preview(dir: &Path, driver: bool, args: &[&str]) -> Run {
    let mut command = ophidian();
    let small = ["--size", "32x24", "--map-size", "64", "--scene-set", "subject.triangles=4000"];
    command.current_dir(dir).arg("preview").args(small).args(args);
    if !driver {
        command.env("VK_ICD_FILENAMES", "/nonexistent").env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent");
    }
    let output = command.output().expect("the command runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

#[test]
fn the_command_draws_and_tells_what_it_did() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().expect("a folder");
    let run = preview(dir.path(), true, &["epicrates_cenchria", "-o", "a.png", "--explain", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let json: Value = serde_json::from_str(&run.out).expect("one JSON object");
    assert_eq!((&json["backend"], &json["scene"]), (&Value::from("gpu"), &Value::from("coil")));
    let slots = json["slots"].to_string();
    for slot in ["film_table", "\"suns\"", "\"rectangles\""] {
        assert!(slots.contains(slot), "{slots}");
    }
    let names: Vec<&str> =
        json["passes"].as_array().expect("passes").iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(names[..2], ["shadow maps of suns", "shadow maps of rectangles"]);
    // Another frame has its shadow maps.
    assert_eq!(json["again"][0]["name"], names[2]);
    assert_eq!(json["frames_ms"].as_array().map(Vec::len), Some(2));
    // Where pixels are shaded once, there is more to do than the picture.
    let once = ["record", "deferred", "picture", "depths of samples", "edges"];
    assert!(names[2..] == once || (names.contains(&"picture") && !names.contains(&"edges")), "{names:?}");
    assert!(json["resources"].as_array().is_some_and(|r| r.iter().all(|r| r["bytes"].as_u64() > Some(0))));
    assert_eq!(image::open(dir.path().join("a.png")).expect("a PNG").to_rgb8().dimensions(), (32, 24));
    // What a scene lacks is not there.
    let args = ["python_regius", "-o", "b.png", "--explain", "--scene", "thesis"];
    let run = preview(dir.path(), true, &args);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.out.contains("sky_none") && !run.out.contains("environment"), "{}", run.out);
}

/// In a hundred times the daylight the mean picture is as bright where the exposure is metered, and only there; a lens is a pass
/// where it spreads light, and only there.
#[test]
fn the_exposure_follows_the_light_and_the_lens_is_asked_for() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().expect("a folder");
    let mean = |metering: &str, strength: &str, bloom: &str| {
        let settings = [
            format!("render.metering={metering}"),
            format!("environment.strength={strength}"),
            format!("render.bloom={bloom}"),
        ];
        let mut args = vec!["python_regius", "-o", "a.png", "--explain"];
        settings.iter().for_each(|s| args.extend(["--scene-set", s]));
        let run = preview(dir.path(), true, &args);
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert_eq!(run.out.contains("bloom"), bloom != "0.0", "{}", run.out);
        let pixels = image::open(dir.path().join("a.png")).expect("a PNG").to_rgb8();
        pixels.iter().map(|v| f64::from(*v)).sum::<f64>() / pixels.len() as f64
    };
    let (dim, bright) = (mean("average", "0.05", "0.0"), mean("average", "5.0", "0.2"));
    assert!((dim - bright).abs() < 25.0, "{dim} {bright}");
    let (dim, bright) = (mean("manual", "0.05", "0.0"), mean("manual", "5.0", "0.0"));
    assert!(bright - dim > 50.0, "{dim} {bright}");
}

#[test]
fn without_a_driver_the_path_tracer_draws_and_one_line_says_so() {
    let dir = tempfile::tempdir().expect("a folder");
    let run = preview(dir.path(), false, &["python_regius", "-o", "a.png", "--budget", "1s"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let told = |line: &&str| line.contains("no graphics adapter");
    assert_eq!(run.err.lines().filter(told).count(), 1, "{}", run.err);
    assert!(run.out.contains("cpu (") && dir.path().join("a.png").exists(), "{}", run.out);
    let run = preview(dir.path(), false, &["python_regius", "-o", "b.png", "--backend", "gpu"]);
    assert_eq!((run.code, dir.path().join("b.png").exists()), (Some(2), false), "{}", run.err);
    let run = preview(dir.path(), false, &["python_regius", "-o", "c.png", "--backend", "cpu", "--quiet"]);
    assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (Some(0), "", ""));
    let run = preview(dir.path(), false, &["python_regius", "-o", "c.exr"]);
    assert_eq!(run.code, Some(2));
}

/// Bumps by parallax are nearer to those of a moved surface than maps on the even one, and not those turned inside out. Without a height map, or with an even one, nothing of it is in the shader.
#[test]
fn parallax_is_nearly_displacement() {
    let Some(gpu) = gpu() else { return };
    let side = 64;
    let mut spec = builtin::scene("plane").expect("a built-in scene");
    (spec.camera.elevation_deg, spec.subject.triangles) = (40.0, 2000);
    let bump = |i: usize| {
        let turns = [i % side, i / side].map(|n| (n as f32 + 0.5) / side as f32 * 3.0);
        turns.map(|t| 0.5 - 0.5 * num::cos_turns(t)).iter().product::<f32>()
    };
    // As bright as they are high: what is seen tells where maps were looked up.
    let texel = |i| Texel {
        color: [0.05 + 0.9 * bump(i); 3],
        roughness: 0.8,
        normal: [0.0, 0.0, 1.0],
        thickness_nm: 0.0,
    };
    let maps = |height: &dyn Fn(usize) -> f32| {
        Arc::new(SkinMaps {
            width: side,
            height: side,
            texels: (0..side * side).map(texel).collect(),
            height_mm: Some((0..side * side).map(height).collect()),
            size_mm: [30.0, 30.0],
        })
    };
    let relief = maps(&|i| 1.5 * bump(i));
    let inputs = |maps: &Arc<SkinMaps>| Inputs { maps: Some(maps.clone()), ..Inputs::default() };
    let scene = Scene::build(&spec, &inputs(&relief)).expect("it can be built");
    let mut moved = spec.clone();
    moved.subject.displacement = 1.0;
    let mut moved = Scene::build(&moved, &inputs(&relief)).expect("it can be built");
    // Colours alone: bumps of the moved surface are not in the maps.
    for (object, even) in moved.objects.iter_mut().zip(&scene.objects) {
        let up = even.mesh.normals[0];
        object.mesh.normals.iter_mut().for_each(|n| *n = up);
    }
    let size = [120, 90];
    let tracer = reference::Renderer::new(&moved).expect("a sound scene");
    let film = tracer.render(&direct_light(size, 64), Control::default());
    let draw = |scene: &Scene, parallax: f32, parallax_steps: u32, once: bool| {
        let options = Options { parallax, parallax_steps, once, samples: 4, ..open(&gpu) };
        let mut renderer = Renderer::new(&gpu, scene, &options).expect("it fits");
        let texels = renderer.render(&scene.camera, size).expect("a picture").texels;
        (texels, renderer.resources().iter().any(|(name, _)| name == "relief"))
    };
    let apart = |texels: &[[f32; 3]]| {
        let mut errors = ColorErrors::default();
        for (texel, pixel) in texels.iter().zip(&film.pixels).filter(|(_, p)| sees_one_surface(p)) {
            errors.add(shown(&spec, *texel), shown(&spec, pixel.rgb()));
        }
        errors.delta_e_mean()
    };
    let (even, there) = draw(&scene, 0.0, 16, true);
    assert!(!there);
    let plain = apart(&even);
    for once in [true, false] {
        let at = |parallax, steps| {
            let (texels, there) = draw(&scene, parallax, steps, once);
            assert!(there);
            (apart(&texels), texels)
        };
        let [few, many, inside_out] = [at(1.0, 2), at(1.0, 32), at(-1.0, 32)];
        println!("{plain} without, {} by 2, {} by 32, {} inside out", few.0, many.0, inside_out.0);
        assert!(many.0 < 0.25 * plain && inside_out.0 > plain, "{plain} {} {}", many.0, inside_out.0);
        assert_ne!(few.1, many.1);
    }
    // An even one at any height is no relief, and nothing finite breaks it.
    let flat = Scene::build(&spec, &inputs(&maps(&|_| 0.7))).expect("it can be built");
    assert_eq!(draw(&flat, 1.0, 16, true), (even, false));
    let steep =
        Scene::build(&spec, &inputs(&maps(&|i| if i % 7 == 0 { 1e4 } else { f32::NAN }))).expect("built");
    assert!(draw(&steep, 1e3, 1, true).0.iter().flatten().all(|c| c.is_finite()));
}
