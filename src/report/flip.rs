//! FLIP: how strongly the difference of two pictures is seen when one flips between them.
//!
//! Source: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, FLIP: A Difference Evaluator for
//! Alternating Images (Proc. ACM CGIT 3, 2), for pictures of low dynamic range. Numbers of sections and tables are theirs.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::optics::cie;

/// Pixels of one degree of the field of view: a screen 0.7 m wide of 3840 pixels, seen from 0.7 m (sec. 4.1).
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

/// Pictures that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FlipError {
    /// The number of pixels is not width times height, or there are none.
    #[error("the pictures have {0} and {1} pixels, where width times height is {2}")]
    Size(usize, usize, usize),
}

/// A linear colour, or one of the spaces below.
type Color = [f64; 3];

/// sRGB to XYZ; rows divided by their sums are relative to white.
const RGB_TO_XYZ: [Color; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];
/// Gaussians of the contrast sensitivity (table 1): achromatic, red-green, blue-yellow; `(a, b)`, b in square degrees.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// Exponent of the colour difference (sec. 4.1.3).
const COLOR_EXPONENT: f64 = 0.7;
/// Up to this share of the greatest difference ...
const KNEE: f64 = 0.4;
/// ... goes this share of the range (sec. 4.1.3).
const KNEE_VALUE: f64 = 0.95;
/// Exponent of the difference of features (sec. 4.2.2).
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the detectors of edges and points, degrees (sec. 4.2.1).
const FEATURE_DEG: f64 = 0.082;

/// The FLIP of each pixel, in [0, 1]: 0 is the same, 1 could not be more different.
///
/// Both pictures are rows of linear sRGB, limited to [0, 1] here (NaN is 0); `pixels_per_degree` is usually
/// [`PIXELS_PER_DEGREE`].
pub fn flip(
    reference: &[[f32; 3]],
    test: &[[f32; 3]],
    width: usize,
    pixels_per_degree: f64,
) -> Result<Vec<f32>, FlipError> {
    let height = reference.len().checked_div(width).unwrap_or(0);
    if width * height == 0 || reference.len() != width * height || test.len() != reference.len() {
        return Err(FlipError::Size(reference.len(), test.len(), width * height));
    }
    let [a, b] = [reference, test].map(|picture| Seen::new(picture, width, pixels_per_degree));
    let apart = |a: Color, b: Color| libm::pow(hyab(a, b), COLOR_EXPONENT);
    let greatest = apart(hunt([0.0, 1.0, 0.0]), hunt([0.0, 0.0, 1.0]));
    let knee = KNEE * greatest;
    let pixel = |i: usize| {
        let e = apart(a.colors[i], b.colors[i]);
        let color = if e < knee {
            KNEE_VALUE / knee * e
        } else {
            KNEE_VALUE + (e - knee) / (greatest - knee) * (1.0 - KNEE_VALUE)
        };
        let feature = |a: &[f64], b: &[f64]| (a[i] - b[i]).abs();
        let feature = feature(&a.edges, &b.edges).max(feature(&a.points, &b.points));
        let feature = libm::pow((feature * 0.5f64.sqrt()).min(1.0), FEATURE_EXPONENT);
        libm::pow(color.min(1.0), 1.0 - feature) as f32
    };
    Ok((0..reference.len()).into_par_iter().map(pixel).collect())
}

/// Distance of two colours with Hunt's adjustment (HyAB; sec. 4.1.2).
fn hyab(a: Color, b: Color) -> f64 {
    (a[0] - b[0]).abs() + libm::hypot(a[1] - b[1], a[2] - b[2])
}

/// CIE Lab of linear sRGB, chroma lessened in the dark (sec. 4.1.2).
fn hunt(rgb: Color) -> Color {
    let [l, a, b] = cie::lab(rgb);
    [l, 0.01 * l * a, 0.01 * l * b]
}

