//! What the methods for the colour of a film lose, and what they cost.

use rayon::prelude::*;

use super::metric::ColorErrors;
use super::timing::{self, Timing};
use crate::base::hash;
use crate::optics::film_color::{BEST_NM, DEFAULT_INDICES, THESIS_NM};
use crate::optics::{Film, FilmColor, Method, cie};

/// The methods that are compared.
pub const METHODS: [Method; 17] = [
    Method::Three(THESIS_NM),
    Method::Three(BEST_NM),
    Method::Uniform(8),
    Method::Uniform(16),
    Method::Uniform(32),
    Method::Uniform(64),
    Method::BelcourGltf,
    Method::Belcour,
    Method::BelcourWhite,
    Method::Table(64, 64),
    Method::Table(256, 256),
    Method::Series(1),
    Method::Series(2),
    Method::Series(3),
    Method::Series(4),
    Method::Series(6),
    Method::Adaptive(1e-4),
];

/// Angles of incidence, degrees: denser towards grazing.
pub const ANGLES_DEG: [f64; 18] = [
    0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 73.0, 76.0, 80.0, 83.0, 86.0, 88.0, 89.0, 89.5, 89.9,
];
/// Up to here angles are called usual: of the disc that a ball shows, sin^2 = 94 % is within.
pub const USUAL_DEG: f64 = 76.0;

/// Films and directions with their true colours.
#[derive(Clone, Debug)]
pub struct Grid {
    points: Vec<Point>,
}

/// One film in one direction.
#[derive(Clone, Copy, Debug)]
struct Point {
    indices: [f64; 3],
    thickness_nm: f64,
    angle_deg: f64,
    truth: [f64; 3],
}

/// Twelve stacks: a film of index 1.33, 1.55 or 1.8 in air, on 1, 1.33, 1.5 or 2.
pub fn stacks() -> Vec<[f64; 3]> {
    let on = |n1: f64| [1.0, 1.33, 1.5, 2.0].map(|n2| [1.0, n1, n2]);
    [1.33, 1.55, 1.8].into_iter().flat_map(on).collect()
}

/// `count` thicknesses of thin films, nm: 1, then evenly to 2400.
pub fn thin_nm(count: usize) -> Vec<f64> {
    (0..count).map(|i| (2400.0 * i as f64 / (count - 1).max(1) as f64).max(1.0)).collect()
}

impl Grid {
    /// Every stack, thickness and angle of [`ANGLES_DEG`]; truth is [`Method::REFERENCE`] in f64.
    pub fn new(stacks: &[[f64; 3]], thicknesses_nm: &[f64]) -> Self {
        let reference = FilmColor::<f64>::new(Method::REFERENCE);
        let all: Vec<([f64; 3], f64)> =
            stacks.iter().flat_map(|s| thicknesses_nm.iter().map(|d| (*s, *d))).collect();
        let points = |&(indices, thickness_nm): &([f64; 3], f64)| -> Vec<Point> {
            let film = film(indices, thickness_nm);
            let point = |angle_deg: f64| {
                let truth = film.map_or([0.0; 3], |film| reference.color(&film, cosine(angle_deg)));
                Point { indices, thickness_nm, angle_deg, truth }
            };
            ANGLES_DEG.map(point).to_vec()
        };
        Self { points: all.par_iter().map(points).collect::<Vec<_>>().concat() }
    }

    /// Films and directions.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Errors of a method in f64 at angles up to `degrees`.
    pub fn errors(&self, method: Method, degrees: f64) -> ColorErrors {
        let mut errors = ColorErrors::default();
        let mut colors: Option<([f64; 3], FilmColor<f64>)> = None;
        for point in self.points.iter().filter(|p| p.angle_deg <= degrees) {
            // A table is of one film.
            let fits = |at: &([f64; 3], _)| at.0 == point.indices || !matches!(method, Method::Table(..));
            if !colors.as_ref().is_some_and(fits) {
                colors = Some((point.indices, FilmColor::with_indices(method, point.indices)));
            }
            if let (Some((_, colors)), Some(film)) = (&colors, film(point.indices, point.thickness_nm)) {
                errors.add(colors.color(&film, cosine(point.angle_deg)), point.truth);
            }
        }
        errors
    }

