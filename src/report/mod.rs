//! WHAT EVERY SHORTCUT COSTS: errors against run times, as tables, plots and one page. Imports optics, the rooms
//! from node to io, scene, preview and reference.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`metric`] | how far colours and pictures are apart: RMSE, CIEDE2000, FLIP |
//! | [`timing`] | nanoseconds of one evaluation |
//! | [`Table`], [`Plot`], [`Page`] | numbers as text, CSV and JSON; a plot as SVG; one HTML file of both |
//! | [`swatch`] | a film by thickness and angle, as a picture |
//! | [`Report`] | a page and the files beside it |
//! | [`convergence`] | the report on the path tracer: error against samples and seconds |
//! | [`optics`] | the report on the skin's optics: films, methods, stability |
//! | `textures` | the report on a preset's maps: every approximation in its graph (feature `files`) |
//! | `preview` | the report on the preview: pictures and times against the path tracer's (features `preview`, `files`) |
//!
//! A report writes no file: the command does.

pub mod brdf;
pub mod convergence;
pub mod film;
mod flip;
pub mod html;
pub mod metric;
pub mod optics;
#[cfg(all(feature = "preview", feature = "files"))]
pub mod picture;
pub mod pictures;
pub mod plot;
#[cfg(all(feature = "preview", feature = "files"))]
pub mod preview;
pub mod skin_sweep;
pub mod stability;
pub mod swatch;
pub mod table;
#[cfg(feature = "files")]
pub mod textures;
pub mod timing;

pub use html::Page;
pub use plot::Plot;
pub use table::{Cell, Table};

/// A page and the files beside it.
#[derive(Clone, Debug)]
pub struct Report {
    /// The page, as `NAME.html`.
    pub page: Page,
    /// Name for files.
    pub name: &'static str,
    /// What a terminal shows.
    pub summary: String,
    /// Cases that failed.
    pub failures: Vec<String>,
}

impl Report {
    /// Every file: its name and its text. The page, a CSV for each table, an SVG for each plot, all numbers as JSON.
    pub fn files(&self) -> Vec<(String, String)> {
        let mut files = vec![(format!("{}.html", self.name), self.page.html())];
        for table in self.page.tables() {
            files.push((format!("{}_{}.csv", self.name, table.id), table.csv()));
        }
        for (id, svg) in self.page.figures() {
            files.push((format!("{}_{id}.svg", self.name), svg.to_owned()));
        }
        files.push((format!("{}.json", self.name), format!("{:#}\n", self.json())));
        files
    }

    /// All tables by id, and what failed.
    pub fn json(&self) -> serde_json::Value {
        let tables: serde_json::Map<_, _> =
            self.page.tables().map(|table| (table.id.to_owned(), table.json())).collect();
        serde_json::json!({ "report": self.name, "failures": self.failures, "tables": tables })
    }
}

/// Told how much is done, in [0, 1], and what is at work.
pub type Watch<'a> = &'a mut (dyn FnMut(f32, &str) + Send);
