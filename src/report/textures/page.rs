//! The measured rows as a table, a plot and a page.

use std::collections::BTreeMap;

use super::{Row, Subject, Timed, plain};
use crate::base::MapKind;
use crate::report::plot::{Axis, Mark, Plot, Series};
use crate::report::table::{Cell, Table};
use crate::report::{Page, Report};

/// The groups, in the order of the page and of the colours of the plot.
const GROUPS: [&str; 4] = ["nodes", "arithmetic", "size", "encoding"];

pub(super) fn page(subject: &Subject<'_>, ours: &Timed, rows: &[Row], failures: Vec<String>) -> Report {
    let (name, domain) = (&subject.graph.name, subject.domain);
    let mut page = Page::new(format!("The textures of `{name}`: what every approximation costs"));
    page.prose(format!(
        "A texture set is made with shortcuts: fewer directions than there are, 32 bits, polynomials, 8-bit files. Each of them \
         is measured here on the maps that come out, at {} x {} texels: the maps made with the shortcut against the same \
         maps made without it. All numbers are of this run. Times are of one thread, the fastest of {}; they differ from run \
         to run and from machine to machine. The errors do not. All maps as they are made take {:.1} ms.",
        domain.width, domain.height, subject.rounds, ours.ms
    ));
    page.prose(
        "\"max\" is the greatest difference of a channel, \"RMS\" the root of the mean square, both in the map's unit: mm of height, \
         nm of film, 1/mm of curvature, linear light of colour, shares of 1 of the rest. Of scale ids only equality counts. \
         Colours are also compared by CIEDE2000 (1 is about what an eye can tell), normals by their angle. Maps that are not \
         listed are the same bit for bit. \"saved\" is the time without the shortcut less the time with it: negative where a \
         shortcut saves nothing here.",
    );
    let table = table(rows, name);
    let summary = table.text();
    page.figure(
        "saved",
        plot(rows).svg(),
        "Each dot is a shortcut on a map: RMS error as a share of the map's range against the milliseconds saved, both logarithmic; \
         what saves nothing or errs by nothing has no place here. Right and low is good.",
    );
    page.table(table);
    page.heading("What the groups are");
    page.prose(
        "Nodes: the same graph with nodes that do more. A box blur against a Gaussian of the same variance, occlusion against four \
         times the directions and steps, the blur before curvature against one with its tail, a reaction against one in small \
         steps. The time is that of these nodes alone. A reaction that is stepped otherwise may settle into another pattern of \
         the same kind: then its error is that of two different snakes.",
    );
    page.prose(
        "Arithmetic: the plan is reckoned once more by the plain formulas of the table below, in f64 with the functions of libm, in \
         f32 with libm, and in f32 with our polynomials. The first comparison holds everything that our kernels do against \
         f64; the other two change one thing in the same plain code, so that error and time are of that one thing. Plain code \
         works on one number at a time: that polynomials let a compiler work on many, which is why they are there, does not \
         show in it, but in the first comparison. A node \
         without a formula is evaluated by itself in f32 from rounded inputs each time: its own rounding is not in these rows.",
    );
    page.prose(
        "Size: a draft with fewer texels, drawn larger as a viewer does it (linear between texel centres), and one sample a texel \
         against the mean of four samples. Encoding: PNG files in 8 bits, plain and dithered, against 16 bits, written to \
         nowhere; also as means of 8 x 8 texels, which is what dither is for.",
    );
    page.table(nodes(ours));
    Report { page, name: "textures", summary: told(summary, &failures), failures }
}

fn told(summary: String, failures: &[String]) -> String {
    if failures.is_empty() {
        return summary;
    }
    summary + "\nDOUBTFUL:\n" + &failures.iter().map(|f| format!("  {f}\n")).collect::<String>()
}

fn table(rows: &[Row], name: &str) -> Table {
    let mut table = Table::new(
        "approximations",
        format!("Approximations in {name}"),
        &[
            "shortcut",
            "in place of",
            "map",
            "unit",
            "max",
            "RMS",
            "seen",
            "mean",
            "99 %",
            "worst",
            "ms",
            "exact ms",
            "saved ms",
        ],
    );
    for row in rows {
        let ms = |ms: Option<f64>| ms.map_or(Cell::None, |ms| Cell::Fixed(ms, 2));
        let number = |v: f64| Cell::Scientific(v, 1);
        let (map, unit) = row.map.map_or(("none differs", ""), |(kind, _)| (kind.name(), kind.unit()));
        let seen = row.difference.seen;
        table.row([
            Cell::text(&row.shortcut),
            Cell::text(&row.truth),
            Cell::text(map),
            Cell::text(unit),
            number(row.difference.max),
            number(row.difference.rms),
            seen.map_or(Cell::None, |s| Cell::text(s.unit)),
            seen.map_or(Cell::None, |s| number(s.mean)),
            seen.map_or(Cell::None, |s| number(s.most)),
            seen.map_or(Cell::None, |s| number(s.worst)),
            ms(row.ms),
            ms(row.exact_ms),
            ms(row.saved()),
        ]);
    }
    table
}

/// Operations of the plan, and whether they have a formula in f64.
fn nodes(ours: &Timed) -> Table {
    let mut table = Table::new(
        "formulas",
        "Nodes at work, and what they are held against",
        &["node", "number", "formula in f64"],
    );
    let mut found: BTreeMap<&str, (u64, bool)> = BTreeMap::new();
    for step in &ours.plan.steps {
        let entry = found.entry(step.node.spec().name).or_insert((0, true));
        *entry = (entry.0 + 1, entry.1 && plain::has_formula(step));
    }
    for (name, (count, formula)) in found {
        table.row([Cell::text(name), Cell::Count(count), Cell::text(if formula { "yes" } else { "none" })]);
    }
    table
}

/// RMS error as a share of the map's range.
pub(super) fn share(row: &Row) -> Option<f64> {
    let (kind, [low, high]) = row.map?;
    let range = if kind == MapKind::ScaleId { 1.0 } else { f64::from(high) - f64::from(low) };
    Some(row.difference.rms / range)
}

fn plot(rows: &[Row]) -> Plot {
    let mut plot = Plot::new(
        "Error against time saved",
        Axis::log("saved, ms"),
        Axis::log("RMS error, share of the map's range"),
    );
    for (color, group) in GROUPS.iter().enumerate() {
        let placed = rows.iter().filter(|row| row.group == *group).filter_map(|row| {
            let (saved, error) = (row.saved()?, share(row)?);
            (saved > 0.0 && error > 0.0)
                .then(|| ((saved, error), row.map.map_or("", |(kind, _)| kind.name())))
        });
        let (points, maps): (Vec<_>, Vec<_>) = placed.unzip();
        // Names of all dots would hide each other.
        let names = if *group == "nodes" { maps.into_iter().map(String::from).collect() } else { Vec::new() };
        plot.series.push(Series { name: (*group).into(), points, names, mark: Mark::Dots, color });
    }
    plot
}
