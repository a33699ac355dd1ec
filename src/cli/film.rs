//! `film`: reflectance, transmittance and colour of one film, or of the rows of a table.

use std::io::{Read as _, Write as _};
use std::path::Path;

use super::args::{Film as Args, Precision};
use super::exit::{Exit, Failure};
use crate::base::{LinearRgb, Srgb8};
use crate::optics::{Film, FilmColor, Method, Real, cie};

/// Greatest table, bytes.
const MAX_TEXT: u64 = 1 << 28;

/// Compute one film, or a table.
pub(super) fn run(args: &Args) -> Result<Exit, Failure> {
    if args.precision == Precision::F32 {
        Films::<f32>::new(args).run()
    } else {
        Films::<f64>::new(args).run()
    }
}

/// What is wrong with a table.
#[derive(Debug, thiserror::Error)]
enum TableError {
    /// No header line.
    #[error("{file}: there is no line of column names")]
    Empty { file: String },
    /// A column twice.
    #[error("{file}:{line}: column `{column}` is there twice")]
    Twice { file: String, line: usize, column: String },
    /// Not the columns of either kind of table.
    #[error("{file}:{line}: there is no column `{column}`")]
    Missing { file: String, line: usize, column: &'static str },
    /// A row of another length.
    #[error("{file}:{line}: {found} values, where there are {expected} columns")]
    Length { file: String, line: usize, found: usize, expected: usize },
    /// Not a number.
    #[error("{file}:{line}: column `{column}`: `{word}` is not a finite number")]
    Number { file: String, line: usize, column: &'static str, word: String },
    /// A number that cannot be.
    #[error("{file}:{line}: {problem}")]
    Range { file: String, line: usize, problem: String },
}

impl From<TableError> for Failure {
    fn from(error: TableError) -> Self {
        Self::usage(
            error,
            "columns: n0, n1, n2, d_nm, cos_theta, and lambda_nm for R and T of one wavelength; without lambda_nm the colour \
             is computed. Columns R, T or lin_r, lin_g, lin_b, if there, are compared with",
        )
    }
}

/// A row to compute.
struct Row {
    n: [f64; 3],
    d: f64,
    cosine: f64,
    lambda: Option<f64>,
    /// R, T or red, green, blue.
    expected: Option<Vec<f64>>,
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
    colors: FilmColor<F>,
}

impl<'a, F: Real> Films<'a, F> {
    fn new(args: &'a Args) -> Self {
        let method = args.method.unwrap_or(Method::REFERENCE);
        Self { args, method, colors: FilmColor::new(method) }
    }

    fn run(&self) -> Result<Exit, Failure> {
        match &self.args.csv {
            Some(path) => self.table(path),
            None => self.one(),
        }
    }

    /// R and T, or red, green and blue, of a row whose numbers have been checked.
    fn compute(&self, row: &Row) -> Result<Vec<f64>, String> {
        let [n0, n1, n2] = row.n.map(F::from_f64);
        let film = Film::new(n0, n1, n2, F::from_f64(row.d)).map_err(|e| e.to_string())?;
        let cosine = F::from_f64(row.cosine);
        Ok(match row.lambda {
            Some(lambda) => {
                let power = film.power(cosine, F::from_f64(lambda));
                vec![power.reflected.to_f64(), power.transmitted.to_f64()]
            }
            None => self.colors.color(&film, cosine).map(F::to_f64).to_vec(),
        })
    }

    fn one(&self) -> Result<Exit, Failure> {
        let args = self.args;
        if !(0.0..=90.0).contains(&args.angle_deg) {
            return Err(Failure::usage(
                format!("--angle-deg {} is out of range", args.angle_deg),
                "0 is along the normal, 90 is grazing",
            ));
        }
        // The cosine of 90 degrees is 0, whatever pi is rounded to.
        let cosine = if args.angle_deg == 90.0 { 0.0 } else { libm::cos(args.angle_deg.to_radians()) };
        let row = Row {
            n: [args.n0, args.n1, args.n2],
            // Clap asks for it where there is no table.
            d: args.thickness_nm.unwrap_or(0.0),
            cosine,
            lambda: args.lambda_nm,
            expected: None,
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

    fn table(&self, path: &Path) -> Result<Exit, Failure> {
        let file = path.display().to_string();
        let text = read(path, &file)?;
        let table = Table::parse(&file, &text)?;
        if table.spectral && self.args.method.is_some() {
            return Err(Failure::usage(
                format!("{file} has a column lambda_nm: there is only one method for one wavelength"),
                "leave out --method",
            ));
        }
        let mut lines = vec![table.head()];
        let mut errors = Errors::default();
        for (line, words, row) in &table.rows {
            let values = self.compute(row).map_err(|problem| TableError::Range {
                file: file.clone(),
                line: *line,
                problem,
            })?;
            lines.push(table.line(words, &values, row));
            if let Some(expected) = &row.expected {
                errors.add(&values, expected);
            }
        }
        let mut text = lines.join("\n");
        text.push('\n');
        match &self.args.output {
            Some(path) => write(path, &text)?,
            None => anstream::stdout().write_all(text.as_bytes())?,
        }
        // The rows have standard output, unless they have a file.
        let report = self.report(&table, &errors);
        if self.args.output.is_some() {
            writeln!(anstream::stdout(), "{report}")?;
        } else {
            // Who reads no messages loses none of the rows.
            let _ = writeln!(anstream::stderr(), "{report}");
        }
        let within = |limit: f64| errors.count == 0.0 || errors.max <= limit;
        Ok(if self.args.tolerance.is_none_or(within) { Exit::Done } else { Exit::Differs })
    }

    fn report(&self, table: &Table, errors: &Errors) -> String {
        let (rows, method) =
            (table.rows.len(), if table.spectral { "airy".into() } else { self.method.to_string() });
        let compared = errors.count > 0.0;
        let color = compared && !table.spectral;
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
struct Errors {
    max: f64,
    squares: f64,
    count: f64,
    rows: f64,
    delta_e: f64,
    max_delta_e: f64,
}

impl Errors {
    fn add(&mut self, values: &[f64], expected: &[f64]) {
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

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

const SPECTRAL: [&str; 2] = ["R", "T"];
const COLOR: [&str; 3] = ["lin_r", "lin_g", "lin_b"];

/// A table that has been read.
struct Table<'a> {
    /// Names of the columns that are not results.
    names: Vec<&'a str>,
    /// Whether for one wavelength each.
    spectral: bool,
    /// Whether results to compare with are there.
    expected: bool,
    /// Line number, the words of `names`, and the numbers.
    rows: Vec<(usize, Vec<&'a str>, Row)>,
}

impl<'a> Table<'a> {
    fn parse(file: &str, text: &'a str) -> Result<Self, TableError> {
        let file_name = || file.to_owned();
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let (head, names) = lines.next().ok_or_else(|| TableError::Empty { file: file_name() })?;
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                return Err(TableError::Twice { file: file_name(), line: head, column: short(name) });
            }
        }
        let place = |name: &str| names.iter().position(|n| *n == name);
        let needed = |name: &'static str| {
            place(name).map(|i| (i, name)).ok_or_else(|| TableError::Missing {
                file: file_name(),
                line: head,
                column: name,
            })
        };
        let columns = [needed("n0")?, needed("n1")?, needed("n2")?, needed("d_nm")?, needed("cos_theta")?];
        let lambda = place("lambda_nm").map(|i| (i, "lambda_nm"));
        let results: &[&'static str] = if lambda.is_some() { &SPECTRAL } else { &COLOR };
        let expected: Option<Vec<_>> = results.iter().map(|name| Some((place(name)?, *name))).collect();
        let kept: Vec<usize> = (0..names.len()).filter(|i| !results.contains(&names[*i])).collect();
        let mut rows = Vec::new();
        for (line, words) in lines {
            let words: Vec<&str> = words.split(',').map(str::trim).collect();
            if words.len() != names.len() {
                let (found, expected) = (words.len(), names.len());
                return Err(TableError::Length { file: file_name(), line, found, expected });
            }
            let number = |(i, column): (usize, &'static str)| match words[i].parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(TableError::Number { file: file_name(), line, column, word: short(words[i]) }),
            };
            let row = Row {
                n: [number(columns[0])?, number(columns[1])?, number(columns[2])?],
                d: number(columns[3])?,
                cosine: number(columns[4])?,
                lambda: lambda.map(number).transpose()?,
                expected: expected
                    .iter()
                    .flatten()
                    .map(|c| number(*c))
                    .collect::<Result<Vec<_>, _>>()
                    .map(|values| if expected.is_some() { Some(values) } else { None })?,
            };
            if let Some(problem) = row.problem() {
                return Err(TableError::Range { file: file_name(), line, problem });
            }
            rows.push((line, kept.iter().map(|i| words[*i]).collect(), row));
        }
        let names = kept.iter().map(|i| names[*i]).collect();
        Ok(Self { names, spectral: lambda.is_some(), expected: expected.is_some(), rows })
    }

    fn results(&self) -> &'static [&'static str] {
        if self.spectral { &SPECTRAL } else { &COLOR }
    }

    /// The column names of the results.
    fn head(&self) -> String {
        let mut names: Vec<String> = self.names.iter().map(|&n| n.to_owned()).collect();
        names.extend(self.results().iter().map(|&n| n.to_owned()));
        if self.expected {
            names.extend(self.results().iter().map(|n| format!("{n}_error")));
        }
        names.join(",")
    }

    /// A row of the results.
    fn line(&self, words: &[&str], values: &[f64], row: &Row) -> String {
        let mut all: Vec<String> = words.iter().map(|&w| w.to_owned()).collect();
        all.extend(values.iter().map(f64::to_string));
        for (value, expected) in values.iter().zip(row.expected.iter().flatten()) {
            all.push(format!("{:e}", value - expected));
        }
        all.join(",")
    }
}

/// The start of a word, for a message.
fn short(word: &str) -> String {
    super::load::short(word)
}

fn read(path: &Path, file: &str) -> Result<String, Failure> {
    let fail = |message: String| Failure::Message { exit: Exit::File, message, help: None };
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|f| f.take(MAX_TEXT + 1).read_to_end(&mut bytes))
        .map_err(|e| fail(format!("{file} cannot be read: {}", super::load::plain(&e))))?;
    if bytes.len() as u64 > MAX_TEXT {
        return Err(Failure::usage(format!("{file} has more than {MAX_TEXT} bytes"), "split it"));
    }
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        Failure::usage(format!("{file}:{line}: the text is not UTF-8"), "a table is plain text with commas")
    })
}

/// Write aside, then rename.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(crate::io::write_text(path, text)?)
}
