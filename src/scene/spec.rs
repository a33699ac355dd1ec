//! A scene as text: TOML in a photographer's words, read like a preset, with the same messages.
//!
//! | Key | Meaning |
//! | --- | --- |
//! | `name`, `description` | what it is called; nothing rendered depends on them |
//! | `[subject]` | what stands there: a snake in a pose, or a plain form |
//! | `[ground]` | what it lies on |
//! | `[camera]` | from where, through which lens |
//! | `[environment]` | what is all around |
//! | `[[light]]` | lamps besides it |
//! | `[material]` | the optics of the skin, and what stands in for maps |
//! | `[render]` | size of the picture, samples, exposure, tone curve |
//!
//! Lengths are in body diameters; angles in degrees: elevation above the horizon, azimuth around the vertical, 0 on the
//! viewer's side (+z), 90 to the right (+x).

mod material;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

pub use self::material::{BaseSpec, MaterialSpec, TintSpec};
use super::pose::Pose;
use super::tone::{Metering, ToneMap};
use crate::base::Srgb8;
use crate::preset::{Diagnostic, Diagnostics, Document, Item, PresetError, Table, section, suggest};

/// A scene before anything of it is made. Every key has a default: an empty text is a coiled snake by daylight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SceneSpec {
    /// Its name in reports; the text's own name unless set.
    pub name: String,
    /// What it shows, in a sentence.
    pub description: String,
    /// What stands there.
    pub subject: Subject,
    /// What it lies on.
    pub ground: Ground,
    /// From where, through which lens.
    pub camera: CameraSpec,
    /// What is all around.
    pub environment: EnvironmentSpec,
    /// Lamps besides the environment.
    #[schemars(length(max = 64))]
    pub light: Vec<LightSpec>,
    /// The optics of the skin.
    pub material: MaterialSpec,
    /// Size of the picture, samples, exposure, tone curve.
    pub render: RenderSpec,
}

/// Form of the subject.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// A snake at rest: a spiral of turns.
    #[default]
    Coil,
    /// A snake outstretched.
    Straight,
    /// A snake in bends.
    S,
    /// A snake in one loop that crosses itself.
    Loop,
    /// A sphere of one diameter.
    Sphere,
    /// A tile that stands upright and faces the viewer, as large as on the body.
    Plane,
    /// A lying piece of body: a cylinder of one diameter with round ends.
    Cylinder,
}

impl Form {
    /// The pose of a snake; `None` for the other forms.
    pub fn pose(self) -> Option<Pose> {
        match self {
            Self::Coil => Some(Pose::Coil),
            Self::Straight => Some(Pose::Straight),
            Self::S => Some(Pose::Serpentine),
            Self::Loop => Some(Pose::Loop),
            Self::Sphere | Self::Plane | Self::Cylinder => None,
        }
    }
}

/// `[subject]`: what stands there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Subject {
    /// Its form.
    pub form: Form,
    /// Length of a snake from snout to tip of the tail; what suits the pose unless set. Of a cylinder, with its
    /// ends, 4 unless set.
    #[schemars(range(min = 1.0, max = 100.0), extend("x-unit" = "diameters"))]
    pub length: Option<f32>,
    /// Section of a snake: 0 is round, 1 a loaf with a flat belly.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub cross_section: f32,
    /// Triangles of the mesh; as near as its grid allows.
    #[schemars(range(min = 1000, max = 20_000_000))]
    pub triangles: u32,
    /// Turned around the vertical.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub turn_deg: f32,
    /// The surface is moved by so many times the height map: 1 is the skin's own relief, 0 leaves it to the normal map.
    /// The mesh gets as fine as the map, up to 4 million triangles.
    #[schemars(range(min = -100.0, max = 100.0))]
    pub displacement: f32,
    /// Length of a unit of a mesh of one's own: 1000 where it is in metres, as glTF is. Unless set, its unit is a body
    /// diameter.
    #[schemars(range(min = 0.001, max = 10_000.0), extend("x-unit" = "mm"))]
    pub mesh_unit_mm: Option<f32>,
}

