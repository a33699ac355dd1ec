//! One HTML file that needs no other: prose, tables, plots.

use std::fmt::Write as _;

use super::table::{Cell, Table};

/// A part of a page.
#[derive(Clone, Debug)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Prose(String),
    /// A table.
    Table(Table),
    /// A picture as SVG, its name for files, and what it shows.
    Figure {
        /// Name for files.
        id: &'static str,
        /// The SVG.
        svg: String,
        /// What it shows.
        caption: String,
    },
}

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Its heading.
    pub title: String,
    /// Its parts, in order.
    pub blocks: Vec<Block>,
}

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1d2126; --soft: #5d6670; --line: #d7dce1; --paper: #fff; --good: #17703a; --bad: #b3261e; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e8ea; --soft: #9aa4ae; --line: #394048; --paper: #14171a; --good: #6ecf8f; --bad: #ff8a80; }
}
body { font: 16px/1.55 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 64rem; margin: 2rem auto; padding: 0 1rem; }
p { max-width: 46rem; }
h1 { font-size: 1.8rem; } h2 { margin-top: 2.5rem; border-bottom: 1px solid var(--line); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .85rem; margin: 1rem 0; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { padding: .2rem .6rem; border-bottom: 1px solid var(--line); text-align: left; white-space: nowrap; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; white-space: normal; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
.pass { color: var(--good); } .FAIL { color: var(--bad); font-weight: 700; }
figure { margin: 1.5rem 0; } figure svg { max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .9rem; max-width: 46rem; }
";

impl Page {
    /// An empty page.
    pub fn new(title: impl ToString) -> Self {
        Self { title: title.to_string(), blocks: Vec::new() }
    }

    /// Add a heading.
    pub fn heading(&mut self, text: impl ToString) {
        self.blocks.push(Block::Heading(text.to_string()));
    }

    /// Add a paragraph.
    pub fn prose(&mut self, text: impl ToString) {
        self.blocks.push(Block::Prose(text.to_string()));
    }

    /// Add a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// Add a picture.
    pub fn figure(&mut self, id: &'static str, svg: String, caption: impl ToString) {
        self.blocks.push(Block::Figure { id, svg, caption: caption.to_string() });
    }

    /// Its tables.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
    }

    /// Its pictures: name and SVG.
    pub fn figures(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Figure { id, svg, .. } => Some((*id, svg.as_str())),
            _ => None,
        })
    }

    /// The file.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let mut html = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
        );
        for block in &self.blocks {
            // Strings take text without fail.
            let _ = match block {
                Block::Heading(text) => writeln!(html, "<h2>{}</h2>", escape(text)),
                Block::Prose(text) => writeln!(html, "<p>{}</p>", escape(text)),
                Block::Table(table) => {
                    html.push_str(&of_table(table));
                    Ok(())
                }
                Block::Figure { svg, caption, .. } => {
                    writeln!(html, "<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>", escape(caption))
                }
            };
        }
        html.push_str("</body>\n</html>\n");
        html
    }
}

fn of_table(table: &Table) -> String {
    let cell = |tag: &str, class: &str, text: &str| match class {
        "" => format!("<{tag}>{}</{tag}>", escape(text)),
        _ => format!("<{tag} class=\"{class}\">{}</{tag}>", escape(text)),
    };
    let numbers = |i: usize| table.rows.iter().any(|row| row.get(i).is_some_and(Cell::is_number));
    let class = |i: usize, c: &Cell| match c {
        Cell::Pass(true) => "pass",
        Cell::Pass(false) => "FAIL",
        _ if numbers(i) => "n",
        _ => "",
    };
    let head: String = (table.columns.iter().enumerate())
        .map(|(i, name)| cell("th", if numbers(i) { "n" } else { "" }, name))
        .collect();
    let row = |row: &Vec<Cell>| -> String {
        let cells: String =
            row.iter().enumerate().map(|(i, c)| cell("td", class(i, c), &c.shown())).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = table.rows.iter().map(row).collect();
    format!(
        "<div class=\"scroll\"><table>\n<caption>{}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        escape(&table.title)
    )
}

/// Text that is no markup.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_whole_and_needs_nothing_from_outside() {
        let mut page = Page::new("a < b");
        page.heading("One");
        page.prose("x & y");
        let mut table = Table::new("t", "T", &["name", "value"]);
        table.row([Cell::text("<script>"), Cell::Fixed(1.0, 2)]);
        page.table(table);
        page.figure("f", "<svg></svg>\n".into(), "a figure");
        let html = page.html();
        for part in
            ["<title>a &lt; b</title>", "x &amp; y", "&lt;script&gt;", "<td class=\"n\">1.00</td>", "<svg>"]
        {
            assert!(html.contains(part), "{part}");
        }
        for outside in ["src=", "href=", "@import", "url(", "<script"] {
            assert!(!html.contains(outside), "{outside}");
        }
        assert_eq!((page.tables().count(), page.figures().count()), (1, 1));
    }
}
