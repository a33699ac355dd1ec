//! How a spectrum becomes a colour: CIE illuminant D65, the 1931 2-degree observer, linear sRGB.
//!
//! Data: `data/d65_cmf_1nm.csv`, the CIE tables (CIE 015:2018; D65 from 5 nm, observer at 1 nm) from 360 to 830 nm. Both are
//! linear between whole nanometres, so their product, the weight, is piecewise quadratic and [`integrate`] is exact for it.
//! The matrix is that of IEC 61966-2-1 with four digits; each channel is then divided by what a perfect reflector gives,
//! hence reflectance 1 is exactly (1, 1, 1). Nothing is clamped: saturated film colours have negative channels.

use std::sync::OnceLock;

/// First wavelength of the data, nm.
pub const FIRST_NM: f64 = 360.0;
/// Last wavelength of the data, nm.
pub const LAST_NM: f64 = 830.0;

/// XYZ to linear sRGB (IEC 61966-2-1:1999).
pub const XYZ_TO_SRGB: [[f64; 3]; 3] =
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

/// The tables at one wavelength.
#[derive(Clone, Copy, Debug)]
struct Row {
    d65: f64,
    xyz: [f64; 3],
}

/// Tables at every whole nanometre from [`FIRST_NM`] to [`LAST_NM`].
fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let numbers = |line: &str| -> Vec<f64> {
            line.split(',').map(|word| word.trim().parse().expect("the embedded table has numbers")).collect()
        };
        include_str!("data/d65_cmf_1nm.csv")
            .lines()
            .filter(|line| !line.starts_with('#') && !line.is_empty())
            .map(numbers)
            .map(|n| Row { d65: n[1], xyz: [n[2], n[3], n[4]] })
            .collect()
    })
}

/// Illuminant times observer, XYZ not normalised, at a wavelength, nm: linear between whole ones; 0 outside the data.
fn weighted_observer(wavelength_nm: f64) -> [f64; 3] {
    let rows = rows();
    let position = wavelength_nm - FIRST_NM;
    if !(0.0..=LAST_NM - FIRST_NM).contains(&position) {
        return [0.0; 3];
    }
    let i = (position as usize).min(rows.len() - 2);
    let t = position - i as f64;
    std::array::from_fn(|j| {
        let [a, b] = [i, i + 1].map(|i| rows[i].d65 * rows[i].xyz[j]);
        a + (b - a) * t
    })
}

fn to_srgb(xyz: [f64; 3]) -> [f64; 3] {
    XYZ_TO_SRGB.map(|row| row.iter().zip(xyz).map(|(m, x)| m * x).sum())
}

/// Nodes and weights of the Gauss-Legendre rule of order 4 on [0, 1] (Abramowitz & Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_13, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// A wavelength with the part of the integral over all wavelengths that it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Weight for linear red, green, blue: `W_c(lambda) d lambda`.
    pub rgb: [f64; 3],
}

/// The rule of all intervals of 1 nm with four nodes each: `int W_c(lambda) f(lambda) d lambda` for any `f` that is smooth
/// within each nanometre; the weights of each channel sum to 1.
///
/// `W_c = sum_j M_cj D65 xyz_j / (k white_c)` with `k = int D65 ybar` and `white_c` the channel of a perfect reflector.
pub fn nodes() -> &'static [Node] {
    static NODES: OnceLock<Vec<Node>> = OnceLock::new();
    NODES.get_or_init(|| {
        let mut nodes = unscaled_nodes();
        let white = white();
        nodes.iter_mut().for_each(|n| n.rgb = std::array::from_fn(|c| n.rgb[c] / white[c]));
        nodes
    })
}

fn unscaled_nodes() -> Vec<Node> {
    (0..rows().len() - 1)
        .flat_map(|i| GAUSS.map(|(t, w)| (FIRST_NM + i as f64 + t, w)))
        .map(|(wavelength_nm, w)| Node {
            wavelength_nm,
            rgb: to_srgb(weighted_observer(wavelength_nm)).map(|c| c * w),
        })
        .collect()
}

/// What a perfect reflector gives, before channels are divided by it.
fn white() -> [f64; 3] {
    static WHITE: OnceLock<[f64; 3]> = OnceLock::new();
    *WHITE.get_or_init(|| sum(&unscaled_nodes()))
}

/// The weight `W_c(lambda)` of [`nodes`], 1/nm, at any wavelength, nm; 0 outside the data.
pub fn weight(wavelength_nm: f64) -> [f64; 3] {
    let (rgb, white) = (to_srgb(weighted_observer(wavelength_nm)), white());
    std::array::from_fn(|c| rgb[c] / white[c])
}

fn sum(nodes: &[Node]) -> [f64; 3] {
    std::array::from_fn(|c| nodes.iter().map(|n| n.rgb[c]).sum())
}

/// Linear sRGB of a reflectance under D65 by [`nodes`].
pub fn integrate(reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    nodes().iter().fold([0.0; 3], |sum, node| {
        let r = reflectance(node.wavelength_nm);
        std::array::from_fn(|c| sum[c] + node.rgb[c] * r)
    })
}

