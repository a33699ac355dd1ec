//! The orders of a grating as tables: what `gloss_grating.wgsl` reads.
//!
//! A light's colour on ridges is an integral over wavelengths, `f = int w(l) R(l) sum_m e_m(l) D(h_m(l)) ...`, where D may be
//! far narrower than the way that `h_m` goes between two wavelengths of a sum: each would make its own spot. But along g D is
//! `k(u) = 1/(u^2 + c^2)^2` of the distance u, which is linear in the wavelength, and all else is smooth. So that is taken
//! as linear between wavelengths, and the integral of k over each of those tents is exact,
//!
//! ```text
//! (F(u + w) - 2 F(u) + F(u - w))/w^2,   F(u) = u atan(u/c)/(2 c^3),   F'' = k
//! ```
//!
//! with w the way of `v_m` between two wavelengths: spectra have no gaps at any roughness.
//!
//! Shares are those of [`crate::optics::grating`]. They jump where an order sets, which a table over directions would blur.
//! All directions that exchange light lie in a row, in steps of `lambda/P`, the outermost two less than a step from the
//! horizon. By how many there are, and by the roots of those two distances, shares are smooth: so are the tables.
//!
//! Mean errors against `optics` by 800 wavelengths in f64, of lights near the spectra, as shares of their greatest channel;
//! `cargo test --lib gratings_are -- --nocapture` tells them:
//!
//! | Period, height, nm | Roughness | 8 | 16 | 32 wavelengths | Sum over 32 (`optics` in RGB) |
//! | --- | --- | --- | --- | --- | --- |
//! | 1000, 60 | 0.1 to 0.7 | 0.060 | 0.016 | 0.006 | 0.008 |
//! | 1000, 60 | 0.05 to 0.1 | 0.122 | 0.045 | 0.015 | 0.127 |
//! | 700, 120 | 0.1 to 0.7 | 0.102 | 0.040 | 0.015 | 0.015 |
//! | 250, 100 | 0.1 to 0.7 | 0.022 | 0.005 | 0.001 | 0.003 |
//! | 2200, 40 | 0.1 to 0.7 | 0.037 | 0.009 | 0.004 | 0.001 |
//!
//! What is an approximation beside: lobes of less than 1e-3 are left out; a small light's width spreads all orders as it does
//! a mirror's; light from all around is asked for in the direction of each order as far as the lobe is wide, and
//! reflected by the film as in the middle of that lobe; where it is the same everywhere, orders change nothing, as shares sum to 1.

use rayon::prelude::*;

use super::material::Table;
use crate::optics::film_color::UNIFORM_NM;
use crate::optics::grating::{Grating, Ridges};
use crate::optics::{FilmError, cie};

/// Most texels of shares: 2 MiB.
const MOST_TEXELS: usize = 1 << 17;
/// Patches along each side of a table of shares, at least and at most.
const PATCHES: (usize, usize) = (4, 24);

/// The tables of a grating at so many wavelengths; none where it has no height.
///
/// `order_nodes` has a column for each wavelength, `(nm, weights in red, green, blue)` over `(lambda/P, first row of its
/// shares, step of lambda/P, 0)`; in the last one is `(g, patches along a side, 0)`. `order_shares` has a row for each pair of
/// each number of directions, `Ridges::exchanged`, and in it bilinear patches of four corners.
///
/// # Errors
/// If the grating is out of range.
pub fn tables(grating: &Grating, count: u32) -> Result<Vec<Table>, FilmError> {
    let Some(ridges) = Ridges::<f64>::new(grating)? else { return Ok(Vec::new()) };
    let nodes = cie::uniform_nodes(count as usize, UNIFORM_NM);
    let step = (UNIFORM_NM.1 - UNIFORM_NM.0) / f64::from(count) / f64::from(grating.period_nm);
    // Wavelengths, and how many directions.
    let chains: Vec<Vec<(f64, usize)>> = nodes
        .iter()
        .map(|n| (1..=ridges.steps(n.wavelength_nm).1).map(|length| (n.wavelength_nm, length)).collect())
        .collect();
    let rows_of = |chains: &[(f64, usize)]| chains.iter().map(|(_, n)| n * (n + 1) / 2).sum::<usize>();
    let rows: usize = chains.iter().map(|c| rows_of(c)).sum();
    let patches = (MOST_TEXELS / rows.max(1)).isqrt().clamp(PATCHES.0, PATCHES.1);
    let (mut top, mut below, mut first) = (Vec::new(), Vec::new(), 0);
    for (node, chains) in nodes.iter().zip(&chains) {
        let [r, g, b] = node.rgb;
        let (shift, _) = ridges.steps(node.wavelength_nm);
        top.push([node.wavelength_nm, r, g, b].map(|x| x as f32));
        below.push([shift as f32, first as f32, step as f32, 0.0]);
        first += rows_of(chains);
    }
    let [x, y] = ridges.across();
    top.push([x as f32, y as f32, patches as f32, 0.0]);
    below.push([0.0; 4]);
    let width = top.len() as u32;
    top.extend(below);
    let texels: Vec<Vec<[f32; 4]>> =
        chains.concat().into_par_iter().map(|(nm, length)| chain(&ridges, nm, length, patches)).collect();
    let square = (patches * patches) as u32;
    Ok(vec![
        Table { name: "order_nodes", binding: 6, width, texels: top },
        Table { name: "order_shares", binding: 7, width: square, texels: texels.concat() },
    ])
}

/// The rows of so many directions: patches by the last direction's distance, then by the first one's.
fn chain(ridges: &Ridges<f64>, nm: f64, length: usize, patches: usize) -> Vec<[f32; 4]> {
    let end = |i: usize| (i as f64 / patches as f64).powi(2);
    let corner = |i: usize, j: usize| ridges.exchanged(nm, length, [end(i), end(j)]);
    let corners: Vec<Vec<f64>> =
        (0..=patches).flat_map(|j| (0..=patches).map(move |i| (i, j))).map(|(i, j)| corner(i, j)).collect();
    let pairs = length * (length + 1) / 2;
    let at = |pair: usize, i: usize, j: usize| corners[j * (patches + 1) + i][pair] as f32;
    (0..pairs)
        .flat_map(|pair| (0..patches * patches).map(move |cell| (pair, cell % patches, cell / patches)))
        .map(|(pair, i, j)| [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| at(pair, i, j)))
        .collect()
}
