//! The report on the path tracer: error against samples and seconds, for every way to find lights.

use std::sync::Mutex;
use std::time::Instant;

use super::optics::Effort;
use super::plot::{Axis, Plot, Series};
use super::table::{Cell, Table};
use super::{Page, Report, Watch};
use crate::reference::{Control, Film, RenderError, Renderer, SamplerKind, Settings, Technique, Transport};
use crate::scene::Scene;

/// Ways to find lights, with where their numbers come from.
const WAYS: [(Technique, SamplerKind); 4] = [
    (Technique::Bsdf, SamplerKind::Independent),
    (Technique::NextEvent, SamplerKind::Independent),
    (Technique::Mis, SamplerKind::Independent),
    (Technique::Mis, SamplerKind::Sobol),
];

/// Share of the report's time that the truth takes, about: it has more samples than all other pictures.
const TRUTH: f32 = 0.57;
/// Share of the rest that the ways take; the shortcuts have fewer pictures.
const WAYS_SHARE: f32 = 0.87;

/// Pictures of some settings against the truth.
struct Point {
    samples: u32,
    mse: f64,
    seconds: f64,
}

/// Render a scene in every way, and compare with many more samples of another seed.
///
/// # Errors
/// If the scene cannot be rendered.
pub fn report(scene: &Scene, effort: Effort, watch: Watch<'_>) -> Result<Report, RenderError> {
    let quick = effort == Effort::Quick;
    let renderer = Renderer::new(scene)?;
    let (width, height, most, truth) = if quick { (80, 45, 64, 4096) } else { (160, 90, 256, 16_384) };
    let base = Settings { width, height, seed: 1, ..Settings::default() };
    let mut page = Page::new(format!("The path tracer on `{}`: error against time", scene.name));
    page.prose(format!(
        "A path tracer follows light at random, so its pictures have noise, and noise has a price: half of it costs four \
         times the samples. This page measures the price. The scene was rendered at {width} x {height} pixels in several ways, \
         and each picture compared with one of {truth} samples per pixel with other random numbers. MSE is the mean square \
         difference over all pixels and channels, linear, white paper in the sun being 1. All points of a line have the same \
         {together} samples per pixel, dealt out to more or to fewer pictures, so that rare bright specks count alike \
         everywhere and do not tilt the line; the MSE is the mean over these pictures. Seconds are those of one picture in this \
         run on this machine.",
        together = 2 * most
    ));
    watch(0.0, "the truth");
    let settings = Settings { samples: truth, seed: 77, ..base };
    let exact = {
        let watch = Mutex::new(&mut *watch);
        let progress = |share: f32| {
            // A thread that finds another one telling goes on with its work.
            if let Ok(mut watch) = watch.try_lock() {
                watch(TRUTH * share, "the truth");
            }
        };
        renderer.render(&settings, Control { progress: Some(&progress), ..Control::default() })
    };
    // Warm caches and tables before anything is timed.
    renderer.render(&Settings { samples: 1, ..base }, Control::default());

    let mut table = Table::new(
        "ways",
        "Ways to find lights: error and time",
        &["way", "numbers", "samples per pixel", "MSE", "seconds", "million samples/s", "MSE x seconds"],
    );
    let (mut by_samples, mut by_seconds) = (Vec::new(), Vec::new());
    let mut fits = Table::new(
        "slopes",
        "Fitted slopes",
        &["way", "numbers", "slope over samples", "slope over seconds"],
    );
    let mut summary = String::new();
    let step = |i: usize| TRUTH + (1.0 - TRUTH) * WAYS_SHARE * i as f32 / WAYS.len() as f32;
    for (i, &(technique, sampler)) in WAYS.iter().enumerate() {
        watch(step(i), technique.name());
        let points = points(&renderer, &Settings { technique, sampler, ..base }, most, &exact);
        let name = format!("{}, {}", technique.name(), sampler.name());
        for p in &points {
            let samples = f64::from(p.samples) * (width * height) as f64;
            table.row([
                Cell::text(technique.name()),
                Cell::text(sampler.name()),
                Cell::Count(p.samples.into()),
                Cell::Scientific(p.mse, 2),
                Cell::Fixed(p.seconds, 3),
                Cell::Fixed(samples / p.seconds / 1e6, 2),
                Cell::Scientific(p.mse * p.seconds, 2),
            ]);
        }
        let slopes = [
            slope(points.iter().map(|p| (f64::from(p.samples), p.mse))),
            slope(points.iter().map(|p| (p.seconds, p.mse))),
        ];
        fits.row([
            Cell::text(technique.name()),
            Cell::text(sampler.name()),
            Cell::Fixed(slopes[0], 3),
            Cell::Fixed(slopes[1], 3),
        ]);
        if let Some(last) = points.last() {
            summary += &format!(
                "{name}: MSE {:.2e} at {} samples in {:.2} s, slope {:.3}\n",
                last.mse, last.samples, last.seconds, slopes[0]
            );
        }
        by_samples.push(Series::line(
            &name,
            i,
            points.iter().map(|p| (f64::from(p.samples), p.mse)).collect(),
        ));
        by_seconds.push(Series::line(&name, i, points.iter().map(|p| (p.seconds, p.mse)).collect()));
    }
    page.heading("Ways to find lights");
    page.prose(
        "\"BSDF sampling\" sends paths where the surface likes to reflect and hopes that they meet a light; \"next-event \
         estimation\" asks a light at every surface; the last way does both and weighs them by how likely each was \
         (multiple importance sampling). Independent samples err with a slope of -1: twice as many, half the MSE. Sobol \
         points are spread evenly, and are better from the start or by slope. Slopes over seconds are steeper where pictures of \
         few samples spend their time on the start of each. A slope over samples that is far from -1 on independent ones tells \
         of rare bright paths, such as a sun that is mirrored onto the ground: the truth of this page has their noise, too.",
    );
    let mut plot = Plot::new("Error against samples", Axis::log("samples per pixel"), Axis::log("MSE"));
    plot.series = by_samples;
    page.figure("samples", plot.svg(), "Each line is a way; lower is better.");
    let mut plot = Plot::new("Error against time", Axis::log("seconds"), Axis::log("MSE"));
    plot.series = by_seconds;
    page.figure("seconds", plot.svg(), "The same pictures by the seconds that they took.");
    page.table(fits);
    page.table(table);

    watch(step(WAYS.len()), "shortcuts");
    shortcuts(&mut page, &renderer, &base, most, &exact);
    watch(1.0, "");
    Ok(Report { page, name: "convergence", summary, failures: Vec::new() })
}

