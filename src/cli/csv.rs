//! Tables of numbers with commas and a line of names, and what is wrong with them.

use std::io::Read as _;
use std::path::Path;

use super::exit::{Exit, Failure};

/// Greatest table, bytes.
const MAX_TEXT: u64 = 1 << 28;

/// What is wrong with a table.
#[derive(Debug, thiserror::Error)]
pub(super) enum TableError {
    /// No header line.
    #[error("{file}: there is no line of column names")]
    Empty { file: String },
    /// A column twice.
    #[error("{file}:{line}: column `{column}` is there twice")]
    Twice { file: String, line: usize, column: String },
    /// A column that is needed.
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

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    name: &'static str,
    place: usize,
}

/// A row: the number of its line, and its words.
#[derive(Debug)]
pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) words: Vec<&'a str>,
}

/// A table as text: every row has as many words as there are names. Empty lines and comments (`#`) are left out.
#[derive(Debug)]
pub(super) struct Csv<'a> {
    file: &'a str,
    head: usize,
    pub(super) names: Vec<&'a str>,
    pub(super) lines: Vec<Line<'a>>,
}

impl<'a> Csv<'a> {
    /// Split a table into words; `file` is its name in messages.
    pub(super) fn parse(file: &'a str, text: &'a str) -> Result<Self, TableError> {
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let split = |line: &'a str| line.split(',').map(str::trim).collect::<Vec<_>>();
        let (head, names) = lines.next().ok_or_else(|| TableError::Empty { file: file.into() })?;
        let names = split(names);
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                let column = super::load::short(name);
                return Err(TableError::Twice { file: file.into(), line: head, column });
            }
        }
        let lines = lines
            .map(|(number, line)| {
                let words = split(line);
                if words.len() == names.len() {
                    return Ok(Line { number, words });
                }
                let (found, expected) = (words.len(), names.len());
                Err(TableError::Length { file: file.into(), line: number, found, expected })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { file, head, names, lines })
    }

    /// A column, if it is there.
    pub(super) fn find(&self, name: &'static str) -> Option<Column> {
        self.names.iter().position(|n| *n == name).map(|place| Column { name, place })
    }

    /// A column that must be there.
    pub(super) fn column(&self, name: &'static str) -> Result<Column, TableError> {
        let missing = || TableError::Missing { file: self.file.into(), line: self.head, column: name };
        self.find(name).ok_or_else(missing)
    }

    /// Columns that must all be there.
    pub(super) fn columns<const N: usize>(
        &self,
        names: [&'static str; N],
    ) -> Result<[Column; N], TableError> {
        let mut columns = [Column { name: "", place: 0 }; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?;
        }
        Ok(columns)
    }

    /// The number of a row in a column.
    pub(super) fn number(&self, line: &Line<'_>, column: Column) -> Result<f64, TableError> {
        let word = line.words[column.place];
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(TableError::Number {
                file: self.file.into(),
                line: line.number,
                column: column.name,
                word: super::load::short(word),
            }),
        }
    }

    /// Numbers of a row.
    pub(super) fn numbers<const N: usize>(
        &self,
        line: &Line<'_>,
        columns: [Column; N],
    ) -> Result<[f64; N], TableError> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(line, column)?;
        }
        Ok(numbers)
    }

    /// A row whose numbers cannot be.
    pub(super) fn impossible(&self, line: &Line<'_>, problem: impl ToString) -> TableError {
        TableError::Range { file: self.file.into(), line: line.number, problem: problem.to_string() }
    }
}

/// A table with columns of results, which may be there already to compare with.
#[derive(Debug)]
pub(super) struct Results<'a> {
    csv: &'a Csv<'a>,
    names: &'static [&'static str],
    expected: Option<Vec<Column>>,
    /// Places of the columns that are not results.
    kept: Vec<usize>,
}

impl<'a> Results<'a> {
    /// Results of these names.
    pub(super) fn new(csv: &'a Csv<'a>, names: &'static [&'static str]) -> Self {
        let expected = names.iter().map(|name| csv.find(name)).collect();
        let kept = (0..csv.names.len()).filter(|i| !names.contains(&csv.names[*i])).collect();
        Self { csv, names, expected, kept }
    }

    /// What is expected of each row; none where no columns are.
    pub(super) fn expected(&self) -> Result<Option<Vec<Vec<f64>>>, TableError> {
        let row =
            |line: &Line<'_>, columns: &[Column]| columns.iter().map(|c| self.csv.number(line, *c)).collect();
        let all = |columns: &Vec<Column>| self.csv.lines.iter().map(|line| row(line, columns)).collect();
        self.expected.as_ref().map(all).transpose()
    }

    /// Names of all columns of the rows below.
    fn names(&self) -> Vec<String> {
        let own = self.names.iter().map(|&n| n.to_owned());
        let errors = self.names.iter().filter(|_| self.expected.is_some()).map(|n| format!("{n}_error"));
        self.kept.iter().map(|i| self.csv.names[*i].to_owned()).chain(own).chain(errors).collect()
    }

    /// The rows: what was read, the results, and their differences from what was expected; with commas under a line of
    /// names, or a JSON object each, in which words that are numbers are numbers.
    pub(super) fn text(&self, values: &[Vec<f64>], expected: Option<&[Vec<f64>]>, json: bool) -> String {
        let names = self.names();
        let word = |word: &str| match word.parse::<f64>() {
            Ok(number) if number.is_finite() => number.into(),
            _ => serde_json::Value::from(word),
        };
        let row = |i: usize| -> String {
            let words = self.kept.iter().map(|k| self.csv.lines[i].words[*k]);
            let expected = expected.map_or(&[][..], |e| &e[i]);
            let errors = values[i].iter().zip(expected).map(|(value, expected)| value - expected);
            if json {
                let numbers = values[i].iter().copied().chain(errors).map(serde_json::Value::from);
                let cells = names.iter().cloned().zip(words.map(word).chain(numbers));
                return cells.collect::<serde_json::Value>().to_string();
            }
            let own = values[i].iter().map(f64::to_string);
            words
                .map(str::to_owned)
                .chain(own)
                .chain(errors.map(|e| format!("{e:e}")))
                .collect::<Vec<_>>()
                .join(",")
        };
        let head = (!json).then(|| names.join(","));
        head.into_iter().chain((0..values.len()).map(row)).map(|line| line + "\n").collect()
    }
}

/// The text of a table.
pub(super) fn read(path: &Path, file: &str) -> Result<String, Failure> {
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
