//! Tests of every noise: against the `noise` crate where both define the same, and by properties.

use noise::core::perlin::perlin_2d;
use noise::core::value::value_2d;
use noise::core::worley::{ReturnType, distance_functions, worley_2d};
use noise::permutationtable::NoiseHasher;
use noise::{Billow, Fbm, MultiFractal, NoiseFn, RidgedMulti, Seedable};

use super::*;
use crate::base::{Domain, Plane, hash, num};
use crate::eval::{Input, run_node};
use crate::node::{Assets, Node};

type Distance = fn(&[f64], &[f64]) -> f64;

fn run(node: &dyn Node, domain: &Domain, seed: u32, inputs: &[Input<'_>]) -> Vec<Plane> {
    run_node(node, domain, seed, inputs, &Assets::new(), 7)
}

/// Our lattice hash modulo the periods, as the `noise` crate asks for hashes.
#[derive(Clone, Copy, Debug)]
struct Periodic {
    cells: [isize; 2],
    seed: u32,
    /// Right shift of the hash.
    shift: u32,
}

impl NoiseHasher for Periodic {
    fn hash(&self, at: &[isize]) -> usize {
        let [x, y] = [0, 1].map(|k| at[k].rem_euclid(self.cells[k]) as u32);
        (hash::hash2(hash::pcg(self.seed), y, x) >> self.shift) as usize
    }
}

/// A grid with a pitch that no cell count divides.
fn odd_domain() -> Domain {
    Domain { width: 127, height: 83, girth_mm: 127.0, length_mm: 83.0 }
}

/// The point of a texel in cells.
fn point(domain: &Domain, cells: [u32; 2], x: usize, y: usize) -> [f64; 2] {
    [
        (x as f64 + 0.5) / domain.width as f64 * f64::from(cells[0]),
        (y as f64 + 0.5) / domain.height as f64 * f64::from(cells[1]),
    ]
}

fn assert_near(plane: &Plane, expected: impl Fn(usize, usize) -> f64, tolerance: f64) {
    for y in 0..plane.height() {
        for x in 0..plane.width() {
            let (a, e) = (f64::from(plane.at(x as i64, y as i64)), expected(x, y));
            assert!((a - e).abs() <= tolerance, "({x}, {y}): {a}, expected {e}");
        }
    }
}

#[test]
fn perlin_is_the_noise_crates_but_for_its_scale_and_clamp() {
    let domain = odd_domain();
    for (cells, seed) in [([5, 3], 1), ([16, 9], 2), ([1, 1], 3), ([300, 7], 4)] {
        let node = PerlinNoise { cells_u: cells[0], cells_v: cells[1] };
        let hasher = Periodic { cells: cells.map(|c| c as isize), seed, shift: 0 };
        let ours = &run(&node, &domain, seed, &[])[0];
        let root2 = std::f64::consts::SQRT_2;
        let expected = |x, y| perlin_2d(point(&domain, cells, x, y).into(), &hasher);
        // The crate multiplies by sqrt 2 and clamps; where it clamps we cannot compare values, only the side.
        let shown = Plane::from_fn(domain.width, domain.height, |x, y| {
            (((f64::from(ours.at(x as i64, y as i64)) - 0.5) * 2.0 * root2).clamp(-1.0, 1.0)) as f32
        });
        assert_near(&shown, expected, 1e-4);
    }
}

#[test]
fn value_is_the_noise_crates() {
    let domain = odd_domain();
    for (cells, seed) in [([5, 3], 1), ([16, 9], 2), ([1, 2], 3)] {
        let node = ValueNoise { cells_u: cells[0], cells_v: cells[1] };
        let hasher = Periodic { cells: cells.map(|c| c as isize), seed, shift: 8 };
        let ours = &run(&node, &domain, seed, &[])[0];
        // The crate takes hashes of 0 to 255 as [-1, 1]; ours have 24 bits.
        let expected = |x, y| {
            let v = value_2d(point(&domain, cells, x, y).into(), &hasher);
            (v + 1.0) * 0.5 * 255.0 / 16_777_216.0
        };
        assert_near(ours, expected, 2e-5);
    }
}

#[test]
fn worley_without_jitter_is_the_noise_crates_with_its_points_on_the_lattice() {
    struct Still;
    impl NoiseHasher for Still {
        fn hash(&self, _: &[isize]) -> usize {
            0
        }
    }
    let domain = odd_domain();
    let cells = [11, 6];
    let metrics: [(Metric, Distance); 3] = [
        (Metric::Euclidean, distance_functions::euclidean),
        (Metric::Manhattan, distance_functions::manhattan),
        (Metric::Chebyshev, distance_functions::chebyshev),
    ];
    for (metric, distance) in metrics {
        let node = Worley { cells_u: cells[0], cells_v: cells[1], metric, jitter: 0.0 };
        let ours = &run(&node, &domain, 1, &[])[0];
        let expected = |x, y| {
            // Its unmoved points lie at lattice points, ours at the centres of cells.
            let p = point(&domain, cells, x, y).map(|t| t + 0.5);
            (worley_2d(&Still, distance, ReturnType::Distance, p.into()) + 1.0) * 0.5
        };
        assert_near(ours, expected, 1e-5);
    }
}

/// F1, F2 and the nearest point's hash by looking at every point of 7 x 7 tiles around.
fn brute_worley(
    node: &Worley,
    seed: u32,
    p: [f64; 2],
    distance: fn(&[f64], &[f64]) -> f64,
) -> (f64, f64, f32) {
    let (cu, cv) = (i64::from(node.cells_u), i64::from(node.cells_v));
    let (i, j) = (p[0].floor() as i64, p[1].floor() as i64);
    let mut all = Vec::new();
    for dj in -4..=4 {
        for di in -4..=4 {
            let (ci, cj) = (i + di, j + dj);
            let h = hash::hash2(hash::pcg(seed), cj.rem_euclid(cv) as u32, ci.rem_euclid(cu) as u32);
            let part = |bits: u32| ((f64::from(bits) + 0.5) / 65_536.0 - 0.5) * f64::from(node.jitter) + 0.5;
            let q = [ci as f64 + part(h >> 16), cj as f64 + part(h & 0xffff)];
            all.push((distance(&p, &q), hash::unit(hash::pcg(h))));
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    (all[0].0, all[1].0, all[0].1)
}

#[test]
fn worley_is_the_brute_force_distance_in_every_metric() {
    let domain = odd_domain();
    let metrics: [(Metric, Distance); 3] = [
        (Metric::Euclidean, distance_functions::euclidean),
        (Metric::Manhattan, distance_functions::manhattan),
        (Metric::Chebyshev, distance_functions::chebyshev),
    ];
    for (metric, distance) in metrics {
        for (cells_u, cells_v, jitter, seed) in
            [(40, 33, 1.0, 1), (7, 5, 0.6, 2), (1, 1, 1.0, 3), (2, 1, 0.9, 4)]
        {
            let node = Worley { cells_u, cells_v, metric, jitter };
            let out = run(&node, &domain, seed, &[]);
            let brute = |x, y| brute_worley(&node, seed, point(&domain, [cells_u, cells_v], x, y), distance);
            assert_near(&out[0], |x, y| brute(x, y).0, 2e-5);
            assert_near(&out[1], |x, y| brute(x, y).1, 2e-5);
            assert_near(&out[2], |x, y| brute(x, y).1 - brute(x, y).0, 4e-5);
            for y in 0..domain.height {
                for x in 0..domain.width {
                    let (f1, f2, id) = brute(x, y);
                    // Nearly equal distances may fall either way.
                    if f2 - f1 > 1e-4 {
                        assert_eq!(out[3].at(x as i64, y as i64), id, "{node:?} ({x}, {y})");
                    }
                }
            }
        }
    }
}

/// Our Perlin noise in f64 for the `noise` crate's fractal generators: octave k reads its own hasher.
#[derive(Clone, Debug, Default)]
struct Octave {
    hasher: Option<Periodic>,
    phase: [f64; 2],
}

thread_local! {
    static CASE: std::cell::Cell<(u32, u32)> = const { std::cell::Cell::new((0, 0)) };
}

impl Seedable for Octave {
    /// The crate seeds octave k with its seed + k; it does not tell k otherwise.
    fn set_seed(self, k: u32) -> Self {
        let (cells, seed) = CASE.get();
        let n = (cells << k) as isize;
        let seed = hash::hash1(seed, k);
        Self {
            hasher: Some(Periodic { cells: [n, n], seed, shift: 0 }),
            phase: lattice::Cells::new(1, 1, seed).out_of_phase().phase.map(f64::from),
        }
    }
    fn seed(&self) -> u32 {
        0
    }
}

impl NoiseFn<f64, 2> for Octave {
    fn get(&self, p: [f64; 2]) -> f64 {
        let p = [p[0] + self.phase[0], p[1] + self.phase[1]];
        self.hasher.map_or(0.0, |h| perlin_2d(p.into(), &h) * std::f64::consts::FRAC_1_SQRT_2)
    }
}

#[test]
fn sums_are_the_noise_crates_but_for_its_normalisation() {
    let (cells, seed, octaves) = (16, 5, 4);
    CASE.set((cells, seed));
    let domain = Domain::square(96);
    let node = |sum| Fractal { sum, cells_u: cells, cells_v: cells, octaves, ..Fractal::default() };
    // The crate's Perlin is clamped at 1 after scaling by sqrt 2; compare where no octave is near the clamp.
    let tame = |x, y| {
        let p = point(&domain, [cells; 2], x, y);
        (0..octaves).all(|k| {
            let octave = Octave::default().set_seed(k);
            octave.get(p.map(|t| t * f64::from(1u32 << k))).abs() < 0.7
        })
    };
    let check = |sum, expected: &dyn Fn([f64; 2]) -> f64| {
        let ours = &run(&node(sum), &domain, seed, &[])[0];
        let mut compared = 0;
        for y in 0..96 {
            for x in 0..96 {
                if tame(x, y) {
                    let (a, e) =
                        (f64::from(ours.at(x as i64, y as i64)), expected(point(&domain, [cells; 2], x, y)));
                    assert!((a - e).abs() < 1e-4, "{sum:?} ({x}, {y}): {a}, expected {e}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 8000, "{sum:?}: {compared}");
    };
    let amplitudes = [1.0, 0.5, 0.25, 0.125];
    let total: f64 = amplitudes.iter().sum();

    let fbm =
        Fbm::<Octave>::new(0).set_octaves(4).set_frequency(1.0).set_lacunarity(2.0).set_persistence(0.5);
    check(Sum::Fbm, &|p| 0.5 + 0.5 * fbm.get(p));
    let billow =
        Billow::<Octave>::new(0).set_octaves(4).set_frequency(1.0).set_lacunarity(2.0).set_persistence(0.5);
    check(Sum::Turbulence, &|p| 0.5 + 0.5 * billow.get(p));
    // Its ridged noise is 2 sum / (1 + sum over k from 1 to octaves of w_k 0.5^k) - 1 with its own weights w_k.
    let ridged = RidgedMulti::<Octave>::new(0)
        .set_octaves(4)
        .set_frequency(1.0)
        .set_lacunarity(2.0)
        .set_persistence(0.5)
        .set_attenuation(0.5);
    let (mut denominator, mut amplitude, mut signal) = (1.0, 1.0, 1.0f64);
    for k in 1..=4 {
        amplitude *= 0.5;
        signal = (signal / 0.5f64.powi(k)).clamp(0.0, 1.0) * amplitude;
        denominator += signal;
    }
    check(Sum::Ridged, &|p| (ridged.get(p) + 1.0) * 0.5 * denominator / total);
}

/// Every noise at (cells_u, cells_v), with the index of the output to look at.
fn every(cells_u: u32, cells_v: u32) -> Vec<(Box<dyn Node>, usize)> {
    let mut nodes: Vec<(Box<dyn Node>, usize)> = vec![
        (Box::new(ValueNoise { cells_u, cells_v }), 0),
        (Box::new(PerlinNoise { cells_u, cells_v }), 0),
        (Box::new(SimplexNoise { cells_u, cells_v }), 0),
        (Box::new(WhiteNoise { cells_u, cells_v }), 0),
        (Box::new(BlueNoise { cells_u, cells_v }), 0),
    ];
    for output in 0..4 {
        nodes.push((Box::new(Worley { cells_u, cells_v, ..Worley::default() }), output));
    }
    for basis in [Basis::Value, Basis::Perlin, Basis::Simplex, Basis::WorleyF1, Basis::WorleyEdge] {
        for sum in [Sum::Fbm, Sum::Turbulence, Sum::Billow, Sum::Ridged] {
            let node =
                Fractal { basis, sum, cells_u, cells_v, octaves: 3, lacunarity: 1.9, ..Fractal::default() };
            nodes.push((Box::new(node), 0));
        }
    }
    nodes
}

fn offsets<'a>(node: &dyn Node, du: Input<'a>, dv: Input<'a>) -> Vec<Input<'a>> {
    let mut inputs = vec![Input::Unset; node.spec().inputs.len() - 2];
    inputs.extend([du, dv]);
    inputs
}

#[test]
fn continuous_noise_has_no_seam_for_any_period() {
    // Neighbouring texels differ little, also those over the seam: one step of 1/512 at up to 7 * 1.9^2 cells.
    for (cells_u, cells_v) in [(1, 1), (3, 5), (2, 7), (7, 4), (1, 6)] {
        for (node, output) in every(cells_u, cells_v) {
            let name = node.spec().name;
            if name == "white_noise" || name == "blue_noise" || output == 3 {
                continue;
            }
            let p = &run(&*node, &Domain::square(512), 11, &[])[output];
            for i in 0..512 {
                for (a, b) in [(p.at(511, i), p.at(0, i)), (p.at(i, 511), p.at(i, 0))] {
                    assert!((a - b).abs() < 0.25, "{node:?}[{output}] at {i}: {a} {b}");
                }
            }
            let inner = (0..511i64)
                .flat_map(|i| (0..512i64).map(move |k| (i, k)))
                .map(|(i, k)| (p.at(i, k) - p.at(i + 1, k)).abs().max((p.at(k, i) - p.at(k, i + 1)).abs()))
                .fold(0.0f32, f32::max);
            let seam = (0..512)
                .map(|i| (p.at(511, i) - p.at(0, i)).abs().max((p.at(i, 511) - p.at(i, 0)).abs()))
                .fold(0.0f32, f32::max);
            assert!(seam <= inner * 1.5 + 1e-6, "{node:?}[{output}]: seam {seam}, inside {inner}");
        }
    }
}

#[test]
fn an_offset_moves_the_noise_around_the_torus() {
    let domain = Domain::square(64);
    let (du, dv) = (Plane::filled(64, 64, 0.25), Plane::filled(64, 64, -0.5));
    for (node, output) in every(5, 3) {
        let still = &run(&*node, &domain, 2, &[])[output];
        let moved = &run(&*node, &domain, 2, &offsets(&*node, Input::Plane(&du), Input::Plane(&dv)))[output];
        let constant =
            &run(&*node, &domain, 2, &offsets(&*node, Input::Value(0.25), Input::Value(-0.5)))[output];
        assert_eq!(moved, constant, "{node:?}: a constant and a map of it differ");
        let far = moved
            .data()
            .iter()
            .zip(still.shifted(-16, 32).data())
            .filter(|(a, b)| (*a - *b).abs() > 1e-4)
            .count();
        // A texel on a border of cells may fall either way.
        assert!(far <= 4, "{node:?}[{output}]: {far} texels differ");
    }
}

#[test]
fn extreme_offsets_stay_finite_and_in_range() {
    let domain = Domain::square(16);
    for (node, output) in every(3, 2) {
        for d in [1e30, -1e30, f32::MAX, f32::MIN, 1e-42, -1e-42, -1.0, 1.0, 1e7, -f32::EPSILON] {
            let p = &run(&*node, &domain, 2, &offsets(&*node, Input::Value(d), Input::Value(d)))[output];
            for v in p.data() {
                assert!((0.0..=2.0).contains(v), "{node:?} {d}: {v}");
            }
        }
    }
}

#[test]
fn ranges_and_means_are_those_documented() {
    let domain = Domain::square(256);
    for (node, output) in every(32, 30) {
        let p = &run(&*node, &domain, 4, &[])[output];
        let (lo, hi) = num::min_max(p.data());
        let (name, mean) = (node.spec().name, num::mean(p.data()));
        let spread = (p.data().iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>()
            / p.data().len() as f64)
            .sqrt();
        let top = if name == "worley" && output < 3 { 2.0 } else { 1.0 };
        assert!(lo >= 0.0 && hi <= top, "{node:?}[{output}]: {lo} {hi}");
        assert!(spread > 0.04, "{node:?}[{output}]: flat, {spread}");
        if name != "worley" && name != "fractal" {
            assert!((mean - 0.5).abs() < 0.02, "{node:?}: mean {mean}");
        }
    }
    let mean = |sum| {
        num::mean(
            run(&Fractal { sum, cells_u: 32, cells_v: 32, ..Fractal::default() }, &domain, 4, &[])[0].data(),
        )
    };
    for (sum, stated) in [(Sum::Fbm, 0.5), (Sum::Turbulence, 0.25), (Sum::Billow, 0.4)] {
        assert!((mean(sum) - stated).abs() < 0.03, "{sum:?}: {}", mean(sum));
    }
    // Variance of uniform numbers: 1/12.
    let white = &run(&WhiteNoise { cells_u: 256, cells_v: 256 }, &domain, 4, &[])[0];
    let variance = white.data().iter().map(|v| f64::from(v - 0.5).powi(2)).sum::<f64>() / 65_536.0;
    assert!((variance - 1.0 / 12.0).abs() < 0.002, "{variance}");
}

#[test]
fn seeds_are_independent() {
    let domain = Domain::square(128);
    for (node, output) in every(64, 64) {
        // About 4096 cells a pair: the standard error of the mean of four correlations is near 0.01.
        let correlations = [1, 3, 5, 7].map(|seed| {
            let [a, b] = [seed, seed + 1].map(|seed| run(&*node, &domain, seed, &[])[output].clone());
            let (ma, mb) = (num::mean(a.data()), num::mean(b.data()));
            let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
            for (x, y) in a.data().iter().zip(b.data()) {
                let (x, y) = (f64::from(*x) - ma, f64::from(*y) - mb);
                (ab, aa, bb) = (ab + x * y, aa + x * x, bb + y * y);
            }
            ab / (aa * bb).sqrt()
        });
        let r = correlations.iter().sum::<f64>() / 4.0;
        assert!(r.abs() < 0.04, "{node:?}[{output}]: correlations {correlations:?}");
        let [a, b] = [1, 1].map(|seed| run(&*node, &domain, seed, &[])[output].clone());
        assert_eq!(a, b);
    }
}

#[test]
fn a_grid_twice_as_fine_is_the_same_noise() {
    for (node, output) in every(6, 5) {
        if output == 3 || node.spec().name == "blue_noise" || node.spec().name == "white_noise" {
            continue;
        }
        let coarse = &run(&*node, &Domain::square(128), 4, &[])[output];
        let fine = &run(&*node, &Domain::square(256), 4, &[])[output].halved();
        let error = coarse.data().iter().zip(fine.data()).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
        let error = (error / coarse.data().len() as f64).sqrt();
        assert!(error < 0.02, "{node:?}[{output}]: {error}");
    }
}

#[test]
fn settings_out_of_range_are_held_and_do_not_panic() {
    let domain = Domain { width: 1, height: 1, girth_mm: 1.0, length_mm: 1.0 };
    for cells in [0, 1, u32::MAX] {
        for (node, output) in every(cells, cells) {
            // A blue tile of the greatest size is large; the others are not.
            if node.spec().name != "blue_noise" || cells < 2 {
                assert!(run(&*node, &domain, 0, &[])[output].at(0, 0).is_finite());
            }
        }
    }
    let wild = Fractal { octaves: 1000, lacunarity: f32::NAN, ..Fractal::default() };
    assert!(run(&wild, &domain, 0, &[Input::Value(1e30)])[0].at(0, 0).is_finite());
}

#[test]
fn every_simd_level_gives_the_same_bits() {
    use crate::base::simd::{Level, force};
    let domain = Domain { width: 61, height: 9, girth_mm: 1.0, length_mm: 1.0 };
    let warp = Plane::from_fn(61, 9, |x, y| (x * y) as f32 * 0.001);
    for (node, output) in every(13, 6) {
        let inputs = offsets(&*node, Input::Plane(&warp), Input::Plane(&warp));
        let mut planes = Level::ALL.iter().map(|&level| {
            force(level);
            run(&*node, &domain, 3, &inputs)[output].clone()
        });
        let base = planes.next();
        assert!(planes.all(|p| Some(&p) == base.as_ref()), "{node:?}");
    }
    force(Level::Avx512);
}

/// Where the input is between the bounds it is the noise bit for bit, elsewhere 0.5: at each basis, sum and kind of offsets.
#[test]
fn noise_is_computed_only_where_it_is_wanted() {
    let domain = Domain { width: 400, height: 5, girth_mm: 400.0, length_mm: 5.0 };
    // Wanted in the second half of every 150 texels, and at one texel of row 3.
    let by = plane(&domain, |x, y| if x % 150 > 75 || (x, y) == (3, 3) { 1.0 } else { x as f32 * -0.01 });
    let moved = plane(&domain, |x, _| 0.2 * (x as f32 * 0.05).sin());
    let bases = [Basis::Value, Basis::Perlin, Basis::Simplex, Basis::WorleyF1, Basis::WorleyEdge];
    for basis in bases {
        for sum in [Sum::Fbm, Sum::Ridged] {
            let all = Fractal { basis, sum, cells_u: 9, cells_v: 3, octaves: 3, ..Fractal::default() };
            let some = Fractal { above: 0.5, below: 2.0, ..all.clone() };
            for du in [Input::Value(0.1), Input::Plane(&moved)] {
                for gain in [Input::Value(0.5), Input::Plane(&by)] {
                    let with = |by| [gain, by, du];
                    let noise = run(&all, &domain, 5, &with(Input::Unset)).remove(0);
                    let left = run(&some, &domain, 5, &with(Input::Plane(&by))).remove(0);
                    for (i, (n, l)) in noise.data().iter().zip(left.data()).enumerate() {
                        let wanted = by.data()[i] == 1.0;
                        assert_eq!(*l, if wanted { *n } else { 0.5 }, "{basis:?} {sum:?} {i}");
                    }
                }
            }
            // A number is the same everywhere.
            let none = [Input::Unset, Input::Value(2.0)];
            assert!(run(&some, &domain, 5, &none)[0].data().iter().all(|v| *v == 0.5));
        }
    }
}

fn plane(domain: &Domain, f: impl Fn(usize, usize) -> f32) -> Plane {
    let texels = (0..domain.texels()).map(|i| f(i % domain.width, i / domain.width));
    Plane::from_vec(domain.width, domain.height, texels.collect())
}
