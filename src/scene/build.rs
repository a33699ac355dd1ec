//! From a scene's text to the scene.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::camera::{Camera, View};
use super::displace::{self, DisplaceError};
use super::environment::{Environment, EnvironmentImage};
use super::light::Light;
use super::material::{Material, SkinMaps};
use super::mesh::Mesh;
use super::plain;
use super::sky::{Daylight, overcast, towards};
use super::snake::{Snake, SnakeError, check_tile};
use super::spec::{
    CameraSpec, EnvironmentSpec, Form, Ground, Lamp, LightSpec, RenderSpec, SceneSpec, Subject, Surroundings,
};
use super::studio::Studio;
use super::tangents::TangentError;
use super::{Object, Scene};
use crate::base::{LinearRgb, Srgb8};
use crate::optics::SkinOptics;
use crate::optics::layered::Constants;

/// Length of a cylinder with its ends, body diameters, where none is given.
const CYLINDER: f32 = 4.0;

/// Most triangles that displacement asks for.
const MOST_DISPLACED: usize = 4_000_000;

/// What a scene is made of besides its text.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The maps of the skin; without them it is plain.
    pub maps: Option<Arc<SkinMaps>>,
    /// What the skin is made of, where the scene does not say otherwise.
    pub optics: SkinOptics,
    /// A mesh in place of the text's form, in body diameters or what the text says; it is set down on the ground.
    pub mesh: Option<Mesh>,
    /// The environment's picture, for scenes that name one.
    pub picture: Option<Arc<EnvironmentImage>>,
    /// Physical size of the tile, mm, where there are no maps: girth, length.
    pub size_mm: [f32; 2],
}

impl Default for Inputs {
    /// No maps; the tile of a body 20 mm thick.
    fn default() -> Self {
        Self {
            maps: None,
            optics: SkinOptics::default(),
            mesh: None,
            picture: None,
            size_mm: [20.0 * PI, 92.4],
        }
    }
}

