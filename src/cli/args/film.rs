//! `film`: one thin film, or a table of them.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::exit::Exit;
use crate::optics::Method;

const FILM_EXAMPLES: &str = "Examples:
  ophidian film --thickness-nm 400                       colour of keratin on skin, seen along the normal
  ophidian film --thickness-nm 400 --angle-deg 60 --method three
  ophidian film --thickness-nm 400 --lambda-nm 550       R and T
  ophidian film --csv rows.csv -o results.csv --tolerance 1e-12";

/// `film`
#[derive(Debug, Args)]
#[command(after_help = format!("{FILM_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(in crate::cli) struct Film {
    /// Refractive index outside, where the light comes from (1 is air).
    #[arg(long, default_value_t = 1.0)]
    pub(in crate::cli) n0: f64,
    /// Refractive index of the film (keratin is about 1.55).
    #[arg(long, default_value_t = 1.55)]
    pub(in crate::cli) n1: f64,
    /// Refractive index below the film.
    #[arg(long, default_value_t = 2.0)]
    pub(in crate::cli) n2: f64,
    /// Thickness of the film, nm; 0 is a plain interface.
    #[arg(long, value_name = "NM", required_unless_present_any = ["csv", "plot", "furnace"])]
    pub(in crate::cli) thickness_nm: Option<f64>,
    /// Angle of incidence from the normal, degrees, 0 to 90.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    pub(in crate::cli) angle_deg: f64,
    /// Print R and T at this wavelength, nm.
    #[arg(long, value_name = "NM", conflicts_with_all = ["color", "method"])]
    pub(in crate::cli) lambda_nm: Option<f64>,
    /// Print the colour under daylight (D65); this is what is done without --lambda-nm.
    #[arg(long, visible_alias = "colour")]
    pub(in crate::cli) color: bool,
    /// Compute the rows of a table: columns n0, n1, n2, d_nm, cos_theta, and lambda_nm for R and T; differences from
    /// columns R, T or lin_r, lin_g, lin_b are told.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["n0", "n1", "n2", "thickness_nm", "angle_deg", "lambda_nm", "color"])]
    pub(in crate::cli) csv: Option<PathBuf>,
    /// Compute the furnace of a whole skin for the rows of a table, what comes back of light from everywhere: columns n0,
    /// n1, n2, d_nm, lambda_nm, roughness, kd, tau, cos_o.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["csv", "plot", "n0", "n1", "n2", "thickness_nm", "angle_deg", "lambda_nm", "color", "method", "precision"])]
    pub(in crate::cli) furnace: Option<PathBuf>,
    /// File of the rows of --csv or --furnace; standard output unless set.
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// End with code 1 if any result of --csv or --furnace differs by more than this from the expected one.
    #[arg(long, value_name = "ERROR")]
    pub(in crate::cli) tolerance: Option<f64>,
    /// How colours are computed: reference, series-K (K terms), uniform-N (N wavelengths), three (as in the thesis),
    /// three-best, belcour-gltf (as viewers do), belcour, belcour-white, lut-N or lut-NxM (cosines and thicknesses).
    #[arg(long)]
    pub(in crate::cli) method: Option<Method>,
    /// Draw the colour against thickness and angle into this SVG file; the curves are at --angle-deg.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["csv", "lambda_nm"])]
    pub(in crate::cli) plot: Option<PathBuf>,
    /// Numbers that are computed with.
    #[arg(long, value_enum, default_value = "f64")]
    pub(in crate::cli) precision: Precision,
    /// Print JSON: the result, or an object for each row of a table; its differences where -o has the rows.
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Numbers that are computed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Precision {
    /// Single precision, as in shading.
    F32,
    /// Double precision.
    F64,
}
