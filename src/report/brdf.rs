//! What the whole BRDF loses by red, green and blue in place of wavelengths, and by a flat share of energy.

use rayon::prelude::*;

use super::metric::quantile;
use super::plot::{Axis, Plot, Series};
use super::table::{Cell, Table};
use super::timing::{self, Timing};
use crate::base::hash;
use crate::optics::cie::{self, Node};
use crate::optics::energy::{self, Furnace};
use crate::optics::film_color::{DEFAULT_INDICES, THESIS_NM, UNIFORM_NM};
use crate::optics::layered::{self, Constants, Energy, Layers, Point};
use crate::optics::{Film, FilmColor, Method, Real, Spectral};

/// Wavelengths of the truth: for the default film uniform ones are then right to 1e-5.
const TRUTH: usize = 128;

/// A point of the surface, seen and lit: gray base and layer, so that only the film has a colour.
#[derive(Clone, Copy, Debug)]
struct Case<F> {
    thickness_nm: F,
    roughness: F,
    albedo: F,
    absorption: F,
    wo: [F; 3],
    wi: [F; 3],
}

impl<F: Real> Case<F> {
    fn point<const N: usize>(&self) -> Point<F, N> {
        Point {
            thickness_nm: self.thickness_nm,
            roughness: self.roughness,
            albedo: [self.albedo; N],
            absorption: [self.absorption; N],
        }
    }
}

/// Random ones: 100 to 1500 nm, roughness 0.1 to 0.6, albedo 0.05 to 1, optical depth 0 or to 1, directions to 84 degrees.
fn cases<F: Real>(count: u32) -> Vec<Case<F>> {
    let case = |i: u32| {
        let mut next = 16 * i;
        let mut draw = |low: f64, high: f64| {
            next += 1;
            low + (high - low) * f64::from(hash::unit(hash::pcg(next)))
        };
        let mut direction = || {
            let (z, turn) = (draw(0.1, 1.0), draw(0.0, std::f64::consts::TAU));
            let r = (1.0 - z * z).sqrt();
            [r * libm::cos(turn), r * libm::sin(turn), z].map(F::from_f64)
        };
        let (wo, wi) = (direction(), direction());
        let f = F::from_f64;
        Case {
            thickness_nm: f(draw(100.0, 1500.0)),
            roughness: f(draw(0.1, 0.6)),
            albedo: f(draw(0.05, 1.0)),
            absorption: f(draw(-0.5, 1.0).max(0.0)),
            wo,
            wi,
        }
    };
    (0..count).map(case).collect()
}

/// What a BRDF is computed in.
#[derive(Clone, Debug)]
enum In<F: 'static> {
    /// Red, green, blue.
    Colors(Box<FilmColor<F>>),
    /// Eight wavelengths at a time.
    Eights(Vec<Packed<F, 8>>),
    /// Four wavelengths.
    Four(Packed<F, 4>),
}

/// Wavelengths and what they weigh in red, green, blue.
#[derive(Clone, Debug)]
struct Packed<F, const N: usize> {
    bands: Spectral<F, N>,
    weights: [[F; 3]; N],
}

impl<F: Real, const N: usize> Packed<F, N> {
    /// N nodes.
    fn new(nodes: &[Node; N]) -> Self {
        Self {
            bands: Spectral::new(nodes.map(|n| F::from_f64(n.wavelength_nm))),
            weights: nodes.map(|n| n.rgb.map(F::from_f64)),
        }
    }

    /// All nodes of a rule, N at a time; N divides their number.
    fn all(nodes: &[Node]) -> Vec<Self> {
        nodes.as_chunks::<N>().0.iter().map(Self::new).collect()
    }

    #[inline(always)]
    fn color(&self, layers: &Layers<F>, case: &Case<F>) -> [F; 3] {
        let f = layered::eval(layers, &self.bands, &case.point(), case.wo, case.wi);
        f.iter()
            .zip(&self.weights)
            .fold([F::ZERO; 3], |sum, (f, w)| std::array::from_fn(|c| sum[c] + w[c] * *f))
    }
}

impl<F: Real> In<F> {
    fn color(&self, layers: &Layers<F>, case: &Case<F>) -> [F; 3] {
        match self {
            Self::Colors(colors) => layered::eval(layers, &**colors, &case.point(), case.wo, case.wi),
            Self::Four(four) => four.color(layers, case),
            Self::Eights(eights) => eights.iter().fold([F::ZERO; 3], |sum, eight| {
                let rgb = eight.color(layers, case);
                std::array::from_fn(|c| sum[c] + rgb[c])
            }),
        }
    }