/// Why a text makes no scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// There is no such snake.
    #[error(transparent)]
    Snake(#[from] SnakeError),
    /// Its surface has no tangents; cannot happen for the forms there are.
    #[error(transparent)]
    Tangents(#[from] TangentError),
    /// The tile cannot be laid on a body.
    #[error("a tile of {0} mm by {1} mm cannot be laid on a body")]
    Tile(f32, f32),
    /// The surface is to be displaced, and the skin has no height map.
    #[error("the skin has no height map to displace by")]
    NoHeight,
    /// The surface cannot be displaced.
    #[error(transparent)]
    Displace(#[from] DisplaceError),
    /// The environment is a picture that was not given.
    #[error("the picture `{0}` of the environment is not there")]
    Picture(String),
}

impl Scene {
    /// Make the scene that a text describes.
    ///
    /// # Errors
    /// If the subject cannot be made, or the environment's picture is not given.
    pub fn build(spec: &SceneSpec, inputs: &Inputs) -> Result<Self, SceneError> {
        let size_mm = inputs.maps.as_ref().map_or(inputs.size_mm, |maps| maps.size_mm);
        let mm_per_unit = size_mm[0] / PI;
        check_tile(size_mm).map_err(|[girth, length]| SceneError::Tile(girth, length))?;
        let mesh = subject(&spec.subject, inputs, size_mm)?;
        let camera = camera(&spec.camera, &spec.render, &mesh, mm_per_unit);
        let (environment, sun) = environment(&spec.environment, inputs)?;
        let lights = spec.light.iter().filter_map(|light| lamp(light, camera.target));
        let mut scene = Self {
            name: spec.name.clone(),
            mm_per_unit,
            lights: sun.into_iter().chain(lights).collect(),
            objects: vec![Object { name: "subject".into(), mesh, material: 0 }],
            materials: vec![skin(spec, inputs)],
            camera,
            environment,
            exposure_ev: spec.render.exposure_ev,
        };
        if spec.ground.show {
            let (mesh, material) = ground(&spec.ground);
            scene.objects.push(Object { name: "ground".into(), mesh, material: 1 });
            scene.materials.push(material);
        }
        Ok(scene)
    }
}

/// What the subject of a scene wears: its first material.
pub fn skin(spec: &SceneSpec, inputs: &Inputs) -> Material {
    let texel = spec.material.texel();
    Material {
        constants: spec.material.constants(inputs.optics),
        color: LinearRgb(texel.color),
        roughness: texel.roughness,
        thickness_nm: texel.thickness_nm,
        maps: inputs.maps.clone(),
    }
}

fn subject(subject: &Subject, inputs: &Inputs, size_mm: [f32; 2]) -> Result<Mesh, SceneError> {
    let mut mesh = match &inputs.mesh {
        Some(mesh) => settled(mesh.clone(), subject.mesh_unit_mm.map_or(1.0, |unit| unit * PI / size_mm[0])),
        None => form(subject, subject.triangles as usize, size_mm)?,
    };
    if subject.displacement != 0.0 {
        let maps = inputs.maps.as_ref().ok_or(SceneError::NoHeight)?;
        let height = maps.height_plane().ok_or(SceneError::NoHeight)?;
        let tiles = texture_area(&mesh);
        let finer = displace::density(maps.width, maps.height, tiles, MOST_DISPLACED).triangles;
        if inputs.mesh.is_none() && finer > subject.triangles as usize {
            mesh = form(subject, finer, size_mm)?;
        }
        let mm_per_unit = size_mm[0] / PI;
        // A normal map tells of the same relief: on normals of the new surface it would count twice.
        let displaced = if maps.has_bumps() { displace::shift } else { displace::displace };
        mesh = displaced(&mesh, &height, subject.displacement, mm_per_unit)?;
    }
    turn(&mut mesh, subject.turn_deg);
    Ok(mesh)
}

fn form(subject: &Subject, triangles: usize, size_mm: [f32; 2]) -> Result<Mesh, SceneError> {
    Ok(match (subject.form, subject.form.pose()) {
        (_, Some(pose)) => {
            let length_in_diameters = subject.length.unwrap_or(pose.usual_length_in_diameters());
            let section = subject.cross_section;
            Snake { pose, length_in_diameters, section, triangles, tile_mm: size_mm }.mesh()?
        }
        (Form::Plane, _) => plain::tile(triangles, size_mm)?,
        (Form::Cylinder, _) => {
            let straight = subject.length.unwrap_or(CYLINDER) - 1.0;
            plain::capsule(straight.max(0.0), triangles, size_mm)?
        }
        _ => plain::capsule(0.0, triangles, size_mm)?,
    })
}

/// The mesh, `scale` times as large, with its lowest point on the ground.
fn settled(mut mesh: Mesh, scale: f32) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
    let lowest = mesh.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
    if lowest.is_finite() {
        mesh.positions.iter_mut().for_each(|p| p.y -= lowest);
    }
    mesh
}

/// Tiles of the texture on a mesh, also shares of one.
fn texture_area(mesh: &Mesh) -> f64 {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| mesh.uvs[i as usize].as_dvec2());
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    mesh.triangles.iter().map(area).sum()
}

/// Turn around the vertical, from +z towards +x.
fn turn(mesh: &mut Mesh, turn_deg: f32) {
    if turn_deg == 0.0 {
        return;
    }
    let (x, z) = (towards(0.0, 90.0 + turn_deg), towards(0.0, turn_deg));
    let turned = |v: Vec3| x * v.x + Vec3::Y * v.y + z * v.z;
    mesh.positions.iter_mut().chain(&mut mesh.normals).for_each(|v| *v = turned(*v));
    mesh.tangents.iter_mut().for_each(|t| *t = turned(t.truncate()).extend(t.w));
}

