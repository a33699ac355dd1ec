//! `nodes`: the operations.

use std::io::Write as _;

use super::exit::{Exit, Failure};
use crate::node;

/// List the operations by category.
pub(super) fn run() -> Result<Exit, Failure> {
    let mut out = anstream::stdout();
    let width = node::ops().map(|op| op.spec.name.len()).max().unwrap_or(0);
    let mut category = None;
    for op in node::ops() {
        if category != Some(op.spec.category) {
            let gap = if category.is_some() { "\n" } else { "" };
            writeln!(out, "{gap}{}", op.spec.category.name())?;
            category = Some(op.spec.category);
        }
        writeln!(out, "  {:width$}  {}", op.spec.name, op.spec.summary)?;
    }
    Ok(Exit::Done)
}