impl Default for Subject {
    fn default() -> Self {
        Self {
            form: Form::Coil,
            length: None,
            cross_section: 0.25,
            triangles: 200_000,
            turn_deg: 0.0,
            displacement: 0.0,
            mesh_unit_mm: None,
        }
    }
}

/// `[ground]`: a plane below the subject, matt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Whether there is one.
    pub show: bool,
    /// Its albedo, sRGB.
    pub color: Srgb8,
    /// Half its side.
    #[schemars(range(min = 1.0, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub radius: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { show: true, color: Srgb8([0x8a, 0x80, 0x74]), radius: 200.0 }
    }
}

/// `[camera]`: a camera as for 35 mm film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSpec {
    /// Around the vertical: 0 is in front, 90 to the right of the subject.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub azimuth_deg: f32,
    /// Above the horizon.
    #[schemars(range(min = -90.0, max = 90.0), extend("x-unit" = "degrees"))]
    pub elevation_deg: f32,
    /// Focal length: 35 shows much, 100 flattens. The picture is 24 mm high on film.
    #[schemars(range(min = 5.0, max = 2000.0), extend("x-unit" = "mm"))]
    pub focal_length_mm: f32,
    /// Aperture, focal length over the width of the lens: 2.8 blurs much, 22 little; without it all is sharp.
    #[schemars(range(min = 0.5, max = 1000.0))]
    pub f_number: Option<f32>,
    /// Distance that is sharp; what is in the middle of the picture unless set.
    #[schemars(range(min = 0.01, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub focus_distance: Option<f32>,
    /// What is in the middle of the picture: [x, y, z], x to the right, y up from the ground, z to the front; the
    /// subject's middle unless set.
    #[schemars(inner(range(min = -10_000.0, max = 10_000.0)), extend("x-unit" = "diameters"))]
    pub target: Option<[f32; 3]>,
    /// Distance from the target; unless set, what lets the subject fill `fill` of the picture.
    #[schemars(range(min = 0.01, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub distance: Option<f32>,
    /// Share of the picture that the subject fills, where the distance is not set; above 1 it is cropped.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub fill: f32,
}

impl Default for CameraSpec {
    fn default() -> Self {
        Self {
            azimuth_deg: 0.0,
            elevation_deg: 30.0,
            focal_length_mm: 85.0,
            f_number: None,
            focus_distance: None,
            target: None,
            distance: None,
            fill: 0.9,
        }
    }
}

/// What is all around.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Surroundings {
    /// Nothing: black.
    None,
    /// The same from everywhere.
    Even,
    /// A clear sky with its sun.
    #[default]
    Daylight,
    /// A grey sky.
    Overcast,
    /// A light grey studio with soft boxes.
    Studio,
    /// A dark studio with strips of light, for iridescence.
    DarkStudio,
    /// A picture of all around: OpenEXR or Radiance HDR, equirectangular.
    Picture,
}

/// `[environment]`: what is all around.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentSpec {
    /// What.
    pub kind: Surroundings,
    /// Times its brightness. Skies are made so that a white sheet lying flat has radiance 1.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub strength: f32,
    /// Its tint, sRGB.
    pub color: Srgb8,
    /// Turned around the vertical.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub turn_deg: f32,
    /// `daylight`: the sun above the horizon.
    #[schemars(range(min = 0.0, max = 90.0), extend("x-unit" = "degrees"))]
    pub sun_elevation_deg: f32,
    /// `daylight`: the sun around the vertical; 0 is behind the viewer.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub sun_azimuth_deg: f32,
    /// `daylight`: haze, 2 very clear, 3 clear, 6 warm and moist, 10 hazy.
    #[schemars(range(min = 2.0, max = 10.0))]
    pub turbidity: f32,
    /// `daylight`, `overcast`: albedo of the land below the horizon.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ground_albedo: f32,
    /// `picture`: the file, relative to the scene.
    pub file: String,
}