/// A square at y = 0, matt.
fn ground(ground: &Ground) -> (Mesh, Material) {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let mesh = Mesh {
        positions: corners.map(|(x, z)| Vec3::new(x, 0.0, z) * ground.radius).to_vec(),
        normals: vec![Vec3::Y; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        uvs: corners.map(|(x, z)| Vec2::new(x, z) * ground.radius).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    // One index everywhere: nothing is reflected at the surface.
    let constants = Constants { indices: [1.0; 3], absorption: [0.0; 3], ..Constants::default() };
    let color = LinearRgb::from(ground.color);
    (mesh, Material { constants, color, roughness: 1.0, thickness_nm: 0.0, maps: None })
}

fn camera(spec: &CameraSpec, render: &RenderSpec, mesh: &Mesh, mm_per_unit: f32) -> Camera {
    let from = towards(spec.elevation_deg, spec.azimuth_deg);
    let mut camera = Camera {
        position: from,
        target: Vec3::ZERO,
        // Square to the view, so that one may look straight down.
        up: towards(spec.elevation_deg + 90.0, spec.azimuth_deg),
        // Film is 24 mm high.
        field_of_view_rad: 2.0 * libm::atan(12.0 / f64::from(spec.focal_length_mm)) as f32,
        aperture: spec.f_number.map_or(0.0, |n| 0.5 * spec.focal_length_mm / n / mm_per_unit),
        focus_distance: 1.0,
    };
    let view = camera.view(render.width as f32 / render.height as f32);
    camera.target = spec.target.map_or_else(|| middle(&mesh.positions, &view), Vec3::from);
    let distance = spec.distance.unwrap_or_else(|| fit(&mesh.positions, &view, camera.target, spec.fill));
    camera.position = camera.target + from * distance;
    camera.focus_distance =
        spec.focus_distance.or_else(|| first_hit(mesh, camera.position, -from)).unwrap_or(distance);
    camera
}

/// The middle of a box around the points whose sides are those of the view.
fn middle(points: &[Vec3], view: &View) -> Vec3 {
    let axes = [view.right, view.up, view.forward];
    axes.into_iter()
        .map(|axis| {
            let (low, high) = points
                .iter()
                .map(|p| p.dot(axis))
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            if low <= high { axis * (0.5 * (low + high)) } else { Vec3::ZERO }
        })
        .sum()
}

/// The least distance from the target from which all points lie within `fill` of the picture.
fn fit(points: &[Vec3], view: &View, target: Vec3, fill: f32) -> f32 {
    let reach = view.half_size * fill;
    let nearest = points.iter().map(|p| {
        let p = *p - target;
        let depth = p.dot(view.forward);
        (p.dot(view.right).abs() / reach.x).max(p.dot(view.up).abs() / reach.y) - depth
    });
    nearest.fold(0.01, f32::max)
}

/// Distance to the first triangle that a ray meets (Moeller & Trumbore 1997).
fn first_hit(mesh: &Mesh, origin: Vec3, direction: Vec3) -> Option<f32> {
    let hit = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let (ab, ac, from) = (b - a, c - a, origin - a);
        let p = direction.cross(ac);
        let scale = 1.0 / ab.dot(p);
        let q = from.cross(ab);
        let (u, v, t) = (from.dot(p) * scale, direction.dot(q) * scale, ac.dot(q) * scale);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4).then_some(t)
    };
    mesh.triangles.iter().filter_map(hit).min_by(f32::total_cmp)
}

/// A colour times a strength.
fn tint(color: Srgb8, strength: f32) -> [f32; 3] {
    LinearRgb::from(color).0.map(|c| c * strength)
}

fn environment(spec: &EnvironmentSpec, inputs: &Inputs) -> Result<(Environment, Option<Light>), SceneError> {
    let tint = tint(spec.color, spec.strength);
    let tinted = |c: [f32; 3]| [0, 1, 2].map(|i| c[i] * tint[i]);
    let picture = |mut image: EnvironmentImage| {
        image.texels.iter_mut().for_each(|texel| *texel = tinted(*texel));
        Environment::Image(Arc::new(image))
    };
    // The columns of a picture run against the azimuth.
    let turned = |image: EnvironmentImage| picture(image.turned(-spec.turn_deg / 360.0));
    Ok(match spec.kind {
        Surroundings::None => (Environment::Constant(LinearRgb::default()), None),
        Surroundings::Even => (Environment::Constant(LinearRgb(tint)), None),
        Surroundings::Daylight => {
            let day = Daylight {
                elevation_deg: spec.sun_elevation_deg,
                azimuth_deg: spec.sun_azimuth_deg + spec.turn_deg,
                turbidity: spec.turbidity,
                ground_albedo: spec.ground_albedo,
            };
            let (sky, mut sun) = day.sky();
            if let Light::Directional { irradiance, .. } = &mut sun {
                irradiance.0 = tinted(irradiance.0);
            }
            (picture(sky), (spec.strength > 0.0).then_some(sun))
        }
        Surroundings::Overcast => (picture(overcast(spec.ground_albedo)), None),
        Surroundings::Studio => (turned(Studio::gray().image()), None),
        Surroundings::DarkStudio => (turned(Studio::dark().image()), None),
        Surroundings::Picture => {
            let image = inputs.picture.as_deref().cloned();
            (turned(image.ok_or_else(|| SceneError::Picture(spec.file.clone()))?), None)
        }
    })
}

