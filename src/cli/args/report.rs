//! `report`: what is measured, and where the page goes.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::SizeArg;
use crate::cli::exit::Exit;

/// `report`
#[derive(Debug, Args)]
#[command(after_help = Exit::TABLE)]
pub(in crate::cli) struct Report {
    /// What is reported on.
    #[arg(value_enum, default_value = "optics")]
    pub(in crate::cli) kind: ReportKind,
    /// `convergence`: a built-in scene or a scene file, `studio` unless given. `textures`: a built-in preset or a
    /// preset file, `lampropeltis_triangulum` unless given.
    #[arg(value_name = "SCENE|PRESET")]
    pub(in crate::cli) subject: Option<String>,
    /// `convergence`: a built-in preset, a preset file, or a directory that `generate` wrote one set to.
    #[arg(long, value_name = "PRESET|SET", default_value = "lampropeltis_triangulum")]
    pub(in crate::cli) skin: String,
    /// `textures`: texels on the longer side of the maps; 1024, or 256 if quick, unless given. `preview`: pixels of pictures
    /// that are compared; 192x144, or 48x36 if quick, unless given, and a width alone has 3 rows for each 4 columns.
    #[arg(long, value_name = "N|WxH")]
    pub(in crate::cli) size: Option<SizeArg>,
    /// Directory of the files; it is made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "report")]
    pub(in crate::cli) output: PathBuf,
    /// Seconds instead of minutes: fewer films, random cases, texels and rounds.
    #[arg(long)]
    pub(in crate::cli) quick: bool,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,
    /// Print all numbers as JSON on standard output.
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// What is reported on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ReportKind {
    /// Light on skin: films, methods, extreme cases.
    Optics,
    /// The path tracer on a scene: noise against samples and seconds, and what is left out.
    Convergence,
    /// The maps of a preset: every approximation in its graph, drafts, and encodings.
    Textures,
    /// The preview on this machine's graphics adapter: pictures against the path tracer's, and times.
    #[cfg(feature = "preview")]
    Preview,
}