/// `count` wavelengths in the middles of equal parts of `range`, nm, each with the weight at that wavelength; the
/// weights of each channel are scaled to sum to 1. `count` 1 to 4096.
pub fn uniform_nodes(count: usize, range: (f64, f64)) -> Vec<Node> {
    let count = count.clamp(1, 4096);
    let step = (range.1 - range.0) / count as f64;
    let mut nodes: Vec<Node> = (0..count)
        .map(|i| range.0 + (i as f64 + 0.5) * step)
        .map(|l| Node { wavelength_nm: l, rgb: to_srgb(weighted_observer(l)) })
        .collect();
    let white = sum(&nodes);
    nodes.iter_mut().for_each(|n| n.rgb = std::array::from_fn(|c| n.rgb[c] / white[c]));
    nodes
}

/// CIE Lab of linear sRGB; white is (1, 1, 1). Channels below 0 are taken as they are (CIE 015:2018, 8.2.1).
pub fn lab(rgb: [f64; 3]) -> [f64; 3] {
    // Inverse of the matrix of IEC 61966-2-1, rows scaled so that white is (1, 1, 1).
    const M: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    let f = |row: [f64; 3]| {
        let white: f64 = row.iter().sum();
        let t = row.iter().zip(rgb).map(|(m, c)| m * c).sum::<f64>() / white;
        let knee = 6.0f64 / 29.0;
        if t > knee.powi(3) { libm::cbrt(t) } else { t / (3.0 * knee * knee) + 4.0 / 29.0 }
    };
    let [x, y, z] = M.map(f);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Colour difference CIEDE2000 of two Lab colours (CIE 142:2001; Sharma, Wu, Dalal 2005, eq. 2 to 22), kL = kC = kH = 1.
pub fn delta_e_2000(one: [f64; 3], two: [f64; 3]) -> f64 {
    let pow7 = |c: f64| c.powi(7);
    let root7 = |c: f64| (pow7(c) / (pow7(c) + pow7(25.0))).sqrt();
    let chroma = |[_, a, b]: [f64; 3]| libm::hypot(a, b);
    let g = 0.5 * (1.0 - root7((chroma(one) + chroma(two)) * 0.5));
    let polar = |[l, a, b]: [f64; 3]| {
        let a = a * (1.0 + g);
        let hue = if a == 0.0 && b == 0.0 { 0.0 } else { libm::atan2(b, a).to_degrees().rem_euclid(360.0) };
        (l, libm::hypot(a, b), hue)
    };
    let ((l1, c1, h1), (l2, c2, h2)) = (polar(one), polar(two));
    let gray = c1 * c2 == 0.0;
    let turn = h2 - h1;
    let dh = match turn {
        _ if gray => 0.0,
        t if t > 180.0 => t - 360.0,
        t if t < -180.0 => t + 360.0,
        t => t,
    };
    let sin = |degrees: f64| libm::sin(degrees.to_radians());
    let cos = |degrees: f64| libm::cos(degrees.to_radians());
    let (dl, dc, dh) = (l2 - l1, c2 - c1, 2.0 * (c1 * c2).sqrt() * sin(dh * 0.5));
    let (l, c) = ((l1 + l2) * 0.5, (c1 + c2) * 0.5);
    let h = match h1 + h2 {
        sum if gray => sum,
        sum if turn.abs() <= 180.0 => sum * 0.5,
        sum if sum < 360.0 => (sum + 360.0) * 0.5,
        sum => (sum - 360.0) * 0.5,
    };
    let t = 1.0 - 0.17 * cos(h - 30.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + 6.0)
        - 0.20 * cos(4.0 * h - 63.0);
    let l50 = (l - 50.0).powi(2);
    let (sl, sc, sh) = (1.0 + 0.015 * l50 / (20.0 + l50).sqrt(), 1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let rotation = 60.0 * libm::exp(-((h - 275.0) / 25.0).powi(2));
    let rt = -2.0 * root7(c) * sin(rotation);
    let (dl, dc, dh) = (dl / sl, dc / sc, dh / sh);
    (dl * dl + dc * dc + dh * dh + rt * dc * dh).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_data_are_471_rows_and_white_is_the_stated_one() {
        assert_eq!(rows().len(), 471);
        let k: f64 = GAUSS
            .iter()
            .flat_map(|&(t, w)| (0..470).map(move |i| w * weighted_observer(FIRST_NM + f64::from(i) + t)[1]))
            .sum();
        let white = GAUSS
            .iter()
            .flat_map(|&(t, w)| {
                (0..470).map(move |i| weighted_observer(FIRST_NM + f64::from(i) + t).map(|x| x * w))
            })
            .fold([0.0; 3], |s: [f64; 3], x| std::array::from_fn(|j| s[j] + x[j] / k));
        for (w, stated) in to_srgb(white).into_iter().zip([1.00000546, 1.00007547, 0.99983145]) {
            assert!((w - stated).abs() < 1e-8, "{w} {stated}");
        }
    }

    #[test]
    fn a_perfect_reflector_is_white() {
        for c in integrate(|_| 1.0) {
            assert!((c - 1.0).abs() < 1e-13);
        }
        for nodes in [uniform_nodes(16, (380.0, 780.0)), uniform_nodes(64, (380.0, 780.0))] {
            for c in sum(&nodes) {
                assert!((c - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn differences_are_those_of_the_published_test_pairs() {
        // Sharma, Wu, Dalal 2005, table 1: pairs 1, 7, 14, 17, 20.
        let pairs = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ];
        for (a, b, e) in pairs {
            assert!((delta_e_2000(a, b) - e).abs() < 5e-5, "{} {e}", delta_e_2000(a, b));
            assert!((delta_e_2000(b, a) - e).abs() < 5e-5);
        }
        let [l, a, b] = lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-12 && a.abs() < 1e-12 && b.abs() < 1e-12);
    }
}