    fn wavelengths(count: usize) -> Self {
        let nodes = cie::uniform_nodes(count, UNIFORM_NM);
        match nodes.first_chunk::<4>() {
            Some(four) if count == 4 => Self::Four(Packed::new(four)),
            _ => Self::Eights(Packed::all(&nodes)),
        }
    }
}

/// The kinds that are compared: a name, and red, green and blue by a method or so many wavelengths.
const KINDS: [(&str, Result<Method, usize>); 7] = [
    ("three wavelengths (thesis)", Ok(Method::Three(THESIS_NM))),
    ("belcour-gltf", Ok(Method::BelcourGltf)),
    ("series-3", Ok(Method::Series(3))),
    ("4 wavelengths", Err(4)),
    ("8 wavelengths", Err(8)),
    ("16 wavelengths", Err(16)),
    ("32 wavelengths", Err(32)),
];

fn kind<F: Real>(kind: Result<Method, usize>) -> In<F> {
    match kind {
        Ok(method) => In::Colors(Box::new(FilmColor::new(method))),
        Err(count) => In::wavelengths(count),
    }
}

/// The default film over gray pigment with this share of energy.
fn layers<F: Real>(energy: Energy) -> Option<Layers<F>> {
    let indices = DEFAULT_INDICES.map(|n| n as f32);
    Layers::new(&Constants { indices, energy, ..Constants::default() }).ok()
}

/// Errors and times of the whole BRDF; `count` cases, `rounds` of timing. And the mean relative error and its 99th
/// percentile of [`Method::Series`] of three.
pub fn table(count: u32, rounds: usize) -> (Table, (f64, f64)) {
    let columns = [
        "computed in",
        "energy",
        "ns",
        "ns, median",
        "relative error: mean",
        "p99",
        "greatest",
        "against coupled truth: mean",
    ];
    let mut table = Table::new("brdf", "The whole BRDF: film, pigment and base", &columns);
    let (double, single) = (cases::<f64>(count), cases::<f32>(count.min(4096)));
    let truths = [Energy::Flat, Energy::Coupled].map(|energy| -> Vec<[f64; 3]> {
        let (Some(layers), truth) = (layers(energy), In::wavelengths(TRUTH)) else { return Vec::new() };
        double.par_iter().map(|case| truth.color(&layers, case)).collect()
    });
    let mut shading = (f64::INFINITY, f64::INFINITY);
    for (name, computed) in KINDS {
        for (i, energy) in [Energy::Flat, Energy::Coupled].into_iter().enumerate() {
            let (Some(layers), Some(shaded)) = (layers::<f64>(energy), layers::<f32>(energy)) else {
                continue;
            };
            let colors = kind::<f64>(computed);
            let all: Vec<[f64; 3]> = double.par_iter().map(|case| colors.color(&layers, case)).collect();
            let [own, coupled] = [&truths[i], &truths[1]].map(|truth| relative(&all, truth));
            let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            if computed == Ok(Method::Series(3)) && energy == Energy::Flat {
                shading = (mean(&own), quantile(&own, 0.99));
            }
            let colors = kind::<f32>(computed);
            let Timing { best_ns, median_ns } =
                timing::per_evaluation(&single, rounds, |case| colors.color(&shaded, case));
            table.row([
                Cell::text(name),
                Cell::text(if energy == Energy::Flat { "flat" } else { "coupled" }),
                Cell::Fixed(best_ns, 0),
                Cell::Fixed(median_ns, 0),
                Cell::Scientific(mean(&own), 1),
                Cell::Scientific(quantile(&own, 0.99), 1),
                Cell::Scientific(quantile(&own, 1.0), 1),
                Cell::Scientific(mean(&coupled), 1),
            ]);
        }
    }
    (table, shading)
}

/// Greatest error of a channel over the mean of the true ones, for each colour.
fn relative(colors: &[[f64; 3]], truth: &[[f64; 3]]) -> Vec<f64> {
    let one = |(a, b): (&[f64; 3], &[f64; 3])| {
        let error = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        error * 3.0 / b.iter().sum::<f64>().max(1e-12)
    };
    colors.iter().zip(truth).map(one).collect()
}

/// Roughnesses of the furnace.
const ROUGHNESSES: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.5, 1.0];

