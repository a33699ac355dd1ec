//! `nodes`: the operations, and the reference page of one.

use std::io::Write as _;

use super::args::Nodes;
use super::exit::{Exit, Failure};
use super::load::short;
use crate::graph::reference;
use crate::node;
use crate::preset::suggest;

/// List the operations by category, or show one.
pub(super) fn run(args: &Nodes) -> Result<Exit, Failure> {
    let Some(name) = &args.op else {
        anstream::stdout().write_all(reference::index().as_bytes())?;
        return Ok(Exit::Done);
    };
    match node::find(name) {
        Some(op) => {
            anstream::stdout().write_all(reference::page(op).as_bytes())?;
            Ok(Exit::Done)
        }
        None => {
            let names: Vec<&str> = node::ops().map(|op| op.spec.name).collect();
            let help = match suggest::nearest(name, names) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "`ophidian nodes` lists them".into(),
            };
            Err(Failure::usage(format!("there is no operation `{}`", short(name)), help))
        }
    }
}