    /// Greatest difference of the truth, over every `nth` point, from [`cie::nodes`], the exact Airy reflectance at four
    /// Gauss nodes in each nanometre, at usual angles (beyond, resonances are too sharp for it); and, at all angles, from
    /// the series to 1e-9.
    pub fn self_convergence(&self, nth: usize) -> (f64, f64) {
        let fine = FilmColor::<f64>::new(Method::Adaptive(1e-9));
        let apart = |a: [f64; 3], b: [f64; 3]| (0..3).fold(0.0f64, |m, c| m.max((a[c] - b[c]).abs()));
        let each: Vec<(f64, f64)> = (self.points.par_iter().step_by(nth.max(1)))
            .filter_map(|p| {
                let (film, cosine) = (film(p.indices, p.thickness_nm)?, cosine(p.angle_deg));
                let quadrature = match p.angle_deg <= USUAL_DEG {
                    true => apart(p.truth, cie::integrate(|l| film.power(cosine, l).reflected)),
                    false => 0.0,
                };
                Some((quadrature, apart(p.truth, fine.color(&film, cosine))))
            })
            .collect();
        each.into_iter().fold((0.0, 0.0), |m, e| (m.0.max(e.0), m.1.max(e.1)))
    }
}

/// A film of the grids; all of them can be.
fn film(indices: [f64; 3], thickness_nm: f64) -> Option<Film<f64>> {
    Film::new(indices[0], indices[1], indices[2], thickness_nm).ok()
}

/// Cosine of an angle, degrees.
pub(super) fn cosine(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

/// Time of one colour in f32 on one thread: default films of 0 to 2400 nm in random directions.
pub fn time(method: Method, rounds: usize) -> Timing {
    let unit = |i: u32| hash::unit(hash::pcg(i));
    let inputs: Vec<(Film<f32>, f32)> = (0..4096)
        .filter_map(|i| {
            let [n0, n1, n2] = DEFAULT_INDICES.map(|n| n as f32);
            Some((Film::new(n0, n1, n2, 2400.0 * unit(2 * i)).ok()?, unit(2 * i + 1)))
        })
        .collect();
    let colors = FilmColor::<f32>::new(method);
    timing::per_evaluation(&inputs, rounds, |(film, cosine)| colors.color(film, *cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published for this choice of stacks and of numbers of thicknesses and angles, which are not told: RMS errors up to
    /// 76 degrees over all stacks, and of the default film at all angles.
    #[test]
    fn methods_have_their_published_errors() {
        let published = [
            (Method::Three(THESIS_NM), 6.1e-2, 3.1e-2),
            (Method::Three(BEST_NM), 4.7e-2, 2.4e-2),
            (Method::Uniform(16), 1.2e-2, 4.7e-3),
            (Method::BelcourGltf, 3.0e-2, 2.3e-2),
            (Method::Belcour, 6.5e-3, 3.2e-3),
            (Method::BelcourWhite, 3.9e-3, 2.0e-3),
            (Method::Series(1), 7.3e-3, 1.8e-3),
            (Method::Series(2), 2.5e-3, 1.8e-4),
            (Method::Series(3), 9.6e-4, 2.3e-5),
            (Method::Series(4), 4.0e-4, 3.2e-6),
            (Method::Series(6), 8.6e-5, f64::NAN),
        ];
        let (all, default) =
            (Grid::new(&stacks(), &thin_nm(66)), Grid::new(&[DEFAULT_INDICES], &thin_nm(66)));
        assert_eq!(all.len(), 14_256);
        for (method, thin, snake) in published {
            let near = |ours: f64, published: f64| published.is_nan() || (ours / published - 1.0).abs() < 0.2;
            let ours = (all.errors(method, USUAL_DEG).rmse(), default.errors(method, 90.0).rmse());
            assert!(near(ours.0, thin) && near(ours.1, snake), "{method}: {ours:?}");
        }
    }

    #[test]
    fn the_truth_agrees_with_integration() {
        let (quadrature, series) = Grid::new(&stacks(), &thin_nm(7)).self_convergence(11);
        assert!(quadrature < 1e-6 && series < 2e-7, "{quadrature:e} {series:e}");
        assert!(quadrature > 0.0);
    }
}
