//! `schema`: the JSON Schema of presets.

use std::io::Write as _;

use super::exit::{Exit, Failure};
use crate::graph;

/// Print the schema.
pub(super) fn run() -> Result<Exit, Failure> {
    writeln!(anstream::stdout(), "{:#}", graph::schema())?;
    Ok(Exit::Done)
}
