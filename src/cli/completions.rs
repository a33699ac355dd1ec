//! `completions`: a script for a shell.

use std::io::Write as _;

use clap::CommandFactory as _;

use super::args::{Cli, Completions};
use super::exit::{Exit, Failure};

/// Print the script.
pub(super) fn run(args: &Completions) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "ophidian", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(Exit::Done)
}
