//! From colours to spectra and back: reflectance spectra of RGB colours, and wavelengths for a path.
//!
//! A colour becomes `r b_R + g b_G + b b_B` of three fixed spectra, each in [0, 1], which sum to 1 (Mallett & Yuksel 2019,
//! Spectral Primary Decomposition for Rendering with sRGB Reflectance): linear, so that nothing is computed per texel, and
//! exact both ways under the weights of [`super::cie`]. Data: `data/rgb_basis_5nm.csv` says how it was made.
//!
//! Wavelengths of a path are drawn from a density near `sqrt(sum_c W_c^2)`, blurred by 20 nm: of those tried the one whose
//! colours vary least at four wavelengths (see [`Wavelengths::sample`]).

use std::sync::OnceLock;

use super::cie::{self, FIRST_NM};

/// Distance of two entries of the basis, nm.
const STEP_NM: f32 = 5.0;
/// Entries of the guide to the density.
const GUIDES: usize = 1024;
/// Width of the blur of the density, nm (standard deviation).
const BLUR_NM: f64 = 20.0;

#[inline(always)]
fn basis_table() -> &'static [[f32; 3]] {
    static TABLE: OnceLock<Vec<[f32; 3]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        include_str!("data/rgb_basis_5nm.csv")
            .lines()
            .filter(|line| !line.starts_with('#') && !line.is_empty())
            .map(|line| {
                let mut words =
                    line.split(',').map(|w| w.trim().parse().expect("the embedded table has numbers"));
                std::array::from_fn(|i| {
                    // The wavelength comes first.
                    let skip = usize::from(i == 0);
                    words.nth(skip).expect("the embedded table has four columns")
                })
            })
            .collect()
    })
}

/// Reflectance of the red, the green and the blue basis surface at a wavelength, nm; beyond 360 to 830 nm that of the end.
///
/// Each in [0, 1]; they sum to 1.
#[inline(always)]
pub fn basis(wavelength_nm: f32) -> [f32; 3] {
    let table = basis_table();
    let last = (table.len() - 1) as f32;
    let place = ((wavelength_nm - FIRST_NM as f32) * (1.0 / STEP_NM)).max(0.0).min(last);
    // Signed and of 32 bits: one instruction.
    let i = (place as i32 as usize).min(table.len() - 2);
    let t = place - i as f32;
    std::array::from_fn(|c| table[i][c] + (table[i + 1][c] - table[i][c]) * t)
}

/// A spectrum whose colour under D65 is `rgb`, linear sRGB, at N wavelengths, nm: for albedo, and for any other quantity
/// that is given for red, green and blue. In [0, 1] if `rgb` is; linear in it.
#[inline(always)]
pub fn upsample<const N: usize>(rgb: [f32; 3], wavelengths_nm: &[f32; N]) -> [f32; N] {
    wavelengths_nm.map(|l| {
        let b = basis(l);
        b[0] * rgb[0] + b[1] * rgb[1] + b[2] * rgb[2]
    })
}

/// One nanometre of the density of wavelengths, which is constant over it: one line of memory.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Cell {
    /// Probability below it.
    below: f64,
    /// 1 over the density, nm.
    width: f64,
    /// At its start: weights of red, green, blue over the density, then the basis of red, green, blue.
    start: [f32; 6],
    /// How much more they are at its end: all are linear between whole nanometres.
    more: [f32; 6],
}

/// The density of wavelengths.
struct Density {
    cells: Vec<Cell>,
    /// Probability below each cell, side by side: few lines of memory are searched.
    below: Vec<f64>,
    /// The cell where each of equal parts of the probability begins: from there a step or two find the right one (Chen &
    /// Asau 1974, guide tables).
    guide: [u16; GUIDES],
}

