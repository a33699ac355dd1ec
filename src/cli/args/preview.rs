//! `preview`: a skin, a scene, and what draws it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Set;
use super::render::{seconds, tone};
use super::size::{PixelsArg, SizeArg};
use crate::cli::exit::Exit;
use crate::scene::tone::ToneMap;

const PREVIEW_EXAMPLES: &str = "Examples:
  ophidian preview python_regius -o python.png
  ophidian preview \"sunbeam snake\" --scene studio --set iridescence.thickness_nm=400
  ophidian preview out --explain                   a directory that `generate` wrote, and what drawing it took
  ophidian preview boa.toml --backend cpu --budget 10s";

/// `preview`
#[derive(Debug, Args)]
#[command(after_help = format!("{PREVIEW_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(in crate::cli) struct Preview {
    /// A built-in preset by name, a preset file, or a directory that `generate` wrote one set to.
    #[arg(value_name = "PRESET|SET")]
    pub(in crate::cli) skin: String,
    /// A built-in scene (coil, s, straight, loop, studio, macro, thesis, sphere, plane, cylinder) or a scene file.
    #[arg(long, default_value = "coil")]
    pub(in crate::cli) scene: String,
    /// The picture: a .png.
    #[arg(short, long, value_name = "FILE", default_value = "preview.png")]
    pub(in crate::cli) output: PathBuf,
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
    /// A mesh of one's own in place of the scene's subject: .obj or .glb, with texture coordinates.
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) mesh: Option<PathBuf>,
    /// Move the surface by so many times the height map: subject.displacement of the scene.
    #[arg(long, allow_negative_numbers = true, value_name = "AMOUNT")]
    pub(in crate::cli) displace: Option<f32>,
    /// Tone curve; the scene's unless set.
    #[arg(long, value_parser = tone)]
    pub(in crate::cli) tone: Option<ToneMap>,
    /// Added to the scene's exposure, as a power of two.
    #[arg(long, allow_negative_numbers = true, value_name = "EV")]
    pub(in crate::cli) exposure_ev: Option<f32>,
    /// What draws.
    #[arg(long, value_enum, default_value = "auto")]
    pub(in crate::cli) backend: BackendArg,
    /// Seconds that the path tracer may take where it draws.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "5s")]
    pub(in crate::cli) budget: f64,
    /// Pictures of a graphics adapter that are averaged, each of another place within pixels: what is smaller than a pixel
    /// gets truer, and takes so many times as long. 16 unless set; 1 where the adapter is a program on the CPU.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(in crate::cli) samples: Option<u32>,
    /// Whether objects hide the environment from each other: ambient occlusion, which a graphics adapter sees in the depths of
    /// the picture. Unless set, where the adapter is no program on the CPU.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(in crate::cli) occlusion: Option<bool>,
    /// Look maps up where the view meets the relief of the height map, so many times as high: nearly what --displace shows, but
    /// for outlines and shadows, without its triangles (parallax occlusion mapping). The path tracer does not do it.
    #[arg(long, value_name = "AMOUNT", num_args = 0..=1, require_equals = true, default_missing_value = "1", allow_negative_numbers = true)]
    pub(in crate::cli) parallax: Option<f32>,
    /// Threads; all cores unless set.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(in crate::cli) threads: Option<u16>,
    /// Draw once more, and tell passes of both frames with their milliseconds on the device, files of shaders, and what lies on
    /// the device with bytes.
    #[arg(long)]
    pub(in crate::cli) explain: bool,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,
    /// Print one JSON object on standard output.
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// What draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum BackendArg {
    /// A graphics adapter, software ones too; where there is none, the path tracer.
    Auto,
    /// A graphics adapter.
    Gpu,
    /// The path tracer: light straight from its sources, as a graphics adapter draws it.
    Cpu,
}
