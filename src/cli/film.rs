//! `film`: reflectance, transmittance and colour of one film, or of the rows of a table.

use std::io::Write as _;
use std::path::Path;

use super::args::{Film as Args, Precision};
use super::csv::{self, Csv, Line, Results, TableError};
use super::exit::{Exit, Failure};
use super::furnace;
use crate::base::{LinearRgb, Srgb8};
use crate::optics::thin_film::MAX_THICKNESS_NM;
use crate::optics::{Film, FilmColor, FilmError, Method, Real, cie};
use crate::report::swatch;

/// Compute one film, or a table.
pub(super) fn run(args: &Args) -> Result<Exit, Failure> {
    if let Some(path) = &args.furnace {
        return furnace::run(args, path);
    }
    if args.precision == Precision::F32 {
        Films::<f32>::new(args).run()
    } else {
        Films::<f64>::new(args).run()
    }
}

/// What to do about a table that cannot be used.
const HELP: &str = "columns: n0, n1, n2, d_nm, cos_theta, and lambda_nm for R and T of one wavelength; without lambda_nm \
                    the colour is computed. Columns R, T or lin_r, lin_g, lin_b, if there, are compared with";

impl From<TableError> for Failure {
    fn from(error: TableError) -> Self {
        Self::usage(error, HELP)
    }
}

/// A row to compute.
struct Row {
    n: [f64; 3],
    d: f64,
    cosine: f64,
    lambda: Option<f64>,
}

impl Row {
    /// What is out of range.
    fn problem(&self) -> Option<String> {
        if !(0.0..=1.0).contains(&self.cosine) {
            return Some(format!(
                "cos_theta = {} is out of range: a cosine of incidence is 0 to 1",
                self.cosine
            ));
        }
        match self.lambda {
            Some(lambda) if !(1.0..=1e6).contains(&lambda) => {
                Some(format!("wavelength = {lambda} nm is out of range: 1 to 1000000 nm"))
            }
            _ => Film::new(self.n[0], self.n[1], self.n[2], self.d).err().map(|e| e.to_string()),
        }
    }
}

struct Films<'a, F: 'static> {
    args: &'a Args,
    method: Method,
    /// With the indices that a table of colours is of.
    colors: ([F; 3], FilmColor<F>),
}

impl<'a, F: Real> Films<'a, F> {
    fn new(args: &'a Args) -> Self {
        let method = args.method.unwrap_or(Method::REFERENCE);
        let indices = [args.n0, args.n1, args.n2].map(F::from_f64);
        Self { args, method, colors: (indices, FilmColor::with_indices(method, indices)) }
    }

    fn run(&mut self) -> Result<Exit, Failure> {
        match (&self.args.csv, &self.args.plot) {
            (Some(path), _) => self.table(path),
            (None, Some(path)) => self.plot(path),
            (None, None) => self.one(),
        }
    }

    /// R and T, or red, green and blue, of a row whose numbers have been checked.
    fn compute(&mut self, row: &Row) -> Result<Vec<f64>, String> {
        let indices = row.n.map(F::from_f64);
        let [n0, n1, n2] = indices;
        if matches!(self.method, Method::Table(..)) && self.colors.0 != indices {
            self.colors = (indices, FilmColor::with_indices(self.method, indices));
        }
        let film = Film::new(n0, n1, n2, F::from_f64(row.d)).map_err(|e| e.to_string())?;
        let cosine = F::from_f64(row.cosine);
        Ok(match row.lambda {
            Some(lambda) => {
                let power = film.power(cosine, F::from_f64(lambda));
                vec![power.reflected.to_f64(), power.transmitted.to_f64()]
            }
            None => self.colors.1.color(&film, cosine).map(F::to_f64).to_vec(),
        })
    }

    /// The angle of --angle-deg.
    fn cosine(&self) -> Result<f64, Failure> {
        match self.args.angle_deg {
            // The cosine of 90 degrees is 0, whatever pi is rounded to.
            90.0 => Ok(0.0),
            degrees @ 0.0..90.0 => Ok(libm::cos(degrees.to_radians())),
            degrees => Err(Failure::usage(
                format!("--angle-deg {degrees} is out of range"),
                "0 is along the normal, 90 is grazing",
            )),
        }
    }

