//! Plots as SVG: lines and points on linear or logarithmic axes. They follow the reader's light or dark theme.

use std::fmt::Write as _;

use super::html::escape;

/// Size of a plot, in units of the SVG.
const SIZE: (f64, f64) = (760.0, 440.0);
/// Room at the left, top, right and bottom for axes, title and legend.
const MARGIN: (f64, f64, f64, f64) = (72.0, 44.0, 24.0, 56.0);
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 16.0;

/// One direction of a plot.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it shows, with the unit.
    pub label: String,
    /// Whether powers of ten are evenly spaced.
    pub log: bool,
}

impl Axis {
    /// Evenly spaced numbers.
    pub fn linear(label: impl ToString) -> Self {
        Self { label: label.to_string(), log: false }
    }

    /// Evenly spaced powers of ten; numbers that are not positive are left out.
    pub fn log(label: impl ToString) -> Self {
        Self { label: label.to_string(), log: true }
    }
}

/// What a series is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line through all points.
    Line,
    /// A dashed line.
    Dashes,
    /// A dot at each point, with its name if there is one.
    Dots,
}

/// Points under one name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Places, in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Names of the points; may be fewer.
    pub names: Vec<String>,
    /// How it is drawn.
    pub mark: Mark,
    /// Index of its colour, 0 to 7: blue, orange, green, red, violet, brown, pink, gray.
    pub color: usize,
}

impl Series {
    /// A line.
    pub fn line(name: impl ToString, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_string(), points, names: Vec::new(), mark: Mark::Line, color }
    }
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// What is drawn, later ones above.
    pub series: Vec<Series>,
}

/// Where numbers of an axis are.
struct Scale {
    log: bool,
    low: f64,
    high: f64,
    /// Between ticks, unless `log`.
    step: f64,
    from: f64,
    to: f64,
}

impl Scale {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let usable = |v: &f64| v.is_finite() && (!axis.log || *v > 0.0);
        let of = |v: f64| if axis.log { libm::log10(v) } else { v };
        let (low, high) = values
            .filter(usable)
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let (low, high) = if high - low < 1e-12 { (low - 0.5, high + 0.5) } else { (low, high) };
        let (room, step) = ((high - low) * 0.04, step(high - low));
        let (low, high) = if axis.log {
            (low - room, high + room)
        } else {
            ((low / step).floor() * step, (high / step).ceil() * step)
        };
        Self { log: axis.log, low, high, step, from, to }
    }

    fn at(&self, value: f64) -> Option<f64> {
        let v = if self.log { libm::log10(value) } else { value };
        let at = self.from + (v - self.low) / (self.high - self.low) * (self.to - self.from);
        at.is_finite().then_some(at)
    }

    /// Labelled numbers.
    fn ticks(&self) -> Vec<(f64, String)> {
        if !self.log {
            let step = self.step;
            let digits = (-libm::log10(step)).ceil().clamp(0.0, 9.0) as usize;
            let count = ((self.high - self.low) / step).round() as i64;
            let label = |v: f64| if v == 0.0 { "0".into() } else { format!("{v:.digits$}") };
            return (0..=count)
                .map(|i| (self.low / step).round() * step + i as f64 * step)
                .map(|v| if v.abs() < step * 1e-9 { 0.0 } else { v })
                .map(|v| (v, label(v)))
                .collect();
        }
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        let label =
            |e: i32| if (0..4).contains(&e) { 10u32.pow(e as u32).to_string() } else { format!("1e{e}") };
        let tens = (first..=last).map(|e| (libm::pow(10.0, f64::from(e)), label(e)));
        if last - first >= 2 {
            return tens.collect();
        }
        // Few powers of ten: 2 and 5 of each as well.
        let mut ticks = Vec::new();
        for e in first - 1..=last {
            for m in [1u32, 2, 5] {
                let v = f64::from(m) * libm::pow(10.0, f64::from(e));
                if (self.low..=self.high).contains(&libm::log10(v)) {
                    let small = !(0..=3).contains(&e);
                    ticks.push((v, if small { format!("{m}e{e}") } else { format!("{}", v.round()) }));
                }
            }
        }
        ticks
    }
}

