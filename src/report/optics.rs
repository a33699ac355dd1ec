//! The report on the skin's optics: colours of films, extreme cases, another renderer.

use super::brdf;
use super::film::{self, Grid, METHODS, USUAL_DEG};
use super::pictures::{self, Size};
use super::plot::{Axis, Mark, Plot, Series};
use super::skin_sweep;
use super::stability::{self, Sweep};
use super::table::{Cell, Table};
use super::timing::Timing;
use super::{Page, Report, Watch};
use crate::optics::film_color::{BEST_NM, DEFAULT_INDICES, THESIS_NM};
use crate::optics::{Film, FilmColor, Method};

/// How thorough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A minute, every number.
    Full,
    /// Seconds: fewer films, fewer random cases.
    Quick,
}

/// Films of 10 to 100 micrometres, nm.
const THICK_NM: [f64; 6] = [10_000.0, 15_848.9, 25_118.9, 39_810.7, 63_095.7, 100_000.0];
/// The thickest film, nm.
const MILLIMETRES_NM: [f64; 1] = [2.4e6];

/// What was measured of a method.
struct Measured {
    method: Method,
    timing: Timing,
    /// RMSE, greatest, mean and 99th percentile of CIEDE2000: thin films at usual angles, at all angles, thick ones,
    /// 2.4 mm, and the default film at all angles. None: not for such films.
    errors: [Option<[f64; 4]>; 5],
}

/// The method that the thesis uses.
const THESIS: Method = Method::Three(THESIS_NM);
/// The method that shading uses.
const SHADING: Method = Method::Series(3);

/// Compute the report; `watch` is told of its progress.
pub fn report(effort: Effort, watch: Watch<'_>) -> Report {
    let quick = effort == Effort::Quick;
    let mut page = Page::new("Light on snake skin: what every shortcut costs");
    let mut failures = Vec::new();
    introduction(&mut page);

    watch(0.0, "true colours of films");
    let stacks = film::stacks();
    let count = if quick { 23 } else { 66 };
    let thin = Grid::new(&stacks, &film::thin_nm(count));
    watch(0.1, "true colours of thick films");
    let thick = Grid::new(&stacks, &THICK_NM[..if quick { 1 } else { THICK_NM.len() }]);
    let millimetres = Grid::new(&stacks, &MILLIMETRES_NM);
    let default = Grid::new(&[DEFAULT_INDICES], &film::thin_nm(count));
    let measured: Vec<Measured> = (METHODS.iter().enumerate())
        .map(|(i, &method)| {
            watch(0.3 + 0.4 * i as f32 / METHODS.len() as f32, &method.to_string());
            measure(method, [&thin, &thick, &millimetres, &default], quick)
        })
        .collect();
    watch(0.7, "integration, to check the truth");
    let convergence = thin.self_convergence(if quick { 97 } else { 7 });
    let summary = films(&mut page, &mut failures, &measured, &thin, convergence);
    watch(0.75, "the whole BRDF");
    let layers = whole(&mut page, &mut failures, if quick { 128 } else { 4096 }, if quick { 5 } else { 21 });
    watch(0.8, "whole pictures");
    let size = if quick { Size { side: 32, samples: 64 } } else { Size { side: 64, samples: 1024 } };
    let pictures = pictures(&mut page, &mut failures, size);
    watch(0.9, "extreme cases");
    stable(&mut page, &mut failures, if quick { 100_000 } else { 10_000_000 });
    cycles(&mut page, &mut failures);
    watch(1.0, "");
    let summary = if failures.is_empty() {
        summary + &layers + &pictures + "\nAll cases pass.\n"
    } else {
        summary
            + &layers
            + &pictures
            + "\nFAILED:\n"
            + &failures.iter().map(|f| format!("  {f}\n")).collect::<String>()
    };
    Report { page, name: "optics", summary, failures }
}

