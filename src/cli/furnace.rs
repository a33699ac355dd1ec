//! `film --furnace`: what a skin sends back of light from everywhere, for the rows of a table.

use std::path::Path;

use rayon::prelude::*;

use super::args::Film as Args;
use super::csv::{self, Csv, Line, Results, TableError};
use super::exit::{Exit, Failure};
use super::film::{Errors, tell};
use crate::optics::Film;
use crate::optics::energy::{self, Furnace};

/// Columns that are needed.
const COLUMNS: [&str; 9] = ["n0", "n1", "n2", "d_nm", "lambda_nm", "roughness", "kd", "tau", "cos_o"];
/// Columns that are computed.
const RESULTS: [&str; 5] = ["E_spec", "E_diff_flat", "E_diff_coupled", "rho_int_flat", "rho_int_coupled"];

/// Compute a table, in f64.
pub(super) fn run(args: &Args, path: &Path) -> Result<Exit, Failure> {
    let file = path.display().to_string();
    let text = csv::read(path, &file)?;
    let refused = |error: TableError| Failure::usage(error, format!("columns: {}", COLUMNS.join(", ")));
    let csv = Csv::parse(&file, &text).map_err(refused)?;
    let columns = csv.columns(COLUMNS).map_err(refused)?;
    let row = |line: &Line<'_>| -> Result<(Film<f64>, [f64; 5]), TableError> {
        let [n0, n1, n2, d, lambda, roughness, kd, tau, cosine] = csv.numbers(line, columns)?;
        let checks = [
            ("lambda_nm", lambda, 1.0, 1e6),
            ("roughness", roughness, 0.0, 1.0),
            ("kd", kd, 0.0, 1.0),
            ("tau", tau, 0.0, f64::INFINITY),
            ("cos_o", cosine, 0.0, 1.0),
        ];
        for (name, value, low, high) in checks {
            if !(low..=high).contains(&value) {
                let problem = format!("{name} = {value} is out of range: {low} to {high}");
                return Err(csv.impossible(line, problem));
            }
        }
        let film = Film::new(n0, n1, n2, d).map_err(|e| csv.impossible(line, e))?;
        Ok((film, [lambda, roughness, kd, tau, cosine]))
    };
    let rows = csv.lines.iter().map(row).collect::<Result<Vec<_>, _>>().map_err(refused)?;
    let results = Results::new(&csv, &RESULTS);
    let expected = results.expected().map_err(refused)?;
    let compute = |(film, [lambda, roughness, kd, tau, cosine]): &(Film<f64>, [f64; 5])| {
        let Furnace { specular, diffuse_flat, diffuse_coupled, internal_flat, internal_coupled } =
            energy::furnace(film, *lambda, *roughness, *kd, *tau, *cosine);
        vec![specular, diffuse_flat, diffuse_coupled, internal_flat, internal_coupled]
    };
    let values: Vec<Vec<f64>> = rows.par_iter().map(compute).collect();
    let mut errors = Errors::default();
    for (values, expected) in values.iter().zip(expected.iter().flatten()) {
        errors.add(values, expected);
    }
    let compared = errors.count > 0.0;
    let report = match (args.json, compared) {
        (true, _) => serde_json::json!({
            "rows": rows.len(),
            "max_error": compared.then_some(errors.max),
            "rms_error": compared.then(|| errors.rms()),
        })
        .to_string(),
        (false, true) => {
            format!(
                "{} rows, furnace: error at most {:.3e}, RMS {:.3e}",
                rows.len(),
                errors.max,
                errors.rms()
            )
        }
        (false, false) => format!("{} rows, furnace", rows.len()),
    };
    let text = results.text(&values, expected.as_deref(), args.json && args.output.is_none());
    tell(args.output.as_deref(), &text, &report)?;
    Ok(if errors.within(args.tolerance) { Exit::Done } else { Exit::Differs })
}
