//! `presets`: what is built in.

use std::io::Write as _;

use super::args::Presets;
use super::exit::{Exit, Failure};
use crate::graph::about;
use crate::preset::builtin::{self, BUILTIN};

/// List the built-in presets: name, common name, description.
pub(super) fn run(args: &Presets) -> Result<Exit, Failure> {
    let mut rows = Vec::new();
    for (name, _) in BUILTIN {
        let document = builtin::document(name)?;
        let text = |key| about(&document, key).unwrap_or("").to_owned();
        rows.push((*name, text("common_name"), text("description")));
    }
    let mut out = anstream::stdout();
    if args.json {
        let rows: Vec<_> = rows
            .iter()
            .map(|(name, common, description)| {
                serde_json::json!({ "name": name, "common_name": common, "description": description })
            })
            .collect();
        writeln!(out, "{}", serde_json::Value::from(rows))?;
        return Ok(Exit::Done);
    }
    let width = |of: &dyn Fn(&(&str, String, String)) -> usize| rows.iter().map(of).max().unwrap_or(0);
    let (name_width, common_width) = (width(&|r| r.0.len()), width(&|r| r.1.chars().count()));
    for (name, common, description) in &rows {
        writeln!(out, "{}", format!("{name:name_width$}  {common:common_width$}  {description}").trim_end())?;
    }
    Ok(Exit::Done)
}
