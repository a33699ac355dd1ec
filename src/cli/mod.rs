//! ATTIC: the command. Arguments, one file per verb, and the only place that draws text for people.
//!
//! Imports everything, imported by nothing but the binary.

mod args;
mod check;
mod completions;
mod csv;
mod exit;
mod film;
mod furnace;
mod generate;
mod graph;
mod load;
mod memory;
mod nodes;
mod presets;
#[cfg(feature = "preview")]
mod preview;
mod progress;
mod render;
mod render_scene;
mod report;
mod schema;
mod signal;
mod stage;
mod trace;
mod verify;
#[cfg(feature = "viewer")]
mod view;

use clap::Parser as _;

use args::{Cli, Verb};
pub use exit::Exit;
use exit::Failure;

use crate::base::simd;

/// Run the command with the process's arguments.
pub fn run() -> Exit {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are asked for, not wrong.
            let _ = error.print();
            return if error.use_stderr() { Exit::Bad } else { Exit::Done };
        }
    };
    match force_simd().and_then(|()| dispatch(&cli.verb)) {
        Ok(exit) => exit,
        Err(failure) => {
            render::failure(&failure);
            failure.exit()
        }
    }
}

fn dispatch(verb: &Verb) -> Result<Exit, Failure> {
    match verb {
        Verb::Generate(args) => generate::run(args),
        Verb::Check(args) => check::run(args),
        Verb::Graph(args) => graph::run(args),
        Verb::Nodes(args) => nodes::run(args),
        Verb::Schema(args) => schema::run(args),
        Verb::Presets(args) => presets::run(args),
        Verb::Verify(args) => verify::run(args),
        #[cfg(feature = "preview")]
        Verb::Preview(args) => preview::run(args),
        #[cfg(feature = "viewer")]
        Verb::View(args) => view::run(args),
        #[cfg(not(feature = "viewer"))]
        Verb::View(_) => Err(Failure::usage(
            "this build of ophidian has no window",
            "cargo install --path . --features viewer",
        )),
        Verb::Render(args) => render_scene::run(args),
        Verb::Film(args) => film::run(args),
        Verb::Report(args) => report::run(args),
        Verb::Completions(args) => completions::run(args),
    }
}

/// `OPHIDIAN_SIMD` forces an instruction set: for tests and bug reports, since the files do not depend on it.
fn force_simd() -> Result<(), Failure> {
    let Some(value) = std::env::var_os("OPHIDIAN_SIMD") else { return Ok(()) };
    let names = simd::Level::ALL.map(simd::Level::name).join(", ");
    match value.to_str().and_then(simd::Level::from_name) {
        Some(level) => {
            let used = simd::force(level);
            if used != level {
                let message = format!("OPHIDIAN_SIMD={}: this machine has no such level", level.name());
                return Err(Failure::usage(message, format!("it has {}", used.name())));
            }
            Ok(())
        }
        None => {
            let message = format!("OPHIDIAN_SIMD={} is no level", load::short(&value.to_string_lossy()));
            Err(Failure::usage(message, format!("levels: {names}")))
        }
    }
}
