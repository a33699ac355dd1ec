//! A table of colours of one film, by cosine and thickness: the fastest where a whole scene has one film.

use rayon::prelude::*;

use super::super::real::Real;
use super::super::thin_film::Film;
use super::{FilmColor, Method};

/// Greatest thickness in a table, nm.
pub const TABLE_END_NM: f64 = 2400.0;

/// Colours at even steps of the cosine (0 to 1) and of the thickness (0 to [`TABLE_END_NM`]), linear between.
#[derive(Clone, Debug)]
pub(super) struct Table<F> {
    indices: [F; 3],
    cosines: usize,
    thicknesses: usize,
    /// By thickness, then by cosine.
    colors: Vec<[F; 3]>,
}

impl<F: Real> Table<F> {
    /// Every entry by the reference method; at least two along each side.
    pub(super) fn new(indices: [F; 3], cosines: u16, thicknesses: u16) -> Self {
        let (cosines, thicknesses) = (usize::from(cosines.max(2)), usize::from(thicknesses.max(2)));
        let reference = FilmColor::<f64>::new(Method::REFERENCE);
        let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let row = |j: usize| -> Vec<[F; 3]> {
            let [n0, n1, n2] = indices.map(F::to_f64);
            let film = Film::new(n0, n1, n2, TABLE_END_NM * share(j, thicknesses));
            let color = |i: usize| match &film {
                Ok(film) => reference.color(film, share(i, cosines)).map(F::from_f64),
                // No film has such indices, so nobody asks.
                Err(_) => [F::ZERO; 3],
            };
            (0..cosines).map(color).collect()
        };
        let rows: Vec<Vec<[F; 3]>> = (0..thicknesses).into_par_iter().map(row).collect();
        Self { indices, cosines, thicknesses, colors: rows.concat() }
    }

    /// The colour of a film that the table is of; `None` of others and thicker ones.
    #[inline]
    pub(super) fn at(&self, film: &Film<F>, cosine: F) -> Option<[F; 3]> {
        let share = film.thickness_nm() * F::from_f64(1.0 / TABLE_END_NM);
        if film.indices() != self.indices || share > F::ONE {
            return None;
        }
        let place = |share: F, count: usize| {
            let position = share * F::from_f64((count - 1) as f64);
            let i = position.whole().min(count - 2);
            (i, position - F::from_f64(i as f64))
        };
        let (i, u) = place(cosine.saturate(), self.cosines);
        let (j, v) = place(share, self.thicknesses);
        let row = |j: usize| {
            let (a, b) = (self.colors[j * self.cosines + i], self.colors[j * self.cosines + i + 1]);
            std::array::from_fn::<F, 3, _>(|c| a[c] + (b[c] - a[c]) * u)
        };
        let (a, b) = (row(j), row(j + 1));
        Some(std::array::from_fn(|c| a[c] + (b[c] - a[c]) * v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_exact_at_its_entries_and_for_other_films() {
        let (indices, reference) = ([1.0, 1.55, 2.0], FilmColor::<f64>::new(Method::REFERENCE));
        let colors = FilmColor::with_indices(Method::Table(3, 7), indices);
        let film = |n2: f64, d: f64| Film::new(1.0, 1.55, n2, d).expect("a film");
        for (film, c) in [(film(2.0, 400.0), 0.5), (film(2.0, 2400.0), 1.0), (film(2.0, 0.0), 0.0)] {
            for (a, b) in colors.color(&film, c).into_iter().zip(reference.color(&film, c)) {
                assert!((a - b).abs() < 1e-15, "{a} {b}");
            }
        }
        for (film, c) in [(film(1.9, 410.0), 0.4), (film(2.0, 2401.0), 0.4)] {
            assert_eq!(colors.color(&film, c), reference.color(&film, c));
        }
        // The control: between entries so coarse a table is wrong.
        let between = film(2.0, 600.0);
        assert!((colors.color(&between, 0.8)[0] - reference.color(&between, 0.8)[0]).abs() > 1e-3);
    }
}
