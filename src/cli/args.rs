//! What was typed, only validated: no file is opened here.

use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::exit::Exit;
use crate::base::{Domain, MapKind, domain::MAX_SIDE};
use crate::io::NameTemplate;
use crate::maps::Depth;
use crate::optics::Method;
use crate::preset::suggest;
use crate::reference::{SamplerKind, Technique};
use crate::scene::tone::ToneMap;

const EXAMPLES: &str = "Examples:
  ophidian generate lampropeltis_triangulum -o out
  ophidian generate my_snake.toml --size 4096 --maps five --normal both
  ophidian generate \"milk snake\" --seeds 0..50 --set scales.overlap=0.4 --json
  ophidian check my_snake.toml
  ophidian graph my_snake.toml --format dot | dot -Tsvg -o graph.svg
  ophidian nodes worley";

const GENERATE_EXAMPLES: &str = "Examples:
  ophidian generate lampropeltis_triangulum -o out
  ophidian generate presets/*.toml --size 1024 -o out       many presets, a set each
  ophidian generate milk_snake.toml --seeds 0..50           fifty individuals
  ophidian generate milk_snake.toml --set pattern.size=0.3  another value, same checks
  ophidian generate milk_snake.toml --size 512x1024 --format png,exr --depth 16 --verify";

const FILM_EXAMPLES: &str = "Examples:
  ophidian film --thickness-nm 400                       colour of keratin on skin, seen along the normal
  ophidian film --thickness-nm 400 --angle-deg 60 --method three
  ophidian film --thickness-nm 400 --lambda-nm 550       R and T
  ophidian film --csv rows.csv -o results.csv --tolerance 1e-12";

const RENDER_EXAMPLES: &str = "Examples:
  ophidian render xenopeltis_unicolor --spp 256 -o sunbeam.exr
  ophidian render out --scene studio --size 640x480       a directory that `generate` wrote
  ophidian render \"milk snake\" --stage film --transport direct
  ophidian render boa.toml --mesh snake.glb --budget 60s   stop after a minute
  ophidian render boa.toml --scene my_scene.toml --scene-set camera.distance=4";

/// Makes tileable, registered snake-skin textures from a preset and a seed.
#[derive(Debug, Parser)]
#[command(name = "ophidian", version, after_help = format!("{EXAMPLES}\n\n{}", Exit::TABLE), max_term_width = 110)]
pub(super) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(super) verb: Verb,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Make texture sets.
    Generate(Box<Generate>),
    /// Tell everything that is wrong with presets; write nothing.
    Check(Check),
    /// Print the graph that a preset becomes: as a preset of nodes only, for Graphviz, for Mermaid, or as JSON.
    Graph(Graph),
    /// List the operations that nodes are made of, or show the reference page of one.
    Nodes(Nodes),
    /// List the built-in presets.
    Presets(Presets),
    /// Print the JSON Schema of presets or scenes, for editors that complete and check TOML.
    Schema(Schema),
    /// Compare texture sets with their manifest.
    Verify(Verify),
    /// Render a skin on the subject of a scene by path tracing: the ground truth.
    Render(Box<Render>),
    /// Compute what a thin film reflects: one film, or the rows of a table.
    Film(Film),
    /// Measure what every shortcut costs: error against time, as a page, CSV and JSON.
    Report(Report),
    /// Print a script that completes commands in a shell.
    Completions(Completions),
}

/// `generate`
#[derive(Debug, Args)]
#[command(after_help = format!("{GENERATE_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(super) struct Generate {
    /// Built-in presets by scientific or common name, or preset files.
    #[arg(required = true, value_name = "PRESET")]
    pub(super) presets: Vec<String>,
    /// Directory of the files; it is made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    /// Texels on the longer side (64 to 16384 are sensible), or exactly WIDTHxHEIGHT.
    #[arg(long, default_value = "2048", value_name = "N|WxH")]
    pub(super) size: SizeArg,
    /// The individual; the preset's own unless set.
    #[arg(long, conflicts_with = "seeds")]
    pub(super) seed: Option<u64>,
    /// Several individuals, the last one excluded: 0..50 makes fifty sets.
    #[arg(long, value_name = "A..B")]
    pub(super) seeds: Option<SeedsArg>,
    /// Maps, with commas: color, height, normal, roughness, iridescence, ambient_occlusion, curvature, translucency,
    /// scale_id, pattern_mask; or `five` for the first five; or `all` that the preset has.
    #[arg(long, default_value = "all")]
    pub(super) maps: MapsArg,
    #[command(flatten)]
    pub(super) set: Set,
    /// File formats, with commas; exr-layers is one file of all maps.
    #[arg(long, value_delimiter = ',', default_value = "png")]
    pub(super) format: Vec<Format>,
    /// Bits of PNG samples, for all maps or by map: `16` or `color=16,normal=16`.
    #[arg(long, value_name = "BITS")]
    pub(super) depth: Option<DepthArg>,
    /// Which way the green of normals points: OpenGL up, DirectX down, or a file of each.
    #[arg(long, value_enum, default_value = "gl")]
    pub(super) normal: NormalArg,
    /// File names, with {preset}, {map}, {seed}, {size} and {ext}.
    #[arg(long, value_name = "TEMPLATE")]
    pub(super) name: Option<String>,
    /// Threads; all cores unless set. The files do not depend on it.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Most memory for maps, such as 4G or 512M; what is free unless set.
    #[arg(long, value_name = "SIZE")]
    pub(super) memory: Option<BytesArg>,
    /// Read every file back and compare before it takes its name.
    #[arg(long)]
    pub(super) verify: bool,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Print one JSON object per set on standard output.
    #[arg(long)]
    pub(super) json: bool,
}

/// `render`
#[derive(Debug, Args)]
#[command(after_help = format!("{RENDER_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(super) struct Render {
    /// A built-in preset by name, a preset file, or a directory that `generate` wrote one set to.
    #[arg(value_name = "PRESET|SET")]
    pub(super) skin: String,
    /// A built-in scene (coil, s, straight, loop, studio, macro, thesis, sphere, plane, cylinder) or a scene file.
    #[arg(long, default_value = "coil")]
    pub(super) scene: String,
    /// The picture: .exr (linear, with variance and what was hit; a .png is written beside it) or .png.
    #[arg(short, long, value_name = "FILE", default_value = "render.exr")]
    pub(super) output: PathBuf,
    /// Paths per pixel; the scene's unless set.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(super) spp: Option<u32>,
    /// Pixels of the picture; the scene's unless set.
    #[arg(long, value_name = "WxH")]
    pub(super) size: Option<PixelsArg>,
    /// Texels on the longer side of the maps of a preset, or exactly WIDTHxHEIGHT.
    #[arg(long, default_value = "2048", value_name = "N|WxH")]
    pub(super) map_size: SizeArg,
    /// The individual; the preset's own unless set.
    #[arg(long)]
    pub(super) seed: Option<u64>,
    #[command(flatten)]
    pub(super) set: Set,
    /// Another value for a key of the scene, such as camera.distance=4; may be given many times.
    #[arg(long = "scene-set", value_name = "KEY=VALUE")]
    pub(super) scene_settings: Vec<String>,
    /// Which light is followed.
    #[arg(long, value_enum, default_value = "full")]
    pub(super) transport: TransportArg,
    /// Most surfaces that a path meets; the scene's unless set.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(super) bounces: Option<u32>,
    /// The layers of the skin that there are: the stages of the thesis.
    #[arg(long, value_enum, default_value = "all")]
    pub(super) stage: StageArg,
    /// How lights are found.
    #[arg(long, value_enum, default_value = "mis")]
    pub(super) technique: TechniqueArg,
    /// Where random numbers come from.
    #[arg(long, value_enum, default_value = "sobol")]
    pub(super) sampler: SamplerArg,
    /// Most radiance by way of a second surface or more: removes bright specks, and darkens caustics; none for truth.
    #[arg(long, value_name = "RADIANCE", value_parser = radiance)]
    pub(super) clamp: Option<f32>,
    /// Another noise.
    #[arg(long, default_value = "0", value_name = "N")]
    pub(super) noise: u32,
    /// A mesh of one's own in place of the scene's subject: .obj or .glb, with texture coordinates.
    #[arg(long, value_name = "FILE")]
    pub(super) mesh: Option<PathBuf>,
    /// Move the surface by so many times the height map: subject.displacement of the scene.
    #[arg(long, allow_negative_numbers = true, value_name = "AMOUNT")]
    pub(super) displace: Option<f32>,
    /// Tone curve of the .png; the scene's unless set.
    #[arg(long, value_parser = tone)]
    pub(super) tone: Option<ToneMap>,
    /// Added to the scene's exposure, as a power of two.
    #[arg(long, allow_negative_numbers = true, value_name = "EV")]
    pub(super) exposure_ev: Option<f32>,
    /// Stop after so many seconds of tracing, with what is there.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) budget: Option<f64>,
    /// Threads; all cores unless set. The picture does not depend on it.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Print one JSON object on standard output.
    #[arg(long)]
    pub(super) json: bool,
}

/// Which light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum TransportArg {
    /// All of it, in wavelengths.
    Full,
    /// What comes straight from lights and environment, in red, green and blue.
    Direct,
    /// The same, and nothing keeps the environment's light off.
    DirectOpen,
}

/// A stage of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum StageArg {
    /// The colour map on a matt surface.
    Diffuse,
    /// That, with the normal map.
    Normal,
    /// What the film reflects, alone.
    Film,
    /// All layers.
    All,
}

/// How lights are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum TechniqueArg {
    /// By chance.
    Bsdf,
    /// By asking a light at each surface.
    Nee,
    /// Both, weighted.
    Mis,
}

impl From<TechniqueArg> for Technique {
    fn from(arg: TechniqueArg) -> Self {
        match arg {
            TechniqueArg::Bsdf => Self::Bsdf,
            TechniqueArg::Nee => Self::NextEvent,
            TechniqueArg::Mis => Self::Mis,
        }
    }
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum SamplerArg {
    /// Owen-scrambled Sobol points.
    Sobol,
    /// Independent numbers.
    Independent,
}

impl From<SamplerArg> for SamplerKind {
    fn from(arg: SamplerArg) -> Self {
        match arg {
            SamplerArg::Sobol => Self::Sobol,
            SamplerArg::Independent => Self::Independent,
        }
    }
}

/// Width and height of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PixelsArg(pub(super) [usize; 2]);

impl FromStr for PixelsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse()? {
            SizeArg::Exact(width, height) => Ok(Self([width, height])),
            SizeArg::Longer(_) => Err("a picture has a width and a height, such as 960x540".into()),
        }
    }
}

fn tone(word: &str) -> Result<ToneMap, String> {
    let name = |t: &ToneMap| format!("{t:?}").to_ascii_lowercase();
    ToneMap::ALL.into_iter().find(|t| name(t) == word).ok_or_else(|| {
        format!("tone curves: {}", ToneMap::ALL.iter().map(name).collect::<Vec<_>>().join(", "))
    })
}

fn radiance(word: &str) -> Result<f32, String> {
    word.parse()
        .ok()
        .filter(|r: &f32| *r > 0.0)
        .ok_or_else(|| "a radiance is a number above 0; white paper in the sun has 1".into())
}

fn seconds(word: &str) -> Result<f64, String> {
    match word.strip_suffix('s').unwrap_or(word).parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("a time is a number of seconds, 0 to 1000000".into()),
    }
}

/// `check`
#[derive(Debug, Args)]
pub(super) struct Check {
    /// Built-in presets by name, or preset files.
    #[arg(required = true, value_name = "PRESET")]
    pub(super) presets: Vec<String>,
    #[command(flatten)]
    pub(super) set: Set,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// Values over a preset's.
#[derive(Debug, Args)]
pub(super) struct Set {
    /// Another value for a key of the preset, such as pattern.size=0.3; may be given many times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) settings: Vec<String>,
}

/// `schema`
#[derive(Debug, Args)]
pub(super) struct Schema {
    /// The schema of scenes in place of that of presets.
    #[arg(long)]
    pub(super) scene: bool,
}

/// `graph`
#[derive(Debug, Args)]
pub(super) struct Graph {
    /// A built-in preset by name, or a preset file.
    pub(super) preset: String,
    /// The form; toml reads back as a preset that makes the same bytes.
    #[arg(long, value_enum, default_value = "toml")]
    pub(super) format: GraphFormat,
    /// Maps for which needed nodes, memory and time are told, as for `generate`.
    #[arg(long, default_value = "all")]
    pub(super) maps: MapsArg,
    /// Size for which memory and time are told, as for `generate`.
    #[arg(long, default_value = "2048", value_name = "N|WxH")]
    pub(super) size: SizeArg,
    /// The individual; the preset's own unless set.
    #[arg(long)]
    pub(super) seed: Option<u64>,
    #[command(flatten)]
    pub(super) set: Set,
}

/// A form of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum GraphFormat {
    /// A preset of nodes only.
    Toml,
    /// Graphviz: `dot -Tsvg`.
    Dot,
    /// Mermaid, which many web pages draw.
    Mermaid,
    /// JSON, for programs.
    Json,
}

/// `nodes`
#[derive(Debug, Args)]
pub(super) struct Nodes {
    /// The operation to show; all are listed without it.
    pub(super) op: Option<String>,
}

/// `presets`
#[derive(Debug, Args)]
pub(super) struct Presets {
    /// Print a JSON array.
    #[arg(long)]
    pub(super) json: bool,
}

/// `verify`
#[derive(Debug, Args)]
pub(super) struct Verify {
    /// A directory with a manifest.json.
    pub(super) dir: PathBuf,
    /// Make every set again and compare the bytes.
    #[arg(long)]
    pub(super) rebuild: bool,
    /// Preset files for --rebuild, of sets that are not of built-in presets.
    #[arg(long, value_name = "FILE", requires = "rebuild")]
    pub(super) preset: Vec<String>,
    #[command(flatten)]
    pub(super) set: Set,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// `film`
#[derive(Debug, Args)]
#[command(after_help = format!("{FILM_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(super) struct Film {
    /// Refractive index outside, where the light comes from (1 is air).
    #[arg(long, default_value_t = 1.0)]
    pub(super) n0: f64,
    /// Refractive index of the film (keratin is about 1.55).
    #[arg(long, default_value_t = 1.55)]
    pub(super) n1: f64,
    /// Refractive index below the film.
    #[arg(long, default_value_t = 2.0)]
    pub(super) n2: f64,
    /// Thickness of the film, nm; 0 is a plain interface.
    #[arg(long, value_name = "NM", required_unless_present_any = ["csv", "plot", "furnace"])]
    pub(super) thickness_nm: Option<f64>,
    /// Angle of incidence from the normal, degrees, 0 to 90.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    pub(super) angle_deg: f64,
    /// Print R and T at this wavelength, nm.
    #[arg(long, value_name = "NM", conflicts_with_all = ["color", "method"])]
    pub(super) lambda_nm: Option<f64>,
    /// Print the colour under daylight (D65); this is what is done without --lambda-nm.
    #[arg(long, visible_alias = "colour")]
    pub(super) color: bool,
    /// Compute the rows of a table: columns n0, n1, n2, d_nm, cos_theta, and lambda_nm for R and T; differences from
    /// columns R, T or lin_r, lin_g, lin_b are told.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["n0", "n1", "n2", "thickness_nm", "angle_deg", "lambda_nm", "color"])]
    pub(super) csv: Option<PathBuf>,
    /// Compute the furnace of a whole skin for the rows of a table, what comes back of light from everywhere: columns n0,
    /// n1, n2, d_nm, lambda_nm, roughness, kd, tau, cos_o.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["csv", "plot", "n0", "n1", "n2", "thickness_nm", "angle_deg", "lambda_nm", "color", "method", "precision"])]
    pub(super) furnace: Option<PathBuf>,
    /// File of the rows of --csv or --furnace; standard output unless set.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// End with code 1 if any result of --csv or --furnace differs by more than this from the expected one.
    #[arg(long, value_name = "ERROR")]
    pub(super) tolerance: Option<f64>,
    /// How colours are computed: reference, series-K (K terms), uniform-N (N wavelengths), three (as in the thesis),
    /// three-best, belcour-gltf (as viewers do), belcour, belcour-white, lut-N or lut-NxM (cosines and thicknesses).
    #[arg(long)]
    pub(super) method: Option<Method>,
    /// Draw the colour against thickness and angle into this SVG file; the curves are at --angle-deg.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["csv", "lambda_nm"])]
    pub(super) plot: Option<PathBuf>,
    /// Numbers that are computed with.
    #[arg(long, value_enum, default_value = "f64")]
    pub(super) precision: Precision,
    /// Print JSON: the result, or an object for each row of a table; its differences where -o has the rows.
    #[arg(long)]
    pub(super) json: bool,
}

/// `report`
#[derive(Debug, Args)]
#[command(after_help = Exit::TABLE)]
pub(super) struct Report {
    /// What is reported on.
    #[arg(value_enum, default_value = "optics")]
    pub(super) kind: ReportKind,
    /// `convergence`: a built-in scene or a scene file.
    #[arg(default_value = "studio")]
    pub(super) scene: String,
    /// `convergence`: a built-in preset, a preset file, or a directory that `generate` wrote one set to.
    #[arg(long, value_name = "PRESET|SET", default_value = "lampropeltis_triangulum")]
    pub(super) skin: String,
    /// Directory of the files; it is made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "report")]
    pub(super) output: PathBuf,
    /// Seconds instead of minutes: fewer films and random cases.
    #[arg(long)]
    pub(super) quick: bool,
    /// Print all numbers as JSON on standard output.
    #[arg(long)]
    pub(super) json: bool,
}

/// What is reported on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ReportKind {
    /// Light on skin: films, methods, extreme cases.
    Optics,
    /// The path tracer on a scene: noise against samples and seconds, and what is left out.
    Convergence,
}

/// Numbers that are computed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Precision {
    /// Single precision, as in shading.
    F32,
    /// Double precision.
    F64,
}

/// `completions`
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// The shell.
    pub(super) shell: clap_complete::Shell,
}

/// A size in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SizeArg {
    /// The longer side; the other one follows from the tile.
    Longer(usize),
    /// Both.
    Exact(usize, usize),
}

impl SizeArg {
    /// The grid of a tile of this physical size.
    pub(super) fn domain(self, girth_mm: f32, length_mm: f32) -> Domain {
        match self {
            Self::Longer(n) => Domain::from_longer_side(n, girth_mm, length_mm),
            Self::Exact(width, height) => Domain { width, height, girth_mm, length_mm },
        }
    }
}

impl FromStr for SizeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| match text.parse::<usize>() {
            Ok(n) if (1..=MAX_SIDE).contains(&n) => Ok(n),
            // A number that no integer holds is a number still.
            _ if !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit()) => {
                Err(format!("a side has 1 to {MAX_SIDE} texels"))
            }
            _ => Err("write the texels of the longer side, such as 2048, or WIDTHxHEIGHT".to_owned()),
        };
        match text.split_once(['x', 'X', '×']) {
            Some((w, h)) => Ok(Self::Exact(side(w)?, side(h)?)),
            None => side(text).map(Self::Longer),
        }
    }
}

/// Seeds, the last excluded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SeedsArg(pub(super) Range<u64>);

impl FromStr for SeedsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || "write two whole numbers, such as 0..50 (0 to 49) or 1..=50 (1 to 50)".to_owned();
        let (a, b) = text.split_once("..").ok_or_else(bad)?;
        let a: u64 = a.trim().parse().map_err(|_| bad())?;
        let end = match b.strip_prefix('=') {
            Some(b) => b.trim().parse::<u64>().ok().and_then(|b| b.checked_add(1)),
            None => b.trim().parse().ok(),
        };
        let b = end.ok_or_else(bad)?;
        if a >= b {
            return Err(format!(
                "{text} is empty; the end is excluded: {a}..{} is one set",
                a.saturating_add(1)
            ));
        }
        Ok(Self(a..b))
    }
}

/// Which maps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum MapsArg {
    /// All that the preset has.
    All,
    /// These.
    List(Vec<MapKind>),
}

impl FromStr for MapsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut list = Vec::new();
        for word in text.split(',').map(str::trim) {
            match word {
                "all" => return Ok(Self::All),
                "five" => list.extend(MapKind::FIVE),
                _ => list.push(map_kind(word)?),
            }
        }
        list.sort();
        list.dedup();
        Ok(Self::List(list))
    }
}

fn map_kind(word: &str) -> Result<MapKind, String> {
    MapKind::from_name(word).ok_or_else(|| {
        let mut names = MapKind::ALL.map(MapKind::name).to_vec();
        names.extend(["five", "all"]);
        let help = suggest::help(word, &names).unwrap_or_default();
        format!("there is no map `{word}`; {help}")
    })
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// A PNG per map.
    Png,
    /// An OpenEXR file per map, in physical units.
    Exr,
    /// One OpenEXR file with a layer per map.
    ExrLayers,
}

/// Which normal maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum NormalArg {
    /// Green up: glTF, Blender, Godot, Unity.
    Gl,
    /// Green down: Unreal.
    Dx,
    /// A file of each.
    Both,
}

/// Depths of PNG files, all or by map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DepthArg(pub(super) Vec<(MapKind, Depth)>);

impl FromStr for DepthArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let depth = |text: &str| match text {
            "8" => Ok(Depth::Eight),
            "16" => Ok(Depth::Sixteen),
            _ => Err("depths are 8 and 16: write one for all maps, or by map, color=16,normal=8".to_owned()),
        };
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                Some((map, bits)) => list.push((map_kind(map)?, depth(bits)?)),
                None => {
                    let depth = depth(part)?;
                    list.extend(MapKind::ALL.map(|kind| (kind, depth)));
                }
            }
        }
        Ok(Self(list))
    }
}

/// An amount of memory, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BytesArg(pub(super) u64);

impl FromStr for BytesArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || "write a number with K, M, G or T, such as 4G or 512M (powers of 1024)".to_owned();
        let text = text.trim();
        let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
        let text = text.strip_suffix(['i']).unwrap_or(text);
        let shift = match text.chars().last().map(|c| c.to_ascii_uppercase()) {
            Some('K') => 10,
            Some('M') => 20,
            Some('G') => 30,
            Some('T') => 40,
            _ => 0,
        };
        let digits = if shift > 0 { &text[..text.len() - 1] } else { text };
        let number: f64 = digits.parse().map_err(|_| bad())?;
        let bytes = number * (1u64 << shift) as f64;
        if bytes >= 0.0 && bytes < u64::MAX as f64 { Ok(Self(bytes as u64)) } else { Err(bad()) }
    }
}

/// The template of file names: the one given, or one that keeps several seeds apart.
pub(super) fn names(given: Option<&str>, several_seeds: bool) -> Result<NameTemplate, super::Failure> {
    let text =
        given.unwrap_or(if several_seeds { "{preset}_{seed}_{map}.{ext}" } else { "{preset}_{map}.{ext}" });
    if several_seeds && !text.contains("{seed}") {
        let help = "put {seed} into it: {preset}_{seed}_{map}.{ext}";
        return Err(super::Failure::usage("--name gives every seed the same file names", help));
    }
    text.parse().map_err(|e| super::Failure::usage(e, "such as {preset}_{map}.{ext}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_arguments_are_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes_are_one_or_two_sides_within_bounds() {
        assert_eq!("2048".parse(), Ok(SizeArg::Longer(2048)));
        assert_eq!("64x128".parse(), Ok(SizeArg::Exact(64, 128)));
        for bad in ["0", "0x0", "64x0", "1000000000", "99999999999999999999999", "65537", "", "x", "-4", "2k"]
        {
            assert!(bad.parse::<SizeArg>().is_err(), "{bad}");
        }
    }

    #[test]
    fn seeds_are_ranges_that_hold_something() {
        assert_eq!("3..5".parse(), Ok(SeedsArg(3..5)));
        assert_eq!("3..=5".parse(), Ok(SeedsArg(3..6)));
        for bad in ["5..5", "6..5", "5", "..", "a..b", "0..=18446744073709551615", "-1..3"] {
            assert!(bad.parse::<SeedsArg>().is_err(), "{bad}");
        }
    }

    #[test]
    fn maps_are_names_five_or_all() {
        assert_eq!("five".parse(), Ok(MapsArg::List(MapKind::FIVE.to_vec())));
        assert_eq!("normal,color,normal".parse(), Ok(MapsArg::List(vec![MapKind::Color, MapKind::Normal])));
        let error = "colour".parse::<MapsArg>().expect_err("British");
        assert!(error.contains("did you mean `color`"), "{error}");
    }

    #[test]
    fn memory_has_units_of_1024() {
        for (text, bytes) in
            [("4G", 4 << 30), ("512MiB", 512 << 20), ("1.5k", 1536), ("7", 7), ("1TB", 1 << 40)]
        {
            assert_eq!(text.parse(), Ok(BytesArg(bytes)), "{text}");
        }
        for bad in ["", "G", "-1G", "lots", "nan", "1e30G"] {
            assert!(bad.parse::<BytesArg>().is_err(), "{bad}");
        }
    }

    #[test]
    fn depths_are_for_all_or_by_map() {
        let of = |text: &str| text.parse::<DepthArg>().map(|d| d.0);
        assert_eq!(of("color=16"), Ok(vec![(MapKind::Color, Depth::Sixteen)]));
        assert_eq!(of("16").map(|d| d.len()), Ok(10));
        assert!(of("12").is_err() && of("colour=8").is_err());
    }
}