/// Whether a number is at most so great; a NaN is not.
fn within(value: f64, most: f64) -> bool {
    value <= most
}

fn introduction(page: &mut Page) {
    page.prose(
        "Scales of many snakes carry a clear film of keratin, some hundred nanometres thick. Light that is reflected at \
         its upper and at its lower side interferes, and the skin shimmers in colours that change with the angle and with \
         the thickness. A renderer must compute that colour millions of times, so everyone takes shortcuts. This page \
         measures them: how far each is from the truth, and how many nanoseconds it takes.",
    );
    page.prose(
        "A film is told by three refractive indices (outside, film, below; the default is air 1, keratin 1.55, and 2 below) \
         and its thickness. Colours are linear RGB (sRGB primaries) under daylight D65, white being 1. RMSE is the root of \
         the mean square error of a channel. CIEDE2000 is a difference as an eye sees it: 1 is about what one can tell, 10 \
         is another colour. Errors are computed in 64 bits, so they are those of the method and not of rounding; times are \
         those of 32-bit shading on one thread, measured in this very run, so they differ from run to run and from machine \
         to machine. The errors do not.",
    );
}

fn measure(method: Method, [thin, thick, millimetres, default]: [&Grid; 4], quick: bool) -> Measured {
    let of = |grid: &Grid, degrees: f64| {
        let errors = grid.errors(method, degrees);
        [errors.rmse(), errors.max(), errors.delta_e_mean(), errors.delta_e_quantile(0.99)]
    };
    let is_table = matches!(method, Method::Table(..));
    Measured {
        method,
        timing: film::time(method, if quick { 9 } else { 41 }),
        errors: [
            Some(of(thin, USUAL_DEG)),
            Some(of(thin, 90.0)),
            (!is_table).then(|| of(thick, USUAL_DEG)),
            (!is_table).then(|| of(millimetres, USUAL_DEG)),
            Some(of(default, 90.0)),
        ],
    }
}