fn times(m: &[Color; 3], v: Color) -> Color {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Relative to white: XYZ of white is (1, 1, 1).
fn relative() -> [Color; 3] {
    RGB_TO_XYZ.map(|row| row.map(|v| v / row.iter().sum::<f64>()))
}

fn inverse(m: &[Color; 3]) -> [Color; 3] {
    let minor = |i: usize, j: usize| {
        let [a, b, c, d] = [(i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let det: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / det))
}

/// Linear sRGB to the opponent space YyCxCz (sec. 4.1.1).
fn opponent(rgb: Color, m: &[Color; 3]) -> Color {
    let [x, y, z] = times(m, rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// And back.
fn from_opponent([yy, cx, cz]: Color, inverse: &[Color; 3]) -> Color {
    let y = (yy + 16.0) / 116.0;
    times(inverse, [y + cx / 500.0, y, y - cz / 200.0])
}

/// What the eye makes of a picture.
struct Seen {
    /// After the blur of its contrast sensitivity, with Hunt's adjustment.
    colors: Vec<Color>,
    /// Strength of edges and of points.
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Seen {
    fn new(picture: &[[f32; 3]], width: usize, pixels_per_degree: f64) -> Self {
        let m = relative();
        let back = inverse(&m);
        let limited = |c: &[f32; 3]| c.map(|v| f64::from(v.max(0.0).min(1.0)));
        let opponent: Vec<Color> = picture.iter().map(|c| opponent(limited(c), &m)).collect();
        let channel = |c: usize| -> Vec<f64> { opponent.iter().map(|v| v[c]).collect() };
        let blurred: [Vec<f64>; 3] =
            std::array::from_fn(|c| sensitivity(&channel(c), width, SENSITIVITY[c], pixels_per_degree));
        let colors = (0..picture.len())
            .map(|i| from_opponent([blurred[0][i], blurred[1][i], blurred[2][i]], &back))
            .map(|rgb| hunt(rgb.map(|v| v.clamp(0.0, 1.0))))
            .collect();
        let gray: Vec<f64> = opponent.iter().map(|v| (v[0] + 16.0) / 116.0).collect();
        let [edges, points] = features(&gray, width, pixels_per_degree);
        Self { colors, edges, points }
    }
}

/// Weights of `-radius ..= radius`.
fn kernel(radius: usize, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect()
}

/// Rows by `across`, then columns by `down`; beyond the border the border's value.
fn convolve(plane: &[f64], width: usize, across: &[f64], down: &[f64]) -> Vec<f64> {
    let height = plane.len() / width;
    let near = |i: usize, k: usize, kernel: &[f64], size: usize| {
        (i + k).saturating_sub(kernel.len() / 2).min(size - 1)
    };
    let rows: Vec<f64> = (0..plane.len())
        .into_par_iter()
        .map(|i| {
            let (x, row) = (i % width, i / width * width);
            across.iter().enumerate().map(|(k, w)| w * plane[row + near(x, k, across, width)]).sum()
        })
        .collect();
    (0..plane.len())
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % width, i / width);
            down.iter().enumerate().map(|(k, w)| w * rows[near(y, k, down, height) * width + x]).sum()
        })
        .collect()
}

/// Blur by the contrast sensitivity of a channel, a sum of Gaussians (sec. 4.1.1, eq. 4).
fn sensitivity(plane: &[f64], width: usize, gaussians: &[(f64, f64)], pixels_per_degree: f64) -> Vec<f64> {
    let widest = SENSITIVITY.iter().flat_map(|g| g.iter()).fold(0.0f64, |m, g| m.max(g.1));
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let mut sum = vec![0.0; plane.len()];
    let mut norm = 0.0;
    for (a, b) in gaussians {
        let kernel = kernel(radius, |x| libm::exp(-(PI * x / pixels_per_degree).powi(2) / b));
        let height = a * (PI / b).sqrt();
        norm += height * kernel.iter().sum::<f64>().powi(2);
        for (sum, v) in sum.iter_mut().zip(convolve(plane, width, &kernel, &kernel)) {
            *sum += height * v;
        }
    }
    sum.iter_mut().for_each(|v| *v /= norm);
    sum
}

/// Strength of edges and points: first and second derivatives of a Gaussian (sec. 4.2.1).
fn features(gray: &[f64], width: usize, pixels_per_degree: f64) -> [Vec<f64>; 2] {
    let deviation = 0.5 * FEATURE_DEG * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gauss = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
    let smooth = kernel(radius, gauss);
    let total: f64 = smooth.iter().sum();
    // Positive weights sum to 1, negative ones to -1, over the whole of the two-dimensional kernel.
    let normal = |derivative: Vec<f64>| -> Vec<f64> {
        let side = |sign: f64| total * derivative.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
        let (positive, negative) = (side(1.0), side(-1.0));
        derivative.into_iter().map(|w| w / if w > 0.0 { positive } else { negative }).collect()
    };
    let edge = normal(kernel(radius, |x| -x * gauss(x)));
    let point = normal(kernel(radius, |x| (x * x / (deviation * deviation) - 1.0) * gauss(x)));
    [edge, point].map(|derivative| {
        let across = convolve(gray, width, &derivative, &smooth);
        let down = convolve(gray, width, &smooth, &derivative);
        across.iter().zip(down).map(|(x, y)| libm::hypot(*x, y)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(color: [f32; 3]) -> Vec<[f32; 3]> {
        vec![color; 24 * 16]
    }

    fn mean(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
        let flip = flip(a, b, 24, PIXELS_PER_DEGREE).expect("of one size");
        flip.iter().sum::<f32>() / flip.len() as f32
    }

    #[test]
    fn plain_pictures_have_the_values_of_the_closed_form() {
        let [black, white] = [plain([0.0; 3]), plain([1.0; 3])];
        assert_eq!(mean(&white, &white), 0.0);
        // Greens and blues are furthest apart.
        let [green, blue] = [plain([0.0, 1.0, 0.0]), plain([0.0, 0.0, 1.0])];
        assert!((mean(&green, &blue) - 1.0).abs() < 1e-4);
        // Lightness 100 apart, no chroma; Lab of green (87.73, -86.18, 83.18) and blue (32.30, 79.19, -107.86) is in any
        // table, hence with Hunt's adjustment the greatest distance is 203.3: 0.95 + 0.05 (25.12 - 16.51)/(41.28 - 16.51).
        assert!((mean(&black, &white) - 0.96738).abs() < 2e-4, "{}", mean(&black, &white));
        assert_eq!(mean(&black, &white), mean(&white, &black));
    }

    #[test]
    fn a_picture_has_the_values_of_the_authors_program() {
        // flip-evaluator 1.7 (NVIDIA) of the same pixels, 64 x 48, defaults: mean, first, middle, greatest.
        let linear =
            |v: f64| (if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }) as f32;
        let picture = |shift: usize, step: usize, blue: f64| -> Vec<[f32; 3]> {
            let pixel = |x: usize, y: usize| {
                let checks = ((x + step) / 8 + y / 8) % 2;
                [(x * 4 + shift) as f64 / 255.0, (y * 5) as f64 / 255.0, checks as f64 * blue].map(linear)
            };
            (0..64 * 48).map(|i| pixel(i % 64, i / 64)).collect()
        };
        let wrap = |mut p: Vec<[f32; 3]>| {
            // The last columns of red begin anew.
            p.iter_mut().enumerate().for_each(|(i, c)| {
                if i % 64 * 4 + 9 > 255 {
                    c[0] = linear((i % 64 * 4 + 9 - 256) as f64 / 255.0);
                }
            });
            p
        };
        let flip =
            flip(&picture(0, 0, 1.0), &wrap(picture(9, 1, 0.9)), 64, PIXELS_PER_DEGREE).expect("of one size");
        let mean = flip.iter().map(|v| f64::from(*v)).sum::<f64>() / flip.len() as f64;
        let greatest = flip.iter().copied().fold(0.0f32, f32::max);
        let ours = [mean, f64::from(flip[0]), f64::from(flip[24 * 64 + 32]), f64::from(greatest)];
        for (ours, theirs) in ours.into_iter().zip([0.3114989, 0.0332029, 0.2247695, 0.9774486]) {
            assert!((ours - theirs).abs() < 5e-5, "{ours} {theirs}");
        }
    }

    #[test]
    fn small_differences_are_small_and_edges_count() {
        let gray = plain([0.5; 3]);
        let near = mean(&gray, &plain([0.505; 3]));
        let far = mean(&gray, &plain([0.55; 3]));
        assert!(near > 0.0 && near < far && far < 0.2, "{near} {far}");
        // Stripes of the same mean differ in their edges, too.
        let stripes: Vec<[f32; 3]> = (0..24 * 16).map(|i| [0.45 + 0.1 * (i / 6 % 2) as f32; 3]).collect();
        assert!(mean(&gray, &stripes) > 2.0 * near);
    }

    #[test]
    fn anything_is_within_0_and_1() {
        let wild: Vec<[f32; 3]> =
            (0..24 * 16).map(|i| [f32::NAN, i as f32 * 1e30 - 5e31, (i % 7) as f32 / 3.0]).collect();
        for v in flip(&wild, &plain([0.2; 3]), 24, PIXELS_PER_DEGREE).expect("of one size") {
            assert!((0.0..=1.0).contains(&v));
        }
        assert!(flip(&wild[..5], &wild[..5], 2, PIXELS_PER_DEGREE).is_err());
        assert!(flip(&[], &[], 0, PIXELS_PER_DEGREE).is_err());
        assert_eq!(flip(&wild[..1], &wild[..1], 1, PIXELS_PER_DEGREE).map(|f| f[0]), Ok(0.0));
    }
}
