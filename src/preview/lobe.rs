//! The lobe of a rough surface as three mirrors: what gloss does to light from all around.
//!
//! Even light on microfacets comes back as `E = int w(c) R(c) dc`, with the weight w of cosines c to the facets that a view
//! sees. Split sums take R out of the integral by Schlick's form, which a film does not have. But w has nothing to do with
//! the film, and R is smooth: Gauss's rule of three nodes for the weight w,
//!
//! ```text
//! E = w1 R(c1) + w2 R(c2) + w3 R(c3)
//! ```
//!
//! is exact for polynomials up to c^5, so that one small table of nodes over view and roughness serves every film,
//! thickness and footprint. Source: Golub & Welsch 1969 (Calculation of Gauss Quadrature Rules), with the recurrence by
//! Stieltjes's procedure.

use rayon::prelude::*;

use crate::optics::layered::LEAST_ROUGHNESS;
use crate::optics::{Film, FilmColor, energy, ggx};

/// Cosines of the table: squares of even steps, so that they crowd where the view grazes.
pub const COSINES: usize = 32;
/// Roughnesses of the table: even steps.
pub const ROUGHNESSES: usize = 32;
/// Points of the rules that the lobe is integrated by.
const POINTS: usize = 12;

/// A node: its weight, and the cosine to the facet that it stands for.
pub type Node = (f64, f64);

/// The three mirrors of a lobe of `alpha` > 0 seen at `cosine`, limited to [0, 1]: weights and cosines, ascending.
pub fn nodes(alpha: f64, cosine: f64) -> [Node; 3] {
    let mut points = Vec::with_capacity(2 * POINTS * POINTS);
    energy::visit_lobe(alpha, cosine, POINTS, |c, weight| points.push((weight, c)));
    gauss_rule(&points)
}

/// Gauss's rule of three nodes for a sum of points: exact for polynomials of degree 5.
fn gauss_rule(points: &[Node]) -> [Node; 3] {
    // Orthogonal polynomials p(k+1) = (x - a[k]) p(k) - b[k] p(k-1), by their values at the points.
    let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
    let (mut before, mut now) = (vec![0.0; points.len()], vec![1.0; points.len()]);
    let (mut norm_before, mut total) = (1.0, 0.0);
    for k in 0..3 {
        let moment = |f: &dyn Fn(f64) -> f64| -> f64 {
            points.iter().zip(&now).map(|((w, x), p): (&Node, &f64)| w * f(*x) * p * p).sum()
        };
        let norm = moment(&|_| 1.0);
        if k == 0 {
            total = norm;
        } else {
            b[k] = norm / norm_before;
        }
        a[k] = moment(&|x| x) / norm;
        for ((p, q), (_, x)) in now.iter_mut().zip(&mut before).zip(points) {
            (*p, *q) = ((x - a[k]) * *p - b[k] * *q, *p);
        }
        norm_before = norm;
    }
    let values = |x: f64| {
        let p1 = x - a[0];
        let p2 = (x - a[1]) * p1 - b[1];
        [p1, p2, (x - a[2]) * p2 - b[2] * p1]
    };
    // Roots of the third lie between those of the second and the ends.
    let middle = 0.5 * (a[0] + a[1]);
    let apart = (0.25 * (a[0] - a[1]) * (a[0] - a[1]) + b[1]).sqrt();
    let ends = [0.0, middle - apart, middle + apart, 1.0];
    std::array::from_fn(|i| {
        let (mut lo, mut hi) = (ends[i], ends[i + 1]);
        let sign = if i == 1 { -1.0 } else { 1.0 };
        for _ in 0..50 {
            let x = 0.5 * (lo + hi);
            if values(x)[2] * sign > 0.0 { hi = x } else { lo = x }
        }
        let x = 0.5 * (lo + hi);
        let [p1, p2, _] = values(x);
        (total / (1.0 + p1 * p1 / b[1] + p2 * p2 / (b[1] * b[2])), x)
    })
}

/// The table: for each roughness a row, for each cosine two texels `(w1, s1, w2, s2)` and `(w3, s3, 0, 0)`, where s is the
/// root of a node's cosine: on a mirror it is linear from entry to entry.
pub fn table() -> Vec<[f32; 4]> {
    let row = |r: usize| {
        let roughness = (r as f64 / (ROUGHNESSES - 1) as f64).max(LEAST_ROUGHNESS);
        (0..COSINES).flat_map(move |i| {
            let cosine = (i as f64 / (COSINES - 1) as f64).powi(2);
            let [one, two, three] = nodes(ggx::alpha(roughness), cosine);
            let texel = |a: Node, b: Node| [a.0, a.1.sqrt(), b.0, b.1.sqrt()].map(|x| x as f32);
            [texel(one, two), texel(three, (0.0, 0.0))]
        })
    };
    let rows: Vec<Vec<_>> = (0..ROUGHNESSES).into_par_iter().map(|r| row(r).collect()).collect();
    rows.concat()
}