impl Default for EnvironmentSpec {
    fn default() -> Self {
        Self {
            kind: Surroundings::Daylight,
            strength: 1.0,
            color: Srgb8([255; 3]),
            turn_deg: 0.0,
            sun_elevation_deg: 50.0,
            sun_azimuth_deg: -40.0,
            turbidity: 3.0,
            ground_albedo: 0.2,
            file: String::new(),
        }
    }
}

/// What kind of lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lamp {
    /// A soft box at a distance that faces what the camera looks at.
    #[default]
    SoftBox,
    /// A disk on the sky.
    Sun,
}

/// `[[light]]`: a lamp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightSpec {
    /// What kind.
    pub kind: Lamp,
    /// Above the horizon.
    #[schemars(range(min = -90.0, max = 90.0), extend("x-unit" = "degrees"))]
    pub elevation_deg: f32,
    /// Around the vertical; 0 is behind the viewer, 90 to the right.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "degrees"))]
    pub azimuth_deg: f32,
    /// Radiance of a white sheet that it alone lights from the front, where the camera looks.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub strength: f32,
    /// Its colour, sRGB.
    pub color: Srgb8,
    /// `soft_box`: its distance from where the camera looks.
    #[schemars(range(min = 0.01, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub distance: f32,
    /// `soft_box`: its width.
    #[schemars(range(min = 0.001, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub width: f32,
    /// `soft_box`: its height.
    #[schemars(range(min = 0.001, max = 100_000.0), extend("x-unit" = "diameters"))]
    pub height: f32,
    /// `sun`: the angle that it fills; 0 is a point with sharp shadows, the sun has 0.53.
    #[schemars(range(min = 0.0, max = 180.0), extend("x-unit" = "degrees"))]
    pub angle_deg: f32,
}

impl Default for LightSpec {
    fn default() -> Self {
        Self {
            kind: Lamp::SoftBox,
            elevation_deg: 50.0,
            azimuth_deg: -40.0,
            strength: 1.0,
            color: Srgb8([255; 3]),
            distance: 12.0,
            width: 8.0,
            height: 8.0,
            angle_deg: 0.53,
        }
    }
}

/// How the exposure is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeteringSpec {
    /// As `exposure_ev` says.
    #[default]
    Manual,
    /// The mean becomes middle grey, then `exposure_ev`.
    Average,
    /// Highlights are just kept, then `exposure_ev`.
    Highlights,
}

/// `[render]`: the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSpec {
    /// Its width.
    #[schemars(range(min = 1, max = 16_384), extend("x-unit" = "pixels"))]
    pub width: u32,
    /// Its height.
    #[schemars(range(min = 1, max = 16_384), extend("x-unit" = "pixels"))]
    pub height: u32,
    /// Paths per pixel: noise halves with four times as many.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub samples: u32,
    /// Most times that light is followed from surface to surface.
    #[schemars(range(min = 1, max = 64))]
    pub bounces: u32,
    /// Exposure as a power of two: 1 is twice as bright.
    #[schemars(range(min = -32.0, max = 32.0), extend("x-unit" = "EV"))]
    pub exposure_ev: f32,
    /// How the exposure is found.
    pub metering: MeteringSpec,
    /// Share of the light that the lens spreads around what is bright: 0 is a perfect lens, 0.05 a glow, 0.3 a fog.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub bloom: f32,
    /// Tone curve of pictures for screens.
    pub tone: ToneMap,
}

impl Default for RenderSpec {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 960,
            samples: 256,
            bounces: 6,
            exposure_ev: 0.0,
            metering: MeteringSpec::Manual,
            bloom: 0.0,
            tone: ToneMap::Neutral,
        }
    }
}

/// What the mean of a picture becomes by [`MeteringSpec::Average`].
pub const MIDDLE_GREY: f32 = 0.18;

impl RenderSpec {
    /// The exposure of a picture of this radiance, as a power of two.
    pub fn exposure(&self, texels: &[[f32; 3]]) -> f32 {
        let metered = match self.metering {
            MeteringSpec::Manual => 0.0,
            MeteringSpec::Average => Metering::LogAverage(MIDDLE_GREY).exposure_ev(texels),
            MeteringSpec::Highlights => Metering::Percentile { share: 0.99, target: 0.8 }.exposure_ev(texels),
        };
        metered + self.exposure_ev
    }
}

