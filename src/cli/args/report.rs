//! `report`: what is measured, and where the page goes.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::exit::Exit;

/// `report`
#[derive(Debug, Args)]
#[command(after_help = Exit::TABLE)]
pub(in crate::cli) struct Report {
    /// What is reported on.
    #[arg(value_enum, default_value = "optics")]
    pub(in crate::cli) kind: ReportKind,
    /// `convergence`: a built-in scene or a scene file.
    #[arg(default_value = "studio")]
    pub(in crate::cli) scene: String,
    /// `convergence`: a built-in preset, a preset file, or a directory that `generate` wrote one set to.
    #[arg(long, value_name = "PRESET|SET", default_value = "lampropeltis_triangulum")]
    pub(in crate::cli) skin: String,
    /// Directory of the files; it is made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "report")]
    pub(in crate::cli) output: PathBuf,
    /// Seconds instead of minutes: fewer films and random cases.
    #[arg(long)]
    pub(in crate::cli) quick: bool,
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
}
