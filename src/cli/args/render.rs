//! `render`: a skin, a scene, and how light is followed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Set;
use super::size::{PixelsArg, SizeArg};
use crate::cli::exit::Exit;
use crate::reference::{SamplerKind, Technique};
use crate::scene::tone::ToneMap;

const RENDER_EXAMPLES: &str = "Examples:
  ophidian render xenopeltis_unicolor --spp 256 -o sunbeam.exr
  ophidian render out --scene studio --size 640x480       a directory that `generate` wrote
  ophidian render \"milk snake\" --stage film --transport direct
  ophidian render boa.toml --mesh snake.glb --budget 60s   stop after a minute
  ophidian render boa.toml --scene my_scene.toml --scene-set camera.distance=4";

/// `render`
#[derive(Debug, Args)]
#[command(after_help = format!("{RENDER_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(in crate::cli) struct Render {
    /// A built-in preset by name, a preset file, or a directory that `generate` wrote one set to.
    #[arg(value_name = "PRESET|SET")]
    pub(in crate::cli) skin: String,
    /// A built-in scene (coil, s, straight, loop, studio, macro, thesis, sphere, plane, cylinder) or a scene file.
    #[arg(long, default_value = "coil")]
    pub(in crate::cli) scene: String,
    /// The picture: .exr (linear, with variance and what was hit; a .png is written beside it) or .png.
    #[arg(short, long, value_name = "FILE", default_value = "render.exr")]
    pub(in crate::cli) output: PathBuf,
    /// Paths per pixel; the scene's unless set.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(in crate::cli) spp: Option<u32>,
    /// Pixels of the picture; the scene's unless set.
    #[arg(long, value_name = "WxH")]
    pub(in crate::cli) size: Option<PixelsArg>,
    /// Texels on the longer side of the maps of a preset, or exactly WIDTHxHEIGHT; 2048 unless set.
    #[arg(long, value_name = "N|WxH")]
    pub(in crate::cli) map_size: Option<SizeArg>,
    /// The individual; the preset's own unless set.
    #[arg(long)]
    pub(in crate::cli) seed: Option<u64>,
    #[command(flatten)]
    pub(in crate::cli) set: Set,
    /// Another value for a key of the scene, such as camera.distance=4; may be given many times.
    #[arg(long = "scene-set", value_name = "KEY=VALUE")]
    pub(in crate::cli) scene_settings: Vec<String>,
    /// Which light is followed.
    #[arg(long, value_enum, default_value = "full")]
    pub(in crate::cli) transport: TransportArg,
    /// Most surfaces that a path meets; the scene's unless set.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(in crate::cli) bounces: Option<u32>,
    /// The layers of the skin that there are: the stages of the thesis.
    #[arg(long, value_enum, default_value = "all")]
    pub(in crate::cli) stage: StageArg,
    /// How lights are found.
    #[arg(long, value_enum, default_value = "mis")]
    pub(in crate::cli) technique: TechniqueArg,
    /// Where random numbers come from.
    #[arg(long, value_enum, default_value = "sobol")]
    pub(in crate::cli) sampler: SamplerArg,
    /// Most radiance by way of a second surface or more: removes bright specks, and darkens caustics; none for truth.
    #[arg(long, value_name = "RADIANCE", value_parser = radiance)]
    pub(in crate::cli) clamp: Option<f32>,
    /// Another noise.
    #[arg(long, default_value = "0", value_name = "N")]
    pub(in crate::cli) noise: u32,
    /// A mesh of one's own in place of the scene's subject: .obj or .glb, with texture coordinates. Its unit is a body
    /// diameter, unless subject.mesh_unit_mm of the scene says.
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) mesh: Option<PathBuf>,
    /// Move the surface by so many times the height map: subject.displacement of the scene.
    #[arg(long, allow_negative_numbers = true, value_name = "AMOUNT")]
    pub(in crate::cli) displace: Option<f32>,
    /// Tone curve of the .png; the scene's unless set.
    #[arg(long, value_parser = tone)]
    pub(in crate::cli) tone: Option<ToneMap>,
    /// Added to the scene's exposure, as a power of two.
    #[arg(long, allow_negative_numbers = true, value_name = "EV")]
    pub(in crate::cli) exposure_ev: Option<f32>,
    /// Stop after so many seconds of tracing, with what is there.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(in crate::cli) budget: Option<f64>,
    /// Threads; all cores unless set. The picture does not depend on it.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(in crate::cli) threads: Option<u16>,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,
    /// Print one JSON object on standard output.
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Which light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum TransportArg {
    /// All of it, in wavelengths.
    Full,
    /// What comes straight from lights and environment, in red, green and blue.
    Direct,
    /// The same, and nothing keeps the environment's light off.
    DirectOpen,
}

/// A stage of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum StageArg {
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
pub(in crate::cli) enum TechniqueArg {
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
pub(in crate::cli) enum SamplerArg {
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

pub(super) fn tone(word: &str) -> Result<ToneMap, String> {
    let known = ToneMap::ALL.into_iter().find(|t| t.name() == word);
    known.ok_or_else(|| format!("tone curves: {}", ToneMap::ALL.map(ToneMap::name).join(", ")))
}

fn radiance(word: &str) -> Result<f32, String> {
    word.parse()
        .ok()
        .filter(|r: &f32| *r > 0.0)
        .ok_or_else(|| "a radiance is a number above 0; white paper in the sun has 1".into())
}

pub(super) fn seconds(word: &str) -> Result<f64, String> {
    match word.strip_suffix('s').unwrap_or(word).parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("a time is a number of seconds, 0 to 1000000".into()),
    }
}