impl Density {
    fn new() -> Self {
        let parts: Vec<f64> = cie::nodes()
            .chunks(4)
            .map(|nodes| {
                let sum = |c: usize| nodes.iter().map(|n| n.rgb[c]).sum::<f64>();
                (0..3).map(|c| sum(c).powi(2)).sum::<f64>().sqrt()
            })
            .collect();
        let blurred: Vec<f64> = (0..parts.len())
            .map(|i| {
                let part = |(j, p): (usize, &f64)| {
                    let x = (i as f64 - j as f64) / BLUR_NM;
                    libm::exp(-0.5 * x * x) * p
                };
                parts.iter().enumerate().map(part).sum::<f64>()
            })
            .collect();
        let total: f64 = blurred.iter().sum();
        let mut below = 0.0;
        let cells: Vec<Cell> = blurred
            .iter()
            .enumerate()
            .map(|(i, part)| {
                let density = part / total;
                let at = |k: usize| {
                    let nm = FIRST_NM + (i + k) as f64;
                    let ([r, g, b], [x, y, z]) = (cie::weight(nm).map(|w| w / density), basis(nm as f32));
                    [r as f32, g as f32, b as f32, x, y, z]
                };
                let (start, end) = (at(0), at(1));
                let more = std::array::from_fn(|c| end[c] - start[c]);
                let cell = Cell { below, width: 1.0 / density, start, more };
                below += density;
                cell
            })
            .collect();
        let guide = std::array::from_fn(|k| {
            let u = k as f64 / GUIDES as f64;
            (cells.partition_point(|c| c.below <= u).max(1) - 1) as u16
        });
        Self { below: cells.iter().map(|c| c.below).collect(), cells, guide }
    }

    #[inline(always)]
    fn shared() -> &'static Self {
        static DENSITY: OnceLock<Density> = OnceLock::new();
        DENSITY.get_or_init(Self::new)
    }

    /// The wavelength below which the part `u` in [0, 1) of the probability is, nm, and there the weights over the density
    /// and the basis.
    #[inline(always)]
    fn invert(&self, u: f64) -> (f64, [f32; 6]) {
        let bucket = (u * GUIDES as f64) as i32;
        let mut i = usize::from(self.guide[bucket.clamp(0, GUIDES as i32 - 1) as usize]);
        while self.below.get(i + 1).is_some_and(|next| *next <= u) {
            i += 1;
        }
        let cell = &self.cells[i];
        let t = ((u - cell.below) * cell.width).max(0.0).min(1.0);
        let nm = FIRST_NM + f64::from(i as i32) + t;
        (nm, std::array::from_fn(|c| cell.start[c] + cell.more[c] * t as f32))
    }
}

/// N wavelengths that a path carries, and what each counts for in its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelengths<const N: usize> {
    /// Wavelengths, nm, 360 to 830.
    pub nm: [f32; N],
    /// Weights of linear red, green, blue: `sum_i rgb_weights[i] L(nm[i])` estimates the colour of a spectrum `L` relative
    /// to D65 (1 everywhere is white).
    pub rgb_weights: [[f32; 3]; N],
    /// What [`basis`] is at each.
    pub basis: [[f32; 3]; N],
}

impl<const N: usize> Wavelengths<N> {
    /// Wavelengths by one uniform number in [0, 1): evenly spaced in probability and turned together.
    ///
    /// Without bias: over all `u` the mean of a colour is exact. Standard deviation of one draw, mean of channels: white
    /// 0.12 and saturated films (scaled to 1) 0.10 with four wavelengths, 0.05 and 0.03 with eight; 0.28 and 0.16 with four
    /// from `sqrt(sum W^2)` itself, 0.69 and 0.46 from even wavelengths. Weights cannot be scaled so that each draw has
    /// white exactly: that would be biased.
    #[inline(always)]
    pub fn sample(u: f32) -> Self {
        let density = Density::shared();
        let drawn: [_; N] = std::array::from_fn(|i| {
            // Into [0, 1) without `floor`, which would be a call on plain x86-64.
            let turned = f64::from(u) + f64::from(i as i32) / N as f64;
            let part = turned - f64::from(turned as i32);
            density.invert(if part < 0.0 { part + 1.0 } else { part })
        });
        let over = 1.0 / N.max(1) as f32;
        Self {
            nm: drawn.map(|(l, _)| l as f32),
            rgb_weights: drawn.map(|(_, [r, g, b, ..])| [r * over, g * over, b * over]),
            basis: drawn.map(|(_, [.., x, y, z])| [x, y, z]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_being_spectra() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, 0.2, 0.05], [1.0; 3]] {
            let back = cie::integrate(|l| f64::from(upsample(rgb, &[l as f32])[0]));
            for c in 0..3 {
                assert!((back[c] - f64::from(rgb[c])).abs() < 1e-5, "{rgb:?} {back:?}");
            }
        }
        // The control: the same spectra moved by 5 nm.
        let moved = cie::integrate(|l| f64::from(upsample([1.0, 0.0, 0.0], &[l as f32 + 5.0])[0]));
        assert!((moved[0] - 1.0).abs() > 1e-2);
    }