/// The light of a lamp that faces the target; none if it is off.
fn lamp(spec: &LightSpec, target: Vec3) -> Option<Light> {
    if spec.strength <= 0.0 {
        return None;
    }
    let direction = towards(spec.elevation_deg, spec.azimuth_deg);
    Some(match spec.kind {
        Lamp::Sun => Light::Directional {
            direction,
            irradiance: LinearRgb(tint(spec.color, spec.strength * PI)),
            angular_radius_rad: spec.angle_deg * (0.5 * PI / 180.0),
        },
        Lamp::SoftBox => {
            let half = [spec.width, spec.height].map(|side| 0.5 * side);
            let across = towards(0.0, spec.azimuth_deg + 90.0);
            let view_factor = view_factor(half, spec.distance);
            Light::Area {
                center: target + direction * spec.distance,
                u: across * half[0],
                // Down, so that `u x v` points to the target.
                v: across.cross(direction) * half[1],
                radiance: LinearRgb(tint(spec.color, spec.strength / view_factor)),
            }
        }
    })
}

/// The share of what a small surface sends out that reaches a rectangle parallel to it, straight above its middle, in
/// (0, 1]: four times the closed form for a corner.
fn view_factor(half: [f32; 2], distance: f32) -> f32 {
    let [x, y] = half.map(|side| f64::from(side / distance));
    let part = |x: f64, y: f64| {
        let root = (1.0 + x * x).sqrt();
        x / root * libm::atan(y / root)
    };
    (2.0 / std::f64::consts::PI * (part(x, y) + part(y, x))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Texel, builtin, spec};

    /// A scene from a text, of few triangles.
    fn build(text: &str) -> Scene {
        let document = crate::preset::Document::parse("t.toml", text).expect("valid TOML");
        let (mut spec, _) = spec::read(&document).unwrap_or_else(|e| panic!("{e}"));
        spec.subject.triangles = 4000;
        Scene::build(&spec, &Inputs::default()).expect("it can be built")
    }

    #[test]
    fn every_built_in_scene_can_be_built_and_stands_on_its_ground() {
        for (name, _) in builtin::BUILTIN {
            let mut spec = builtin::scene(name).unwrap_or_else(|e| panic!("{e}"));
            spec.subject.triangles = 4000;
            let scene = Scene::build(&spec, &Inputs::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
            let mesh = &scene.objects[0].mesh;
            let lowest = mesh.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
            assert!(lowest.abs() < 1e-3, "{name} stands at {lowest}");
            assert!((scene.mm_per_unit - 20.0).abs() < 1e-4);
            let shines = !scene.environment.is_black() || !scene.lights.is_empty();
            assert!(shines && scene.camera.position.is_finite(), "{name}");
            assert!(scene.camera.position.y > 0.0, "{name} is seen from below the ground");
            let vertices = mesh.positions.len();
            assert!([mesh.normals.len(), mesh.tangents.len(), mesh.uvs.len()] == [vertices; 3], "{name}");
        }
    }

    #[test]
    fn the_subject_fills_its_share_of_the_picture() {
        for (size, fill) in [((800, 600), 0.9), ((300, 900), 0.5)] {
            let scene = build(&format!(
                "subject.form = 's'\ncamera = {{ fill = {fill}, elevation_deg = 40, azimuth_deg = 20 }}\n\
                 render = {{ width = {}, height = {} }}",
                size.0, size.1
            ));
            let aspect = size.0 as f32 / size.1 as f32;
            let clip = scene.camera.projection_matrix(aspect, 0.01, 1e4) * scene.camera.view_matrix();
            let most = scene.objects[0].mesh.positions.iter().fold(0.0_f32, |most, p| {
                let p = clip * p.extend(1.0);
                most.max((p.x / p.w).abs()).max((p.y / p.w).abs())
            });
            assert!((most - fill).abs() < 1e-3, "{most} for {fill}");
        }
    }

    #[test]
    fn a_lamp_gives_what_its_strength_says_where_the_camera_looks() {
        let scene = build(
            "environment.kind = 'none'\ncamera = { target = [1, 2, 3], distance = 9 }\n\
             [[light]]\nkind = 'soft_box'\nelevation_deg = 30\nazimuth_deg = 70\nstrength = 0.8\ndistance = 3\n\
             [[light]]\nkind = 'sun'\nelevation_deg = 80\nstrength = 0.3\nangle_deg = 10\n\
             [[light]]\nstrength = 0",
        );
        assert_eq!(scene.lights.len(), 2, "a lamp that is off is none");
        let target = Vec3::new(1.0, 2.0, 3.0);
        for (light, towards, strength) in
            [(&scene.lights[0], towards(30.0, 70.0), 0.8), (&scene.lights[1], towards(80.0, -40.0), 0.3)]
        {
            let n = 128;
            let mut e = 0.0;
            for i in 0..n * n {
                let u = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32);
                let s = light.sample(target, u).expect("it faces the target");
                e += f64::from(s.radiance.0[1] * s.direction.dot(towards) / s.pdf);
            }
            let radiance = e / f64::from(n * n) / std::f64::consts::PI;
            assert!((radiance - strength).abs() < 1e-3, "{radiance} for {strength}");
        }
        assert!((view_factor([1e3; 2], 1.0) - 1.0).abs() < 1e-2, "a box all over");
        assert!((view_factor([0.01; 2], 1.0) / (4e-4 / PI) - 1.0).abs() < 1e-3, "a small one");
    }

    #[test]
    fn the_camera_is_a_photographers() {
        let text = "subject.form = 'straight'\ncamera = { focal_length_mm = 50, f_number = 2.5, elevation_deg = 90 }";
        let scene = build(text);
        let camera = &scene.camera;
        // A picture 24 mm high; a lens 20 mm wide, on an animal of 20 mm.
        assert!((camera.field_of_view_rad - 2.0 * (12.0_f32 / 50.0).atan()).abs() < 1e-6);
        assert!((camera.aperture - 0.5).abs() < 1e-5);
        let view = camera.view(1.5);
        assert!(view.up.dot(Vec3::NEG_Z) > 0.999, "looking down, up is away from the viewer");
        // What is in the middle is sharp, not the middle of the body.
        let to_target = (camera.target - camera.position).length();
        assert!(camera.focus_distance < to_target && camera.focus_distance > to_target - 1.0);
        let set = build("camera = { focus_distance = 3.5, target = [0, 50, 0], distance = 5 }").camera;
        assert_eq!((set.focus_distance, set.target.y, set.aperture), (3.5, 50.0, 0.0));
        // Where nothing is, the target's distance.
        assert_eq!(
            build("camera = { target = [0, 50, 0], distance = 5, elevation_deg = 0 }").camera.focus_distance,
            5.0
        );
    }

    #[test]
    fn surroundings_are_tinted_turned_and_dimmed() {
        let sky = |text: &str| build(&format!("environment = {{ {text} }}")).environment;
        let even = sky("kind = 'even', color = '#ff0000', strength = 2");
        assert_eq!(even, Environment::Constant(LinearRgb([2.0, 0.0, 0.0])));
        let (plain, twice) = (sky("kind = 'overcast'"), sky("kind = 'overcast', strength = 2"));
        assert!((twice.radiance(Vec3::Y).0[1] / plain.radiance(Vec3::Y).0[1] - 2.0).abs() < 1e-5);
        let (plain, turned) = (sky("kind = 'studio'"), sky("kind = 'studio', turn_deg = 90"));
        let (a, b) = (plain.radiance(towards(55.0, -45.0)), turned.radiance(towards(55.0, 45.0)));
        assert!((a.0[1] - b.0[1]).abs() < 0.05 && a.0[1] > 5.0, "{a:?} {b:?}");
        assert!(build("environment.strength = 0").lights.is_empty());
        let sun =
            &build("environment = { sun_azimuth_deg = 30, turn_deg = 60, sun_elevation_deg = 0 }").lights[0];
        let Light::Directional { direction, .. } = sun else { panic!("the sun") };
        assert!(direction.x > 0.999);
    }

    #[test]
    fn a_picture_must_be_given() {
        let mut spec = SceneSpec { environment: EnvironmentSpec::default(), ..SceneSpec::default() };
        spec.subject.triangles = 4000;
        spec.environment.kind = Surroundings::Picture;
        spec.environment.file = "hall.exr".into();
        let error = Scene::build(&spec, &Inputs::default()).expect_err("no picture").to_string();
        assert_eq!(error, "the picture `hall.exr` of the environment is not there");
        let picture = Arc::new(EnvironmentImage::from_fn(8, 4, |_| LinearRgb([0.5; 3])));
        let inputs = Inputs { picture: Some(picture.clone()), ..Inputs::default() };
        let scene = Scene::build(&spec, &inputs).expect("a picture");
        assert_eq!(scene.environment, Environment::Image(picture));
    }

    /// Maps of one height everywhere; tilted normals or none.
    fn maps(height_mm: f32, normal: [f32; 3]) -> Arc<SkinMaps> {
        let texel = Texel { color: [0.5; 3], roughness: 0.3, normal, thickness_nm: 0.0 };
        let height_mm = Some(vec![height_mm; 64 * 32]);
        Arc::new(SkinMaps {
            width: 64,
            height: 32,
            texels: vec![texel; 64 * 32],
            height_mm,
            size_mm: [60.0, 30.0],
        })
    }

    #[test]
    fn a_height_map_moves_the_subject_and_makes_its_mesh_finer() {
        let mut spec = SceneSpec::default();
        (spec.subject.form, spec.subject.triangles, spec.subject.displacement) = (Form::Sphere, 1000, 0.5);
        let unit = 60.0 / PI;
        for normal in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]] {
            let inputs = Inputs { maps: Some(maps(0.4 * unit, normal)), ..Inputs::default() };
            let mesh = &Scene::build(&spec, &inputs).expect("a sphere").objects[0].mesh;
            mesh.check().expect("sound");
            let middle = Vec3::Y * 0.5;
            assert!(mesh.positions.iter().all(|p| (p.distance(middle) - 0.7).abs() < 1e-3));
            // The tile is pi x pi/2 units, the sphere's own measures: two triangles for each of 64 x 32 texels.
            assert!((3_500..4_500).contains(&mesh.triangles.len()), "{}", mesh.triangles.len());
        }
        assert_eq!(Scene::build(&spec, &Inputs::default()).expect_err("no map"), SceneError::NoHeight);
    }

    #[test]
    fn a_mesh_of_ones_own_is_set_down_and_fills_the_picture() {
        let mut own = plain::tile(100, [60.0, 30.0]).expect("a tile");
        own.positions.iter_mut().for_each(|p| *p = *p * 7.0 - Vec3::Y * 90.0);
        let spec = SceneSpec::default();
        let inputs = Inputs { mesh: Some(own.clone()), ..Inputs::default() };
        let scene = Scene::build(&spec, &inputs).expect("a scene");
        let mesh = &scene.objects[0].mesh;
        assert_eq!((mesh.triangles.len(), mesh.uvs.len()), (own.triangles.len(), own.uvs.len()));
        assert!(mesh.positions.iter().all(|p| (0.0..=7.0 * 1.6).contains(&p.y)));
        assert!((scene.camera.target.y - 3.5 * 0.5 * PI).abs() < 1.0, "{}", scene.camera.target);
        // In metres it is 50 times as large: 20 mm are one diameter.
        let mut metres = spec;
        metres.subject.mesh_unit_mm = Some(1000.0);
        let large = Scene::build(&metres, &inputs).expect("a scene");
        for (p, q) in large.objects[0].mesh.positions.iter().zip(&mesh.positions) {
            assert!((*p - *q * 50.0).length() < 0.01, "{p} {q}");
        }
        assert_eq!(large.mm_per_unit, scene.mm_per_unit, "the maps keep their scale");
    }

    #[test]
    fn optics_are_the_scenes_then_the_skins() {
        let mut spec = SceneSpec::default();
        spec.subject.triangles = 1000;
        spec.material.n_film = Some(1.4);
        let optics = SkinOptics { n_film: Some(1.5), n_layer: Some(1.7), ..SkinOptics::default() };
        let scene = Scene::build(&spec, &Inputs { optics, ..Inputs::default() }).expect("a scene");
        assert_eq!(scene.materials[0].constants.indices, [1.0, 1.4, 1.7]);
        assert_eq!(scene.materials[1].constants.indices, [1.0; 3], "not the ground's");
    }

    #[test]
    fn a_tile_that_is_no_tile_is_refused() {
        for (form, size_mm) in
            [(Form::Plane, [0.0, 1.0]), (Form::Sphere, [f32::NAN, 1.0]), (Form::Coil, [1.0, 1e6])]
        {
            let mut spec = SceneSpec::default();
            spec.subject.form = form;
            let error = Scene::build(&spec, &Inputs { size_mm, ..Inputs::default() });
            assert!(matches!(error, Err(SceneError::Tile(..))), "{size_mm:?}");
        }
    }

    #[test]
    fn turning_keeps_frames_square() {
        let mesh = &build("subject.turn_deg = 33").objects[0].mesh;
        for (n, t) in mesh.normals.iter().zip(&mesh.tangents) {
            assert!(n.dot(t.truncate()).abs() < 1e-3 && (n.length() - 1.0).abs() < 1e-4);
        }
    }
}