/// The colours of films; returns the summary.
fn films(
    page: &mut Page,
    failures: &mut Vec<String>,
    measured: &[Measured],
    thin: &Grid,
    (quadrature, series): (f64, f64),
) -> String {
    page.heading("The colour of a film: error against time");
    page.prose(format!(
        "The grid has {} films and directions: a film of index 1.33, 1.55 or 1.8 in air on 1, 1.33, 1.5 or 2, from 1 to \
         2400 nm thick, from 0 to 89.9 degrees. The truth is the series below, carried on until less than 1e-7 is left. It was \
         checked in this run in two ways: carrying it on to 1e-9 changes it by at most {series:.1e}, and integrating the exact \
         reflectance over 1880 wavelengths differs from it by at most {quadrature:.1e} up to 76 degrees (closer to grazing, \
         resonances get so sharp that such an integration is the worse of the two).",
        thin.len()
    ));
    page.prose(
        "The methods. \"Three wavelengths\" computes red, green and blue at one wavelength each, as the thesis does (650, 510 and \
         475 nm), or at the best three that were found. \"uniform-N\" takes N wavelengths and weighs them as the eye does. \
         \"belcour\" is the method of Belcour and Barla (2017), which describes the eye by four bell curves: \
         \"belcour-gltf\" as viewers of glTF files do it, with Schlick's approximation and two orders; \"belcour\" with exact \
         reflectances and three; \"belcour-white\" also with white made white. \"lut-N\" looks the colour up in a table of \
         N by N for one film, which must be made anew for any other. \"series-K\" is ours: the exact sum over internal \
         reflections, of which K are taken, with one small table for the eye. It needs no special case for thick films: \
         where fringes are finer than an eye can resolve, their terms are 0.",
    );
    let thesis = measured.iter().find(|m| m.method == THESIS);
    let mut table = Table::new(
        "film_color",
        "Errors of methods for the colour of a film",
        &[
            "method",
            "ns",
            "ns, median",
            "cost, three wavelengths = 1",
            "thin to 76 deg: RMSE",
            "greatest",
            "CIEDE2000 mean",
            "CIEDE2000 p99",
            "thin, all angles: RMSE",
            "all angles: greatest",
            "10 to 100 um: RMSE",
            "10 to 100 um: CIEDE2000 mean",
            "2.4 mm: RMSE",
            "default film, all angles: RMSE",
            "default film: greatest",
            "default film: CIEDE2000 p99",
            "default film: closer than three wavelengths by",
        ],
    );
    let ratio = |f: fn(&Measured) -> Option<f64>, m: &Measured| Some((f(thesis?)?, f(m)?));
    let ns = |m: &Measured| Some(m.timing.best_ns);
    let snake = |m: &Measured| m.errors[4].map(|e| e[0]);
    for m in measured {
        let small = |i: usize, k: usize| m.errors[i].map_or(Cell::None, |e| Cell::Scientific(e[k], 1));
        let fixed = |i: usize, k: usize| m.errors[i].map_or(Cell::None, |e| Cell::Fixed(e[k], 3));
        let cost = ratio(ns, m).map_or(Cell::None, |(three, own)| Cell::Fixed(own / three, 2));
        let closer = ratio(snake, m).map_or(Cell::None, |(three, own)| Cell::Fixed(three / own, 0));
        table.row([
            Cell::text(m.method),
            Cell::Fixed(m.timing.best_ns, 1),
            Cell::Fixed(m.timing.median_ns, 1),
            cost,
            small(0, 0),
            small(0, 1),
            fixed(0, 2),
            fixed(0, 3),
            small(1, 0),
            small(1, 1),
            small(2, 0),
            fixed(2, 2),
            small(3, 0),
            small(4, 0),
            small(4, 1),
            fixed(4, 3),
            closer,
        ]);
    }
    page.table(table);
    page.figure(
        "error_time",
        error_against_time(measured).svg(),
        "Left and low is better. RMSE over thin films to 76 degrees.",
    );
    page.figure(
        "error_time_default",
        error_against_time_of(measured, 4, "Error against time: the default film, all angles").svg(),
        "The same for the default film (1, 1.55, 2), which snakes of the thesis have.",
    );
    let (curves, errors) = curves();
    page.figure(
        "curves",
        curves.svg(),
        "Colour of the default film seen along the normal. Dashes: three wavelengths, as in the thesis.",
    );
    page.figure("errors", errors.svg(), "Greatest error of a channel at each thickness, along the normal.");

    let mut short = Table::new(
        "summary",
        "Colour of a film, f32, one thread; RMSE in linear RGB",
        &["method", "ns", "thin, to 76 deg", "dE mean", "thin, all", "10-100 um", "2.4 mm", "default film"],
    );
    for m in measured {
        let small = |i: usize, k: usize| m.errors[i].map_or(Cell::None, |e| Cell::Scientific(e[k], 1));
        let de = m.errors[0].map_or(Cell::None, |e| Cell::Fixed(e[2], 2));
        let cells = [small(0, 0), de, small(1, 0), small(2, 0), small(3, 0), small(4, 0)];
        short.row([Cell::text(m.method), Cell::Fixed(m.timing.best_ns, 1)].into_iter().chain(cells));
    }
    let mut summary = short.text();
    if let Some(m) = measured.iter().find(|m| m.method == SHADING)
        && let (Some((three_ns, own_ns)), Some((three, own))) = (ratio(ns, m), ratio(snake, m))
    {
        let (cost, closer) = (own_ns / three_ns, three / own);
        let text = format!(
            "The default of shading, {SHADING}, takes {cost:.2} times as long as three wavelengths and is {closer:.0} times \
             closer to the truth on the default film."
        );
        page.prose(&text);
        summary += &format!("{text}\n");
        if !within(cost, 1.5) {
            failures.push(format!(
                "{SHADING} takes {cost:.2} times as long as three wavelengths; 1.5 is allowed"
            ));
        }
        if !within(100.0, closer) {
            failures.push(format!("{SHADING} is only {closer:.0} times closer than three wavelengths"));
        }
    }
    // The transform ends at 41 um of path: what a sharp resonance has beyond it is up to 1.3e-6 on this grid.
    if !within(quadrature, 5e-6) {
        failures.push(format!("the truth and its integration differ by {quadrature:e}"));
    }
    page.prose(
        "How to read the corners. The greatest errors of the series at all angles belong to one corner: the same index above and \
         below the film, as in a soap bubble, within a degree of grazing, where light is reflected very many times. On \
         a denser base, as skin is, three terms suffice everywhere; where the indices above and below are within 5 percent, \
         take eight. Schlick's approximation costs viewers more accuracy than the bell curves do. Tables of colours end at \
         2400 nm, hence no numbers for thicker films.",
    );
    summary
}

