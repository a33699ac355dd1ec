//! What was typed, only validated: no file is opened here.

mod film;
mod generate;
#[cfg(feature = "preview")]
mod preview;
mod render;
mod report;
mod size;
mod view;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::exit::Exit;
pub(super) use film::{Film, Precision};
pub(super) use generate::{
    BytesArg, CompressArg, ExrCompressArg, Format, Generate, MapsArg, NormalArg, names,
};
#[cfg(feature = "preview")]
pub(super) use preview::{BackendArg, Preview};
pub(super) use render::{Render, StageArg, TransportArg};
pub(super) use report::{Report, ReportKind};
pub(super) use size::SizeArg;
pub(super) use view::View;

const EXAMPLES: &str = "Examples:
  ophidian generate lampropeltis_triangulum -o out
  ophidian generate my_snake.toml --size 4096 --maps five --normal both
  ophidian generate \"milk snake\" --seeds 0..50 --set scales.overlap=0.4 --json
  ophidian preview lampropeltis_triangulum -o milk_snake.png
  ophidian view my_snake.toml
  ophidian check my_snake.toml
  ophidian graph my_snake.toml --format dot | dot -Tsvg -o graph.svg
  ophidian nodes worley";

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
    /// Draw a skin on the subject of a scene on a graphics adapter, now.
    #[cfg(feature = "preview")]
    Preview(Box<Preview>),
    /// Open a window: a skin on a snake that turns, with sliders for everything that its preset says.
    View(Box<View>),
    /// Render a skin on the subject of a scene by path tracing: the ground truth.
    Render(Box<Render>),
    /// Compute what a thin film reflects: one film, or the rows of a table.
    Film(Film),
    /// Measure what every shortcut costs: error against time, as a page, CSV and JSON.
    Report(Report),
    /// Print a script that completes commands in a shell.
    Completions(Completions),
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

/// `completions`
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// The shell.
    pub(super) shell: clap_complete::Shell,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_arguments_are_sound() {
        Cli::command().debug_assert();
    }
}