/// The nodes at a roughness and a cosine, as the shader interpolates them.
pub fn interpolated(table: &[[f32; 4]], roughness: f64, cosine: f64) -> [Node; 3] {
    let place = |x: f64, count: usize| {
        let at = x.clamp(0.0, 1.0) * (count - 1) as f64;
        let i = (at as usize).min(count - 2);
        (i, at - i as f64)
    };
    let (r, t) = place(roughness, ROUGHNESSES);
    let (i, s) = place(cosine.sqrt(), COSINES);
    let at = |part: usize, c: usize| {
        let texel = |r: usize, i: usize| f64::from(table[(r * COSINES + i) * 2 + part][c]);
        let mix = |r: usize| texel(r, i) * (1.0 - s) + texel(r, i + 1) * s;
        mix(r) * (1.0 - t) + mix(r + 1) * t
    };
    [(0, 0), (0, 2), (1, 0)].map(|(part, c)| (at(part, c), at(part, c + 1).powi(2)))
}

/// How far the mirrors of a table are from the lobe's integral, for even light of 1 in red, green and blue, and that integral.
pub fn error(
    table: &[[f32; 4]],
    colors: &FilmColor<f64>,
    film: &Film<f64>,
    roughness: f64,
    cosine: f64,
) -> ([f64; 3], [f64; 3]) {
    let sum = |points: &[Node]| {
        points.iter().fold([0.0; 3], |sum: [f64; 3], (w, c)| {
            let rgb = colors.color(film, *c);
            std::array::from_fn(|k| sum[k] + w * rgb[k].clamp(0.0, 1.0))
        })
    };
    let mut points = Vec::new();
    energy::visit_lobe(ggx::alpha(roughness), cosine, 24, |c, weight| points.push((weight, c)));
    let (exact, three) = (sum(&points), sum(&interpolated(table, roughness, cosine)));
    (std::array::from_fn(|k| three[k] - exact[k]), exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Method;

    #[test]
    fn the_rule_is_exact_for_the_fifth_power() {
        for (alpha, cosine) in [(0.01, 0.9), (0.09, 0.5), (0.25, 0.1), (1.0, 1.0)] {
            let mut points = Vec::new();
            energy::visit_lobe(alpha, cosine, POINTS, |c, weight| points.push((weight, c)));
            let power = |points: &[Node], n: i32| points.iter().map(|(w, c)| w * c.powi(n)).sum::<f64>();
            let rule = nodes(alpha, cosine);
            for n in 0..6 {
                let (a, b) = (power(&rule, n), power(&points, n));
                assert!((a - b).abs() < 1e-11, "{alpha} {cosine} {n}: {a} {b}");
            }
            assert!(power(&rule, 8) != power(&points, 8));
        }
    }

    /// The least roughness of snakes is about 0.1, see SPECIES; smoother surfaces are worse where they graze.
    #[test]
    fn three_mirrors_are_the_lobe_of_any_film() {
        let (table, colors) = (table(), FilmColor::new(Method::Series(3)));
        for (n2, d) in [(2.0, 0.0), (2.0, 200.0), (2.0, 400.0), (2.0, 1000.0), (2.0, 2400.0), (1.4, 600.0)] {
            let film = Film::new(1.0, 1.55, n2, d).expect("a film");
            let (mut near, mut grazing, mut one) = (0.0f64, 0.0f64, 0.0f64);
            for roughness in [0.1, 0.17, 0.3, 0.5, 0.8, 1.0] {
                for i in 0..40 {
                    let cosine = (f64::from(i) + 0.5) / 40.0;
                    let (e, exact) = error(&table, &colors, &film, roughness, cosine);
                    let worst = e.iter().fold(0.0f64, |m, e| m.max(e.abs()));
                    let to = if cosine > 0.3 { &mut near } else { &mut grazing };
                    *to = to.max(worst);
                    // The control: one mirror in the middle.
                    let white: f64 = nodes(ggx::alpha(roughness), cosine).iter().map(|(w, _)| w).sum();
                    let middle = white * colors.color(&film, cosine)[1];
                    one = one.max((middle - exact[1]).abs());
                }
            }
            println!("n2 {n2}, {d} nm: {near:.5}, grazing {grazing:.5}, one mirror {one:.5}");
            assert!(near < 0.003 && grazing < 0.006 && one > 0.02, "{n2} {d}: {near} {grazing} {one}");
        }
    }
}