    #[test]
    fn the_basis_is_between_0_and_1_and_sums_to_1() {
        assert_eq!(basis_table().len(), 95);
        for i in 0..10_000u16 {
            let b = basis(300.0 + f32::from(i) * 0.06);
            assert!(b.iter().all(|b| (0.0..=1.0).contains(b)), "{b:?}");
            assert!((b.iter().sum::<f32>() - 1.0).abs() < 3e-7);
        }
        assert_eq!(basis(f32::NAN), basis(360.0));
    }

    #[test]
    fn wavelengths_estimate_colours_without_bias() {
        let film = crate::optics::Film::new(1.0, 1.55, 2.0, 400.0).expect("a film");
        let spectra: [&dyn Fn(f64) -> f64; 3] = [&|_| 1.0, &|l| film.power(1.0, l).reflected, &|l| {
            f64::from(upsample([0.8, 0.1, 0.3], &[l as f32])[0])
        }];
        for spectrum in spectra {
            let exact = cie::integrate(spectrum);
            let n = 2000u16;
            let (mut mean, mut square) = ([0.0; 3], 0.0);
            for i in 0..n {
                let drawn = Wavelengths::<4>::sample((f32::from(i) + 0.5) / f32::from(n));
                let mut rgb = [0.0; 3];
                for (l, w) in drawn.nm.into_iter().zip(drawn.rgb_weights) {
                    let value = spectrum(f64::from(l));
                    (0..3).for_each(|c| rgb[c] += f64::from(w[c]) * value);
                }
                for c in 0..3 {
                    mean[c] += rgb[c] / f64::from(n);
                    square += (rgb[c] - exact[c]).powi(2) / f64::from(n) / 3.0;
                }
            }
            println!("exact {exact:?}, standard deviation {:.3}", square.sqrt());
            for c in 0..3 {
                assert!((mean[c] - exact[c]).abs() < 2e-4, "{mean:?} {exact:?}");
            }
            assert!(square.sqrt() < 0.15);
        }
    }

    #[test]
    fn the_guide_leads_to_where_a_search_does() {
        let density = Density::shared();
        for k in 0..200_000 {
            let u = f64::from(k) / 200_000.0;
            let i = density.cells.partition_point(|c| c.below <= u).max(1) - 1;
            let cell = &density.cells[i];
            let (l, values) = density.invert(u);
            let expected = FIRST_NM + i as f64 + (u - cell.below) * cell.width;
            assert!((l - expected).abs() < 1e-9, "{u}: {l} {expected}");
            let weight = cie::weight(l);
            (0..3).for_each(|c| assert!((f64::from(values[c]) - weight[c] * cell.width).abs() < 1e-6));
            (0..3).for_each(|c| assert!((values[3 + c] - basis(l as f32)[c]).abs() < 1e-5, "{l}"));
        }
    }

    #[test]
    fn the_ends_of_chance_are_in_range() {
        for u in [0.0, 1.0 - f32::EPSILON / 2.0, 1.0, -0.5, f32::NAN] {
            let drawn = Wavelengths::<8>::sample(u);
            assert!(drawn.nm.iter().all(|l| (360.0..=830.0).contains(l)), "{u}: {drawn:?}");
            assert!(drawn.rgb_weights.iter().flatten().all(|w| w.is_finite()));
        }
    }
}