impl EnvironmentSpec {
    /// The file of its picture, if it is one.
    pub fn picture(&self) -> Option<&str> {
        (self.kind == Surroundings::Picture).then_some(self.file.as_str())
    }
}

/// Keys of a scene's root.
pub const KEYS: [&str; 9] =
    ["name", "description", "subject", "ground", "camera", "environment", "light", "material", "render"];

/// Read a scene's document. Warnings come along.
///
/// # Errors
/// Every problem of the document at once.
pub fn read(document: &Document) -> Result<(SceneSpec, Vec<Diagnostic>), PresetError> {
    let mut diagnostics = Diagnostics::new();
    let start = document.sources.sources().first().map_or(0, |s| s.base);
    let whole = |table: Table| toml::Spanned::new(start..start, Item::Table(table));
    for (key, value) in &document.root {
        let word = key.get_ref().as_str();
        if !KEYS.contains(&word) {
            let diagnostic =
                Diagnostic::error("unknown-key", format!("unknown key `{word}`")).at(key.span(), "");
            diagnostics.push(match suggest::help(word, &KEYS) {
                Some(help) => diagnostic.help(help),
                None => diagnostic,
            });
            continue;
        }
        // One section at a time, so that messages name it.
        let what = match word {
            "name" | "description" => "the scene".into(),
            "light" => "[[light]]".into(),
            _ => format!("[{word}]"),
        };
        let alone: Table = [(key.clone(), value.clone())].into_iter().collect();
        let alone = toml::Spanned::new(value.span(), Item::Table(alone));
        let _: Option<SceneSpec> = section::read(&alone, &what, &mut diagnostics);
    }
    let root = whole(document.root.clone());
    let mut spec = None;
    if !diagnostics.has_errors() {
        spec = section::read::<SceneSpec>(&root, "the scene", &mut diagnostics);
    }
    if let Some(spec) = &spec {
        check(spec, &root, &mut diagnostics);
    }
    let mut spec = spec.unwrap_or_default();
    if spec.name.is_empty() {
        spec.name = stem(&document.name);
    }
    let warnings = diagnostics.finish(&document.sources)?;
    Ok((spec, warnings))
}

/// What no single key can tell.
fn check(spec: &SceneSpec, root: &crate::preset::Value, diagnostics: &mut Diagnostics) {
    let at = |path: &str| section::span_of(root, path);
    let subject = &spec.subject;
    let snake = subject.form.pose().is_some();
    if let Some(length) = subject.length.filter(|length| snake && *length < 16.0) {
        let message = format!("a snake of {length} diameters is too stout to lie in a pose");
        let help = "write 16 or more; for a piece of body take form = \"cylinder\"";
        diagnostics.push(Diagnostic::error("out-of-range", message).at(at("subject.length"), "").help(help));
    }
    let environment = &spec.environment;
    if environment.kind == Surroundings::Picture && environment.file.is_empty() {
        let message = "a picture needs its file";
        let help = "add file = \"studio.exr\", relative to the scene";
        diagnostics.push(Diagnostic::error("missing-key", message).at(at("environment.kind"), "").help(help));
    }
    let sky = environment.kind != Surroundings::None && environment.strength > 0.0;
    if !sky && !spec.light.iter().any(|light| light.strength > 0.0) {
        let message = "nothing shines: there is neither an environment nor a light";
        let help = "add a [[light]], or take another [environment] kind";
        diagnostics.push(Diagnostic::warning("no-light", message).at(at("environment.kind"), "").help(help));
    }
}

/// The text's name without folder and ending.
fn stem(path: &str) -> String {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem).into()
}

