//! The command `ophidian`: see `ophidian --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ophidian::cli::run().into()
}