    /// A picture of this film and of thinner and thicker ones.
    fn plot(&self, path: &Path) -> Result<Exit, Failure> {
        let (args, thickness) = (self.args, self.args.thickness_nm.unwrap_or(0.0));
        self.cosine()?;
        let indices = [args.n0, args.n1, args.n2];
        let refused = |e: FilmError| Failure::usage(e, "see `ophidian film --help`");
        Film::new(args.n0, args.n1, args.n2, thickness).map_err(refused)?;
        // The least of 1, 2, 5 times a power of ten that leaves some room.
        let tens = std::iter::successors(Some(1000.0), |d| Some(d * 10.0));
        let ends = tens.flat_map(|d| [d, 2.0 * d, 5.0 * d]).take_while(|d| *d <= MAX_THICKNESS_NM);
        let end = ends.into_iter().find(|d| *d >= 1.25 * thickness).unwrap_or(MAX_THICKNESS_NM);
        let colors = FilmColor::with_indices(self.method, indices);
        let svg = swatch::film(&colors, indices, end, args.angle_deg).map_err(refused)?;
        write(path, &svg)?;
        Ok(Exit::Done)
    }

    fn one(&mut self) -> Result<Exit, Failure> {
        let args = self.args;
        let cosine = self.cosine()?;
        let row = Row {
            n: [args.n0, args.n1, args.n2],
            // Clap asks for it where there is no table.
            d: args.thickness_nm.unwrap_or(0.0),
            cosine,
            lambda: args.lambda_nm,
        };
        if let Some(problem) = row.problem() {
            return Err(Failure::usage(problem, "see `ophidian film --help`"));
        }
        let values = self.compute(&row).map_err(|e| Failure::usage(e, "see `ophidian film --help`"))?;
        let mut out = anstream::stdout();
        if row.lambda.is_some() {
            let (r, t) = (values[0], values[1]);
            if args.json {
                writeln!(out, "{}", serde_json::json!({ "R": r, "T": t }))?;
            } else {
                writeln!(out, "R {r}\nT {t}")?;
            }
            return Ok(Exit::Done);
        }
        let srgb = Srgb8::from(LinearRgb([values[0] as f32, values[1] as f32, values[2] as f32]));
        if args.json {
            let method = self.method.to_string();
            let json =
                serde_json::json!({ "linear_srgb": values, "srgb": srgb.to_string(), "method": method });
            writeln!(out, "{json}")?;
        } else {
            writeln!(out, "linear sRGB {} {} {}", values[0], values[1], values[2])?;
            writeln!(out, "sRGB {srgb}")?;
        }
        Ok(Exit::Done)
    }

    fn table(&mut self, path: &Path) -> Result<Exit, Failure> {
        let file = path.display().to_string();
        let text = csv::read(path, &file)?;
        let csv = Csv::parse(&file, &text)?;
        let (rows, spectral) = rows(&csv)?;
        if spectral && self.args.method.is_some() {
            return Err(Failure::usage(
                format!("{file} has a column lambda_nm: there is only one method for one wavelength"),
                "leave out --method",
            ));
        }
        let results = Results::new(&csv, if spectral { &SPECTRAL } else { &COLOR });
        let expected = results.expected()?;
        let mut values = Vec::with_capacity(rows.len());
        for (row, line) in rows.iter().zip(&csv.lines) {
            values.push(self.compute(row).map_err(|problem| csv.impossible(line, problem))?);
        }
        let mut errors = Errors::default();
        for (values, expected) in values.iter().zip(expected.iter().flatten()) {
            errors.add(values, expected);
        }
        // With --json the rows on standard output are JSON too.
        let objects = self.args.json && self.args.output.is_none();
        let text = results.text(&values, expected.as_deref(), objects);
        tell(self.args.output.as_deref(), &text, &self.report(rows.len(), spectral, &errors))?;
        Ok(if errors.within(self.args.tolerance) { Exit::Done } else { Exit::Differs })
    }