fn error_against_time(measured: &[Measured]) -> Plot {
    error_against_time_of(measured, 0, "Error against time: thin films, to 76 degrees")
}

fn error_against_time_of(measured: &[Measured], errors: usize, title: &str) -> Plot {
    let mut plot = Plot::new(title, Axis::log("time of one colour, ns"), Axis::log("RMSE, linear RGB"));
    let family = |m: Method| match m {
        Method::Three(_) => 0,
        Method::Uniform(_) => 1,
        Method::BelcourGltf | Method::Belcour | Method::BelcourWhite => 2,
        Method::Table(..) => 3,
        Method::Series(_) | Method::Adaptive(_) => 4,
    };
    for (i, (name, color)) in
        [("three wavelengths", 3), ("wavelengths", 1), ("Belcour", 2), ("tables", 4), ("series", 0)]
            .into_iter()
            .enumerate()
    {
        let own = measured.iter().filter(|m| family(m.method) == i);
        let (points, names) = own
            .filter_map(|m| Some(((m.timing.best_ns, m.errors[errors]?[0]), short_name(m.method))))
            .unzip();
        plot.series.push(Series { name: name.into(), points, names, mark: Mark::Dots, color });
    }
    plot
}

fn short_name(method: Method) -> String {
    match method {
        THESIS => "three (thesis)".into(),
        Method::Three(BEST_NM) => "three (best)".into(),
        other => other.to_string(),
    }
}