/// The furnace: a white base under the default film of 400 nm at 550 nm, in light that is 1 from everywhere. What comes back
/// by cosine of the view, flat; the greatest total of the flat share, and how far the coupled total is from 1.
#[derive(Clone, Debug)]
pub struct Furnaces {
    /// By roughness and cosine.
    pub table: Table,
    /// The flat total against the angle.
    pub plot: Plot,
    /// Greatest total of the flat share.
    pub flat: f64,
    /// Greatest difference of the coupled total from 1.
    pub coupled: f64,
}

/// Compute them by quadrature.
pub fn furnaces() -> Furnaces {
    let columns =
        ["roughness", "cosine 1", "0.7", "0.4", "0.2", "0.1", "0.03", "coupled: greatest difference from 1"];
    let mut table =
        Table::new("furnace", "Light that comes back from a white base, flat share of energy", &columns);
    let mut plot = Plot::new(
        "A white surface in a furnace: what the flat share of energy loses",
        Axis::linear("angle of view, degrees"),
        Axis::linear("light that comes back"),
    );
    let (mut flat, mut coupled) = (0.0f64, 0.0f64);
    let [n0, n1, n2] = DEFAULT_INDICES;
    let film = Film::new(n0, n1, n2, 400.0).ok();
    let at = |roughness: f64, cosine: f64| {
        film.map_or(Furnace::default(), |f| energy::furnace(&f, 550.0, roughness, 1.0, 0.0, cosine))
    };
    for (color, roughness) in ROUGHNESSES.into_iter().enumerate() {
        let all: Vec<Furnace> =
            [1.0, 0.7, 0.4, 0.2, 0.1, 0.03].into_par_iter().map(|cosine| at(roughness, cosine)).collect();
        let lost = all.iter().map(|f| (f.specular + f.diffuse_coupled - 1.0).abs()).fold(0.0, f64::max);
        coupled = coupled.max(lost);
        let totals: Vec<f64> = all.iter().map(|f| f.specular + f.diffuse_flat).collect();
        flat = totals.iter().copied().fold(flat, f64::max);
        let mut row = vec![Cell::Fixed(roughness, 1)];
        row.extend(totals.iter().map(|t| Cell::Fixed(*t, 4)));
        row.push(Cell::Scientific(lost, 1));
        table.row(row);
        let points: Vec<(f64, f64)> = (0..=29)
            .into_par_iter()
            .map(|i| 3.0 * f64::from(i))
            .map(|degrees| {
                let furnace = at(roughness, super::film::cosine(degrees));
                (degrees, furnace.specular + furnace.diffuse_flat)
            })
            .collect();
        flat = points.iter().map(|p| p.1).fold(flat, f64::max);
        plot.series.push(Series::line(format!("{roughness}"), color, points));
    }
    Furnaces { table, plot, flat, coupled }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_near_wavelengths_and_three_wavelengths_are_not() {
        let (table, (mean, p99)) = table(64, 1);
        assert_eq!(table.rows.len(), 2 * KINDS.len());
        assert!(mean > 0.0 && mean < 5e-3 && p99 < 2e-2, "{mean} {p99}");
        let Cell::Scientific(thesis, _) = table.rows[0][4] else { panic!("a number") };
        assert!(thesis > 10.0 * mean, "{thesis} {mean}");
    }

    #[test]
    fn the_coupled_furnace_is_white_and_the_flat_one_has_its_published_values() {
        let furnaces = furnaces();
        assert!(furnaces.coupled < 1e-9 && furnaces.flat < 1.01, "{} {}", furnaces.coupled, furnaces.flat);
        let published = [
            [1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000],
            [1.0001, 0.9999, 1.0000, 0.9981, 0.9894, 0.9176],
            [1.0032, 0.9969, 0.9910, 0.9147, 0.7669, 0.5706],
            [1.0066, 0.9802, 0.9517, 0.8117, 0.6250, 0.3985],
            [0.9657, 0.9137, 0.8767, 0.7178, 0.5153, 0.2778],
        ];
        for (row, expected) in [0, 1, 3, 4, 5].into_iter().zip(published) {
            for (cell, expected) in furnaces.table.rows[row][1..].iter().zip(expected) {
                let Cell::Fixed(total, _) = cell else { panic!("a number") };
                assert!((total - expected).abs() < 1e-4, "{row}: {total} {expected}");
            }
        }
    }
}