    fn report(&self, rows: usize, spectral: bool, errors: &Errors) -> String {
        let method = if spectral { "airy".into() } else { self.method.to_string() };
        let compared = errors.count > 0.0;
        let color = compared && !spectral;
        if self.args.json {
            let number = |given: bool, value: f64| if given { value.into() } else { serde_json::Value::Null };
            return serde_json::json!({
                "rows": rows,
                "method": method,
                "precision": std::any::type_name::<F>(),
                "max_error": number(compared, errors.max),
                "rms_error": number(compared, errors.rms()),
                "max_delta_e_2000": number(color, errors.max_delta_e),
                "mean_delta_e_2000": number(color, errors.delta_e / errors.rows),
            })
            .to_string();
        }
        let mut text = format!("{rows} rows, {method}, {}", std::any::type_name::<F>());
        if compared {
            text += &format!(": error at most {:.3e}, RMS {:.3e}", errors.max, errors.rms());
        }
        if color {
            let mean = errors.delta_e / errors.rows;
            text += &format!("; CIEDE2000 at most {:.3e}, mean {mean:.3e}", errors.max_delta_e);
        }
        text
    }
}

/// Differences so far.
#[derive(Debug, Default)]
pub(super) struct Errors {
    pub(super) max: f64,
    squares: f64,
    pub(super) count: f64,
    rows: f64,
    delta_e: f64,
    max_delta_e: f64,
}

impl Errors {
    pub(super) fn add(&mut self, values: &[f64], expected: &[f64]) {
        for (a, b) in values.iter().zip(expected) {
            let e = (a - b).abs();
            self.max = self.max.max(e);
            self.squares += e * e;
            self.count += 1.0;
        }
        self.rows += 1.0;
        if let ([r, g, b], [x, y, z]) = (values, expected) {
            let e = cie::delta_e_2000(cie::lab([*r, *g, *b]), cie::lab([*x, *y, *z]));
            self.delta_e += e;
            self.max_delta_e = self.max_delta_e.max(e);
        }
    }

    /// Whether none is greater than the tolerance, if there is one.
    pub(super) fn within(&self, tolerance: Option<f64>) -> bool {
        self.count == 0.0 || tolerance.is_none_or(|limit| self.max <= limit)
    }

    pub(super) fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

const SPECTRAL: [&str; 2] = ["R", "T"];
const COLOR: [&str; 3] = ["lin_r", "lin_g", "lin_b"];

/// The rows of a table, and whether they are for one wavelength each.
fn rows(csv: &Csv<'_>) -> Result<(Vec<Row>, bool), TableError> {
    let columns = csv.columns(["n0", "n1", "n2", "d_nm", "cos_theta"])?;
    let lambda = csv.find("lambda_nm");
    let row = |line: &Line<'_>| -> Result<Row, TableError> {
        let [n0, n1, n2, d, cosine] = csv.numbers(line, columns)?;
        let lambda = lambda.map(|c| csv.number(line, c)).transpose()?;
        let row = Row { n: [n0, n1, n2], d, cosine, lambda };
        row.problem().map_or(Ok(row), |problem| Err(csv.impossible(line, problem)))
    };
    Ok((csv.lines.iter().map(row).collect::<Result<_, _>>()?, lambda.is_some()))
}

/// Rows to their file or to standard output, then what is to be told of them: where nobody else writes.
pub(super) fn tell(output: Option<&Path>, rows: &str, report: &str) -> Result<(), Failure> {
    match output {
        Some(path) => {
            write(path, rows)?;
            writeln!(anstream::stdout(), "{report}")?;
        }
        None => {
            anstream::stdout().write_all(rows.as_bytes())?;
            // Who reads no messages loses none of the rows.
            let _ = writeln!(anstream::stderr(), "{report}");
        }
    }
    Ok(())
}

/// Write aside, then rename.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(crate::io::write_text(path, text)?)
}