/// Colour, and error, against thickness.
fn curves() -> (Plot, Plot) {
    let [reference, thesis, best, gltf, series] =
        [Method::REFERENCE, THESIS, Method::Three(BEST_NM), Method::BelcourGltf, SHADING]
            .map(FilmColor::<f64>::new);
    let [n0, n1, n2] = DEFAULT_INDICES;
    let films: Vec<(f64, Film<f64>)> = (0..=400)
        .map(|i| 6.0 * f64::from(i))
        .filter_map(|d| Some((d, Film::new(n0, n1, n2, d).ok()?)))
        .collect();
    let mut curves = Plot::new(
        "Colour of the default film",
        Axis::linear("thickness, nm"),
        Axis::linear("reflected, linear RGB"),
    );
    for (c, (name, color)) in [("red", 3), ("green", 2), ("blue", 0)].into_iter().enumerate() {
        let line =
            |colors: &FilmColor<f64>| films.iter().map(|(d, f)| (*d, colors.color(f, 1.0)[c])).collect();
        let dashes = Series { mark: Mark::Dashes, ..Series::line("", color, line(&thesis)) };
        curves.series.extend([dashes, Series::line(name, color, line(&reference))]);
    }
    let mut errors = Plot::new(
        "Error along the thickness",
        Axis::linear("thickness, nm"),
        Axis::log("greatest error, linear RGB"),
    );
    let compared = [
        ("three (thesis)", &thesis, 3),
        ("three (best)", &best, 1),
        ("belcour-gltf", &gltf, 2),
        ("series-3", &series, 0),
    ];
    for (name, colors, color) in compared {
        let error = |film: &Film<f64>| {
            let (a, b) = (colors.color(film, 1.0), reference.color(film, 1.0));
            (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
        };
        // At thickness 0 all are exact: nothing to show on this axis.
        let points = films.iter().map(|(d, f)| (*d, error(f))).filter(|p| p.1 > 1e-12).collect();
        errors.series.push(Series::line(name, color, points));
    }
    (curves, errors)
}

/// The BRDF of all layers; returns its summary.
fn whole(page: &mut Page, failures: &mut Vec<String>, count: u32, rounds: usize) -> String {
    page.heading("The whole skin: film, pigment and base");
    page.prose(format!(
        "Light that the film does not reflect goes through it and through a layer with pigment, is scattered by the base below,          and comes back. Nature does that for each wavelength; shading does it for red, green and blue, and multiplies colours          where it should multiply spectra. Here are both, for {count} random points of the default film, 100 to 1500 nm thick,          and random directions. The error is that of the worst channel, relative to the mean of the true ones; the truth has 128          wavelengths. Base and pigment are gray, so that all colour is the film's. Time is that of one colour, from          a point and two directions.",
    ));
    let (table, (mean, p99)) = brdf::table(count, rounds);
    let summary = format!("\n{}", table.text());
    page.table(table);
    page.prose(format!(
        "Red, green and blue by series-3 cost {:.2} percent on average and {:.1} percent at most in 99 of 100 cases.",
        100.0 * mean,
        100.0 * p99
    ));
    let furnaces = brdf::furnaces();
    page.prose(
        "The share of energy. On a rough surface light gets past the film at many angles. \"Flat\" takes the film's transmittance \
         at the angle to the mean surface: fast, and right for smooth skin. \"Coupled\" takes exactly what the rough \
         film does not reflect, from a table. The test is a furnace: a white surface in light from everywhere must \
         vanish, that is, send back 1. Coupled does at any roughness; flat darkens rough surfaces at grazing angles.",
    );
    page.table(furnaces.table);
    page.figure(
        "furnace",
        furnaces.plot.svg(),
        "Flat share of energy, one line for each roughness; coupled is 1 everywhere.",
    );
    if !within(furnaces.flat, 1.01) {
        failures.push(format!("the flat furnace sends back {}", furnaces.flat));
    }
    if !within(furnaces.coupled, 1e-9) {
        failures.push(format!("the coupled furnace differs from 1 by {:e}", furnaces.coupled));
    }
    if !within(mean, 5e-3) {
        failures.push(format!("the BRDF in colours differs from that in wavelengths by {mean:e}"));
    }
    summary
}

/// Pictures in place of single BRDFs; returns their summary.
fn pictures(page: &mut Page, failures: &mut Vec<String>, size: Size) -> String {
    page.heading("Whole pictures");
    page.prose(
        "What a viewer sees of all that: a sphere in a grey studio, ringed red, cream and black, below a film of 100 to 1000 nm. \
         The path tracer follows all light in wavelengths only, with the coupled share of energy; in red, green and blue \
         there is direct light alone, coupled or flat. So each picture is compared twice: with direct light in \
         wavelengths, which tells what colours and the flat share cost by themselves, and with all light, which \
         tells what a viewer is off the truth. All pictures have the same random numbers but the first row of each, \
         which shows the noise: what is well below it is too small to tell. RMSE and CIEDE2000 are of linear colours \
         where white paper is 1.",
    );
    match pictures::rows(size) {
        Ok(rows) => {
            let table = pictures::table(&rows, size);
            let summary = format!("\n{}", table.text());
            page.table(table);
            summary
        }
        Err(message) => {
            failures.push(message);
            String::new()
        }
    }
}

/// Extreme cases and sweeps.
fn stable(page: &mut Page, failures: &mut Vec<String>, random: u64) {
    page.heading("Extreme cases");
    page.prose(
        "A formula that is right for a usual film may fail at the ends: no thickness, millimetres, grazing light, equal indices, total \
         reflection. Each case here has a value that is known from a closed form or from an independent program. f64 is \
         the precision of the reference renderer, f32 that of shading.",
    );
    let cases = stability::cases();
    page.table(stability::table(&cases));
    failures.extend(cases.iter().filter(|c| !c.passes()).map(|c| c.name.clone()));

    let mut table = Table::new("sweeps", "Anything at all", &["check", "worst found", "allowed", "result"]);
    let mut check = |name: String, worst: f64, allowed: f64| {
        let pass = within(worst, allowed);
        if !pass {
            failures.push(format!("{name}: {worst:e}, allowed {allowed:e}"));
        }
        table.row([
            Cell::text(name),
            Cell::Scientific(worst, 1),
            Cell::Scientific(allowed, 1),
            Cell::Pass(pass),
        ]);
    };
    let (single, double) = (stability::sweep::<f32>(random), stability::sweep::<f64>(random));
    for (name, sweep, energy) in [("f32", single, 2e-6), ("f64", double, 1e-14)] {
        let Sweep { count, not_numbers, outside, color, .. } = sweep;
        check(
            format!("{count} random films in {name}: results that are no numbers"),
            not_numbers as f64,
            0.0,
        );
        check(format!("{count} random films in {name}: R or T outside 0 to 1"), outside as f64, 0.0);
        check(
            format!("{count} random films in {name}: energy made or lost, |R + T - 1|"),
            sweep.energy,
            energy,
        );
        check(format!("{count} random films in {name}: channel of series-3 below 0 by"), -color.0, 0.3);
        check(format!("{count} random films in {name}: channel of series-3 above 1 by"), color.1 - 1.0, 0.6);
    }
    let skins = skin_sweep::sweep(random);
    let points = format!("{} random points of whole skins in f32", skins.count);
    check(format!("{points}: values and densities that are no numbers"), skins.not_numbers as f64, 0.0);
    check(format!("{points}: values and densities below 0"), skins.negative as f64, 0.0);
    check(format!("{points}: energy made by the film, R + T - 1"), skins.energy, 2e-6);
    check(
        "films of no thickness, of 1000, that differ from Fresnel in any bit".into(),
        f64::from(stability::not_fresnel(1000)),
        0.0,
    );
    check(
        "2.4 mm plus 0 to 10 um: change of colour (moire), series-3 in f32".into(),
        stability::moire(SHADING),
        1e-6,
    );
    let (filtered, unfiltered) = stability::ramp();
    check(
        "ramp of 0 to 2400 nm over 64 pixels: error of a pixel with the footprint filter".into(),
        filtered,
        5e-4,
    );
    page.table(table);
    page.prose(format!(
        "The same change of colour at 2.4 mm is {:.2} with three wavelengths and {:.3} with 64: rings where there are none in \
         nature. On the ramp, the exact colour in the middle of a pixel, without the filter, is off by {unfiltered:.1e}. \
         Saturated colours of films lie outside the sRGB gamut, so channels a little below 0 or above 1 are right.",
        stability::moire(THESIS),
        stability::moire(Method::Uniform(64)),
    ));
}

fn cycles(page: &mut Page, failures: &mut Vec<String>) {
    page.heading("Another renderer");
    page.prose(
        "Blender's Cycles (5.0) has thin films, too, written by others. The same film there: a Principled BSDF with a black \
         base of index 2 and roughness 0, a film of 1.55, a white world. Both agree to about 0.01 along the normal. What is left has known causes: Cycles \
         makes colours with another white point, keeps three orders of its series, and interpolates a coarser table.",
    );
    let (table, worst) = stability::cycles();
    page.table(table);
    if !within(worst, 0.012) {
        failures.push(format!("Cycles differs by {worst} along the normal; 0.012 is allowed"));
    }
}