/// Pictures of more and more samples, the last of `most`; all points have the same samples, in more or in fewer pictures.
fn points(renderer: &Renderer<'_>, settings: &Settings, most: u32, exact: &Film) -> Vec<Point> {
    std::iter::successors(Some(1), |n| Some(n * 4))
        .take_while(|n| *n <= most)
        .map(|samples| {
            let pictures = 2 * most / samples;
            let (mut sum, mut seconds) = (0.0, 0.0);
            for i in 0..pictures {
                let mut film = Film::new(settings.width, settings.height);
                let start = Instant::now();
                renderer.refine(&mut film, settings, i * samples..(i + 1) * samples, Control::default());
                seconds += start.elapsed().as_secs_f64();
                sum += mse(&film, exact);
            }
            let each = f64::from(pictures);
            Point { samples, mse: sum / each, seconds: (seconds / each).max(1e-9) }
        })
        .collect()
}

/// Mean square difference over pixels and channels.
fn mse(film: &Film, exact: &Film) -> f64 {
    let (a, b) = (film.rgb(), exact.rgb());
    let sum: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    sum / (3 * a.len()).max(1) as f64
}

/// Mean difference over pixels and channels: what more samples do not remove.
fn bias(film: &Film, exact: &Film) -> f64 {
    let (a, b) = (film.rgb(), exact.rgb());
    let sum: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b)).sum();
    sum / (3 * a.len()).max(1) as f64
}

/// What leaving light out saves, and how wrong it is.
fn shortcuts(page: &mut Page, renderer: &Renderer<'_>, base: &Settings, samples: u32, exact: &Film) {
    let full = |bounces| Transport::Full { bounces };
    let rows = [
        ("all", full(16), None),
        ("8 surfaces", full(8), None),
        ("4 surfaces", full(4), None),
        ("2 surfaces", full(2), None),
        ("1 surface", full(1), None),
        ("clamp 10", full(16), Some(10.0)),
        ("clamp 1", full(16), Some(1.0)),
        ("direct light in RGB", Transport::Direct { environment_shadows: true }, None),
        (
            "direct light in RGB, environment unshadowed",
            Transport::Direct { environment_shadows: false },
            None,
        ),
    ];
    let mut table = Table::new(
        "shortcuts",
        format!("Shortcuts at {samples} samples per pixel"),
        &["light", "seconds", "RMSE", "mean difference"],
    );
    for (name, transport, clamp) in rows {
        let settings = Settings { samples, transport, clamp, ..*base };
        let start = Instant::now();
        let film = renderer.render(&settings, Control::default());
        let seconds = start.elapsed().as_secs_f64();
        table.row([
            Cell::text(name),
            Cell::Fixed(seconds, 3),
            Cell::Scientific(mse(&film, exact).sqrt(), 2),
            Cell::Scientific(bias(&film, exact), 2),
        ]);
    }
    page.heading("Light that is left out");
    page.prose(
        "A path that may meet few surfaces leaves out light that comes by way of more. A clamp cuts what a path brings home by \
         way of a second surface: it removes the specks of rare bright paths and darkens what they light. Direct light in \
         red, green and blue is what a rasteriser can do. The RMSE has noise in it; the mean difference is what more samples \
         would not remove.",
    );
    page.table(table);
}

/// Slope of the least-squares line through the logarithms.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let logs: Vec<(f64, f64)> = points.map(|(x, y)| (libm::log10(x), libm::log10(y))).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let xy: f64 = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let xx: f64 = logs.iter().map(|p| (p.0 - mx).powi(2)).sum();
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_power_law_is_its_exponent() {
        let law = |k: f64| slope((0..6).map(|i| (4f64.powi(i), 0.3 * 4f64.powi(i).powf(k))));
        assert!((law(-1.0) + 1.0).abs() < 1e-12 && (law(-1.5) + 1.5).abs() < 1e-12);
    }
}
