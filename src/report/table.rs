//! One table, as text, CSV, JSON and HTML.

use std::fmt::Write as _;

use serde_json::Value;

/// A value in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A count.
    Count(u64),
    /// A number with so many digits after the point.
    Fixed(f64, usize),
    /// A number of any size, with so many digits after the point of its mantissa.
    Scientific(f64, usize),
    /// Whether a case passed.
    Pass(bool),
    /// There is none.
    None,
}

impl Cell {
    /// Words.
    pub fn text(text: impl ToString) -> Self {
        Self::Text(text.to_string())
    }

    /// As people read it.
    pub fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Fixed(value, digits) => format!("{value:.digits$}"),
            Self::Scientific(value, _) if *value == 0.0 => "0".into(),
            Self::Scientific(value, digits) => format!("{value:.digits$e}"),
            Self::Pass(true) => "pass".into(),
            Self::Pass(false) => "FAIL".into(),
            Self::None => "-".into(),
        }
    }

    /// Whether it is lined up at the right.
    pub fn is_number(&self) -> bool {
        matches!(self, Self::Count(_) | Self::Fixed(..) | Self::Scientific(..))
    }

    /// With all digits.
    fn csv(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Fixed(value, _) | Self::Scientific(value, _) => value.to_string(),
            Self::None => String::new(),
            other => other.shown(),
        }
    }

    /// With all digits; what JSON has no number for is null.
    fn json(&self) -> Value {
        match self {
            Self::Text(text) => text.clone().into(),
            Self::Count(count) => (*count).into(),
            Self::Fixed(value, _) | Self::Scientific(value, _) => (*value).into(),
            Self::Pass(pass) => (*pass).into(),
            Self::None => Value::Null,
        }
    }
}

/// Rows of values under names.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name for files and keys.
    pub id: &'static str,
    /// What it shows.
    pub title: String,
    /// Names of the columns, with their units.
    pub columns: Vec<&'static str>,
    /// As many values as there are columns, each.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table.
    pub fn new(id: &'static str, title: impl ToString, columns: &[&'static str]) -> Self {
        Self { id, title: title.to_string(), columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Add a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Lined up for a terminal.
    pub fn text(&self) -> String {
        let shown: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(Cell::shown).collect()).collect();
        let width = |i: usize| {
            let cells = shown.iter().filter_map(|row| row.get(i)).map(|s| s.chars().count());
            cells.chain([self.columns[i].chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let numbers: Vec<bool> = (0..self.columns.len())
            .map(|i| self.rows.iter().any(|row| row.get(i).is_some_and(Cell::is_number)))
            .collect();
        let mut text = format!("{}\n", self.title);
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut line = String::new();
            for (i, cell) in cells.enumerate().take(widths.len()) {
                let width = widths[i];
                // Strings take text without fail.
                let _ = if numbers[i] {
                    write!(line, "  {cell:>width$}")
                } else {
                    write!(line, "  {cell:<width$}")
                };
            }
            text.push_str(line.trim_end());
            text.push('\n');
        };
        line(&mut self.columns.iter().copied());
        for row in &shown {
            line(&mut row.iter().map(String::as_str));
        }
        text
    }

    /// With commas, all digits.
    pub fn csv(&self) -> String {
        let head = self.columns.iter().map(|c| Cell::text(c).csv()).collect::<Vec<_>>().join(",");
        let rows = self.rows.iter().map(|row| row.iter().map(Cell::csv).collect::<Vec<_>>().join(","));
        [head].into_iter().chain(rows).map(|line| line + "\n").collect()
    }

    /// An object for each row.
    pub fn json(&self) -> Value {
        let row = |row: &Vec<Cell>| -> Value {
            self.columns.iter().zip(row).map(|(name, cell)| ((*name).to_owned(), cell.json())).collect()
        };
        self.rows.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new("t", "Times", &["method", "ns", "RMSE", "ok"]);
        table.row([
            Cell::text("a, \"b\""),
            Cell::Fixed(12.345, 1),
            Cell::Scientific(0.00123, 1),
            Cell::Pass(true),
        ]);
        table.row([Cell::text("c"), Cell::Count(7), Cell::None, Cell::Pass(false)]);
        table
    }

    #[test]
    fn text_is_lined_up() {
        let lines = [
            "Times",
            "  method    ns    RMSE  ok",
            "  a, \"b\"  12.3  1.2e-3  pass",
            "  c          7       -  FAIL",
        ];
        assert_eq!(table().text(), lines.join("\n") + "\n");
    }

    #[test]
    fn csv_and_json_have_all_digits() {
        assert_eq!(table().csv(), "method,ns,RMSE,ok\n\"a, \"\"b\"\"\",12.345,0.00123,pass\nc,7,,FAIL\n");
        let json = table().json();
        assert!(json[0]["ns"] == 12.345 && json[1]["RMSE"].is_null() && json[1]["ok"] == false, "{json}");
    }
}
