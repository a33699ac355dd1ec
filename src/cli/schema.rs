//! `schema`: the JSON Schema of presets, or of scenes.

use std::io::Write as _;

use super::args::Schema;
use super::exit::{Exit, Failure};
use crate::{graph, scene};

/// Print the schema.
pub(super) fn run(args: &Schema) -> Result<Exit, Failure> {
    let schema = if args.scene { scene::spec::schema() } else { graph::schema() };
    writeln!(anstream::stdout(), "{schema:#}")?;
    Ok(Exit::Done)
}