/// The JSON Schema (draft 2020-12) of scenes, for editors that complete and check TOML.
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(SceneSpec).to_value();
    schema["title"] = json!("Ophidian scene");
    if let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        properties.insert(
            "include".into(),
            json!({
                "description": "Scenes that this one is laid over; of several the later wins.",
                "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }],
            }),
        );
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::SkinOptics;
    use crate::optics::layered::Constants;
    use crate::preset::overrides;
    use std::path::Path;

    #[test]
    fn an_empty_text_is_the_default_scene_named_by_its_file() {
        let document = Document::parse("a/my snake.toml", "").expect("valid TOML");
        let (spec, warnings) = read(&document).expect("sound");
        assert!(warnings.is_empty());
        assert_eq!(spec, SceneSpec { name: "my snake".into(), ..SceneSpec::default() });
        assert_eq!(spec.material.constants(SkinOptics::default()), Constants::default());
    }

    #[test]
    fn overrides_reach_every_section() {
        let mut document = Document::parse("a.toml", "[[light]]\nkind = 'sun'").expect("valid TOML");
        let mut diagnostics = Diagnostics::new();
        for setting in ["camera.f_number=8", "material.n_film=1.4", "subject.form='plane'"] {
            assert!(overrides::apply(&mut document, setting, &mut diagnostics), "{setting}");
        }
        let (spec, _) = read(&document).expect("sound");
        assert_eq!((spec.camera.f_number, spec.material.n_film), (Some(8.0), Some(1.4)));
        let skin = SkinOptics { n_film: Some(1.5), n_layer: Some(1.7), ..SkinOptics::default() };
        assert_eq!(spec.material.constants(skin).indices, [1.0, 1.4, 1.7], "the scene's own keys win");
        assert_eq!((spec.subject.form, spec.light[0].kind), (Form::Plane, Lamp::Sun));
    }

    #[test]
    fn darkness_is_a_warning() {
        let document = Document::parse("a.toml", "environment.kind = 'none'").expect("valid TOML");
        let (_, warnings) = read(&document).expect("sound");
        assert_eq!(warnings.iter().map(|w| w.code).collect::<Vec<_>>(), ["no-light"]);
    }

    /// `tests/bad_scenes/*.toml`, each with the messages that it gives. `UPDATE_GOLDEN=1` rewrites them, and then fails.
    #[test]
    fn every_broken_scene_gives_its_messages() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_scenes");
        let update = std::env::var_os("UPDATE_GOLDEN").is_some();
        let mut paths: Vec<_> =
            std::fs::read_dir(folder).expect("the folder").map(|e| e.expect("an entry").path()).collect();
        paths.sort();
        let mut count = 0;
        for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
            let text = std::fs::read_to_string(path).expect("a text");
            let name = path.file_name().and_then(|n| n.to_str()).expect("an ASCII name");
            let error = Document::parse(name, &text).and_then(|d| read(&d)).expect_err(name).to_string();
            let golden = path.with_extension("txt");
            if update {
                std::fs::write(&golden, &error).expect("a text to write");
            }
            assert_eq!(error, std::fs::read_to_string(&golden).unwrap_or_default(), "{name}");
            count += 1;
        }
        assert!(count >= 4 && !update, "{count}: look at what was rewritten");
    }

    #[test]
    fn the_schema_describes_every_key_and_its_references_resolve() {
        fn walk(root: &Value, value: &Value) {
            match value {
                Value::Object(object) => {
                    if let Some(target) = object.get("$ref").and_then(Value::as_str) {
                        let pointer = target.strip_prefix('#').expect("a local reference");
                        assert!(root.pointer(pointer).is_some(), "{target}");
                    }
                    if let Some(Value::Object(properties)) = object.get("properties") {
                        for (key, property) in properties {
                            assert!(property.get("description").is_some(), "{key} has no description");
                        }
                    }
                    object.values().for_each(|v| walk(root, v));
                }
                Value::Array(items) => items.iter().for_each(|v| walk(root, v)),
                _ => {}
            }
        }
        let schema = schema();
        walk(&schema, &schema);
        for key in KEYS {
            assert!(schema["properties"].get(key).is_some(), "{key}");
        }
    }
}