/// A round step for about six ticks.
fn step(range: f64) -> f64 {
    let power = libm::pow(10.0, libm::log10(range / 6.0).floor());
    [1.0, 2.0, 4.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| range / s <= 7.0).unwrap_or(range)
}

/// Colours for light and dark, by index.
pub(crate) const STYLE: &str = "
.t{font:600 15px system-ui,sans-serif;fill:#1d2126}.l{font:12px system-ui,sans-serif;fill:#5d6670}
.a{stroke:#8a949e;stroke-width:1}.g{stroke:#8a949e;stroke-width:1;opacity:.25}
.s{fill:none;stroke-width:1.8;stroke-linejoin:round}.d{stroke-dasharray:5 4}
.c0{stroke:#2a6fbb}.c1{stroke:#d9730d}.c2{stroke:#2e8b57}.c3{stroke:#c0392b}.c4{stroke:#7d4fb3}.c5{stroke:#8c5a3c}.c6{stroke:#c94f8f}.c7{stroke:#737c85}
.f0{fill:#2a6fbb}.f1{fill:#d9730d}.f2{fill:#2e8b57}.f3{fill:#c0392b}.f4{fill:#7d4fb3}.f5{fill:#8c5a3c}.f6{fill:#c94f8f}.f7{fill:#737c85}
@media (prefers-color-scheme:dark){.t{fill:#e6e8ea}.l{fill:#a9b2bb}.c0{stroke:#6aa9f0}.f0{fill:#6aa9f0}.c2{stroke:#5fc48d}.f2{fill:#5fc48d}.c3{stroke:#f07a6c}.f3{fill:#f07a6c}.c4{stroke:#b794e6}.f4{fill:#b794e6}}
";

impl Plot {
    /// An empty plot.
    pub fn new(title: impl ToString, x: Axis, y: Axis) -> Self {
        Self { title: title.to_string(), x, y, series: Vec::new() }
    }

    /// The picture: one `<svg>` element.
    pub fn svg(&self) -> String {
        let (width, height) = SIZE;
        let body = self.drawn((0.0, 0.0, width, height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" role=\"img\" \
             aria-label=\"{}\">\n<style>{STYLE}</style>\n{body}</svg>\n",
            escape(&self.title)
        )
    }

    /// Its elements within a rectangle: left, top, width, height.
    pub(crate) fn drawn(&self, (left, top, width, height): (f64, f64, f64, f64)) -> String {
        let (x0, x1) = (left + MARGIN.0, left + width - MARGIN.2);
        let legend = self.legend(x1 - left);
        let (y0, y1) =
            (top + height - MARGIN.3, top + MARGIN.1 + LEGEND_LINE * legend.len().saturating_sub(1) as f64);
        let points = || self.series.iter().flat_map(|s| s.points.iter());
        let sx = Scale::new(&self.x, points().map(|p| p.0), x0, x1);
        let sy = Scale::new(&self.y, points().map(|p| p.1), y0, y1);
        let mut svg = String::new();
        let mut put = |element: String| {
            svg.push_str(&element);
            svg.push('\n');
        };
        put(format!(
            "<text class=\"t\" x=\"{x0:.1}\" y=\"{:.1}\">{}</text>",
            top + 20.0,
            escape(&self.title)
        ));
        for (value, label) in sx.ticks() {
            let Some(x) = sx.at(value) else { continue };
            put(format!("<line class=\"g\" x1=\"{x:.1}\" y1=\"{y0:.1}\" x2=\"{x:.1}\" y2=\"{y1:.1}\"/>"));
            put(format!(
                "<text class=\"l\" text-anchor=\"middle\" x=\"{x:.1}\" y=\"{:.1}\">{label}</text>",
                y0 + 17.0
            ));
        }
        for (value, label) in sy.ticks() {
            let Some(y) = sy.at(value) else { continue };
            put(format!("<line class=\"g\" x1=\"{x0:.1}\" y1=\"{y:.1}\" x2=\"{x1:.1}\" y2=\"{y:.1}\"/>"));
            put(format!(
                "<text class=\"l\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{label}</text>",
                x0 - 8.0,
                y + 4.0
            ));
        }
        put(format!("<path class=\"a\" fill=\"none\" d=\"M{x0:.1} {y1:.1}V{y0:.1}H{x1:.1}\"/>"));
        let middle = (x0 + x1) * 0.5;
        put(format!(
            "<text class=\"l\" text-anchor=\"middle\" x=\"{middle:.1}\" y=\"{:.1}\">{}</text>",
            y0 + 40.0,
            escape(&self.x.label)
        ));
        let (x, y) = (left + 16.0, (y0 + y1) * 0.5);
        put(format!(
            "<text class=\"l\" text-anchor=\"middle\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\">{}</text>",
            escape(&self.y.label)
        ));
        let mut taken: Vec<(f64, f64, f64)> = Vec::new();
        for series in &self.series {
            let color = series.color % 8;
            let placed: Vec<(f64, f64)> =
                series.points.iter().filter_map(|(x, y)| Some((sx.at(*x)?, sy.at(*y)?))).collect();
            if series.mark != Mark::Dots {
                let mut path = String::new();
                for (i, (x, y)) in placed.iter().enumerate() {
                    // Strings take text without fail.
                    let _ = write!(path, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
                }
                let dashes = if series.mark == Mark::Dashes { " d" } else { "" };
                put(format!("<path class=\"s c{color}{dashes}\" d=\"{path}\"/>"));
                continue;
            }
            for (i, (x, y)) in placed.iter().enumerate() {
                put(format!("<circle class=\"f{color}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>"));
                if let Some(name) = series.names.get(i) {
                    let (text_x, text_y, anchor) = label_place(&mut taken, *x, *y, name.len(), (x1, y1));
                    put(format!(
                        "<text class=\"l\" text-anchor=\"{anchor}\" x=\"{text_x:.1}\" y=\"{text_y:.1}\">{}</text>",
                        escape(name)
                    ));
                }
            }
        }
        for (line, entries) in legend.iter().enumerate() {
            let y = top + 36.0 + LEGEND_LINE * line as f64;
            let mut x = x1;
            for series in entries.iter().rev() {
                let color = series.color % 8;
                x -= legend_width(&series.name);
                let dashes = if series.mark == Mark::Dashes { " d" } else { "" };
                put(match series.mark {
                    Mark::Dots => format!(
                        "<circle class=\"f{color}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"4.5\"/>",
                        x + 12.0,
                        y - 4.0
                    ),
                    _ => format!("<path class=\"s c{color}{dashes}\" d=\"M{x:.1} {:.1}h20\"/>", y - 4.0),
                });
                put(format!(
                    "<text class=\"l\" x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
                    x + 24.0,
                    escape(&series.name)
                ));
            }
        }
        svg
    }

    /// The series that have names, in lines that are no wider than `room`, unless one name is.
    fn legend(&self, room: f64) -> Vec<Vec<&Series>> {
        let mut lines: Vec<Vec<&Series>> = Vec::new();
        let mut used = 0.0;
        for series in self.series.iter().filter(|s| !s.name.is_empty()) {
            let width = legend_width(&series.name);
            match lines.last_mut().filter(|_| used + width <= room) {
                Some(line) => {
                    line.push(series);
                    used += width;
                }
                None => {
                    lines.push(vec![series]);
                    used = width;
                }
            }
        }
        lines
    }
}

/// What a name takes in the legend, its mark included.
fn legend_width(name: &str) -> f64 {
    name.chars().count() as f64 * 6.6 + 30.0
}

/// A place for the name of a point beside those that are taken: x, y and which end of the text is there.
fn label_place(
    taken: &mut Vec<(f64, f64, f64)>,
    x: f64,
    y: f64,
    letters: usize,
    (right, top): (f64, f64),
) -> (f64, f64, &'static str) {
    let width = letters as f64 * 6.4;
    let places = [4.0, -8.0, 16.0, -20.0, 28.0, -32.0, 40.0]
        .into_iter()
        .flat_map(|dy| [(x + 8.0, y + dy, "start"), (x - 8.0 - width, y + dy, "end")]);
    let free = |(left, y, _): &(f64, f64, &str)| {
        left + width <= right + 20.0
            && *left > MARGIN.0
            && *y >= top + 4.0
            && taken.iter().all(|(l, t, w)| (t - y).abs() >= 12.0 || *left > l + w || left + width < *l)
    };
    let (left, y, anchor) = places.clone().find(free).unwrap_or((x + 8.0, y + 4.0, "start"));
    taken.push((left, y, width));
    (if anchor == "end" { left + width } else { left }, y, anchor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(x: Axis, y: Axis, points: Vec<(f64, f64)>) -> String {
        let mut plot = Plot::new("a & b", x, y);
        plot.series.push(Series::line("one", 0, points.clone()));
        let names = vec!["p".into(), "q".into()];
        plot.series.push(Series { name: "two".into(), points, names, mark: Mark::Dots, color: 1 });
        plot.svg()
    }

    #[test]
    fn a_plot_has_its_words_and_no_number_that_is_none() {
        let svg =
            plot(Axis::linear("d, nm"), Axis::log("error"), vec![(0.0, 1e-5), (400.0, 0.0), (900.0, 1e-1)]);
        for part in ["a &amp; b", "d, nm", "1e-3", ">200<", "one", "two"] {
            assert!(svg.contains(part), "{part}\n{svg}");
        }
        for points in [vec![], vec![(1.0, 1.0)], vec![(f64::NAN, 1.0), (f64::INFINITY, -1.0)]] {
            for log in [false, true] {
                let axis = || Axis { label: "x".into(), log };
                let svg = plot(axis(), axis(), points.clone());
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            }
        }
    }

    #[test]
    fn names_that_do_not_fit_beside_each_other_get_another_line() {
        let mut plot = Plot::new("", Axis::linear("x"), Axis::linear("y"));
        let name = "a way to find lights";
        for i in 0..7 {
            plot.series.push(Series::line(name, i, vec![(0.0, 0.0), (1.0, 1.0)]));
        }
        let svg = plot.svg();
        let at = |element: &str, key: &str| -> f64 {
            let rest = &element[element.find(key).expect("the key") + key.len()..];
            rest[..rest.find('"').expect("its end")].parse().expect("a number")
        };
        let names: Vec<(f64, f64)> = svg
            .lines()
            .filter(|line| line.contains(name))
            .map(|line| (at(line, " x=\""), at(line, " y=\"")))
            .collect();
        assert_eq!(names.len(), 7);
        assert!(names.iter().all(|(x, _)| *x >= 24.0), "{names:?}");
        let lines = |n: usize| names.iter().filter(|(_, y)| *y == 36.0 + LEGEND_LINE * n as f64).count();
        assert_eq!([lines(0), lines(1)], [4, 3], "{names:?}");
    }

    #[test]
    fn ticks_are_round_numbers() {
        let scale = Scale::new(&Axis::linear(""), [0.0, 2400.0].into_iter(), 0.0, 100.0);
        let labels: Vec<String> = scale.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["0", "400", "800", "1200", "1600", "2000", "2400"].map(str::to_owned));
        let scale = Scale::new(&Axis::log(""), [8.0, 300.0].into_iter(), 0.0, 100.0);
        let labels: Vec<String> = scale.ticks().into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["10", "20", "50", "100", "200"].map(str::to_owned));
    }

    #[test]
    fn ticks_lie_on_the_axis_from_end_to_end() {
        // Rounded outwards, the first range is wider than what its step is made for.
        for range in [[0.36, 1.0066], [-3.0, 4.0], [1e-9, 1.1e-9], [5.0, 5.0]] {
            let scale = Scale::new(&Axis::linear(""), range.into_iter(), 0.0, 100.0);
            let at: Vec<f64> = scale.ticks().iter().filter_map(|t| scale.at(t.0)).collect();
            let (first, last) = (at[0], at[at.len() - 1]);
            assert!(first.abs() < 1e-3 && (last - 100.0).abs() < 1e-3, "{range:?} {at:?}");
        }
    }
}
