//! Claims of flood fill.

use super::*;
use crate::base::{Plane, num};
use crate::eval::{Input, run_node};
use crate::node::Assets;

const TILE: Domain = Domain { width: 60, height: 80, girth_mm: 30.0, length_mm: 40.0 };

fn run(node: &FloodFill, domain: &Domain, mask: &Plane) -> Vec<Plane> {
    run_node(node, domain, 3, &[Input::Plane(mask)], &Assets::new(), 0)
}

/// A ring of blobs with holes, a bar, and single texels that touch by corners.
fn picture() -> Plane {
    Plane::from_fn(60, 80, |x, y| {
        let u = (10..30).contains(&x)
            && (10..50).contains(&y)
            && !((15..20).contains(&x) && (20..30).contains(&y));
        let bar = (40..55).contains(&x) && (5..9).contains(&y);
        let corners = (40..46).contains(&x) && y == x + 20;
        if u || bar || corners { 0.9 } else { 0.1 }
    })
}

fn count(out: &[Plane]) -> usize {
    num::min_max(out[1].data()).1 as usize
}

#[test]
fn corners_join_by_eight_and_not_by_four() {
    let four = run(&FloodFill::default(), &TILE, &picture());
    let eight =
        run(&FloodFill { connectivity: Connectivity::Eight, ..FloodFill::default() }, &TILE, &picture());
    assert_eq!((count(&four), count(&eight)), (8, 3));
    // Texels of 0.25 mm²; the block without its hole.
    assert_eq!(four[8].at(12, 12), (20.0 * 40.0 - 50.0) * 0.25);
    assert_eq!((four[4].at(12, 12), four[5].at(12, 12)), (20.0 / 60.0, 0.5));
    assert_eq!((four[2].at(10, 10), four[3].at(29, 49)), (0.5 / 20.0, 39.5 / 40.0));
    assert_eq!((four[0].at(0, 0), four[1].at(17, 25)), (0.0, 0.0));
}

#[test]
fn an_area_over_both_seams_is_one_and_moving_the_mask_moves_the_outputs() {
    for connectivity in [Connectivity::Four, Connectivity::Eight] {
        let node = FloodFill { connectivity, ..FloodFill::default() };
        let still = run(&node, &TILE, &picture());
        // Each move carries another area over one seam or both.
        for (dx, dy) in [(-20, -30), (-45, 0), (0, -7), (17, 77), (-43, -63), (59, 1)] {
            let moved = run(&node, &TILE, &picture().shifted(dx, dy));
            assert_eq!(count(&moved), count(&still));
            for k in [2, 3, 4, 5, 8] {
                let expected = still[k].shifted(dx, dy);
                for (a, b) in expected.data().iter().zip(moved[k].data()) {
                    assert!((a - b).abs() < 1e-6, "output {k} moved by {dx} {dy}");
                }
            }
            // Centres move along; ids and numbers stay one for each area.
            let (cu, cv) = (still[6].shifted(dx, dy), still[7].shifted(dx, dy));
            let index = still[1].shifted(dx, dy);
            let mut pairs = std::collections::BTreeSet::new();
            for i in 0..TILE.texels() {
                if index.data()[i] > 0.0 {
                    let du = moved[6].data()[i] - cu.data()[i] - dx as f32 / 60.0;
                    let dv = moved[7].data()[i] - cv.data()[i] - dy as f32 / 80.0;
                    assert!(num::wrap_half(du).abs() < 1e-5 && num::wrap_half(dv).abs() < 1e-5);
                    pairs.insert((
                        index.data()[i].to_bits(),
                        moved[1].data()[i].to_bits(),
                        moved[0].data()[i].to_bits(),
                    ));
                }
            }
            assert_eq!(pairs.len(), count(&still));
        }
    }
}

#[test]
fn areas_that_go_round_the_tile_have_its_size() {
    // A band around the body with a thicker part in the middle of the back, a full tile, a slanted band.
    let band = Plane::from_fn(60, 80, |x, y| {
        f32::from(u8::from((20..30).contains(&y) || ((25..35).contains(&x) && (30..40).contains(&y))))
    });
    let out = run(&FloodFill::default(), &TILE, &band);
    assert_eq!((count(&out), out[4].at(0, 25), out[5].at(0, 25)), (1, 1.0, 0.25));
    assert!((out[6].at(0, 25) - 0.5).abs() < 1e-3 && (out[2].at(30, 25) - 30.5 / 60.0).abs() < 1e-3);
    let moved = run(&FloodFill::default(), &TILE, &band.shifted(40, 70));
    assert!((moved[2].at(10, 15) - out[2].at(30, 25)).abs() < 1e-5);

    let full = run(&FloodFill::default(), &TILE, &Plane::filled(60, 80, 1.0));
    assert_eq!((count(&full), full[4].at(3, 3), full[5].at(3, 3)), (1, 1.0, 1.0));

    let square = Domain::square(64);
    let slanted = Plane::from_fn(64, 64, |x, y| f32::from(u8::from((x + y) % 64 < 9)));
    let out = run(&FloodFill::default(), &square, &slanted);
    assert_eq!((count(&out), out[4].at(0, 0), out[5].at(0, 0)), (1, 1.0, 1.0));
}

#[test]
fn a_spiral_of_runs_is_one_area_as_a_plain_search_finds_it() {
    // Random masks near the threshold of percolation, against a search by texels.
    use crate::base::hash;
    for seed in 0..20u32 {
        let mask = Plane::from_fn(60, 80, |x, y| hash::unit(hash::hash2(seed, x as u32, y as u32)));
        for (connectivity, threshold) in [(Connectivity::Four, 0.45), (Connectivity::Eight, 0.6)] {
            let out = run(&FloodFill { threshold, connectivity }, &TILE, &mask);
            let mut seen = vec![false; TILE.texels()];
            let mut areas = 0;
            for first in 0..seen.len() {
                if seen[first] || mask.data()[first] < threshold {
                    continue;
                }
                areas += 1;
                let (mut todo, mut texels) = (vec![first], 0);
                seen[first] = true;
                while let Some(i) = todo.pop() {
                    texels += 1;
                    assert_eq!(out[1].data()[i], out[1].data()[first]);
                    let (x, y) = ((i % 60) as i64, (i / 60) as i64);
                    for (dx, dy) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                        let j = ((y + dy).rem_euclid(80) * 60 + (x + dx).rem_euclid(60)) as usize;
                        let joined = connectivity == Connectivity::Eight || dx * dy == 0;
                        if joined && !seen[j] && mask.data()[j] >= threshold {
                            seen[j] = true;
                            todo.push(j);
                        }
                    }
                }
                assert!((out[8].data()[first] - texels as f32 * 0.25).abs() < 1e-3);
            }
            assert_eq!(count(&out), areas, "{seed} {connectivity:?}");
            for k in [2, 3] {
                let (low, high) = num::min_max(out[k].data());
                assert!(low >= 0.0 && high <= 1.0);
            }
        }
    }
}

#[test]
fn another_grid_size_keeps_numbers_and_random_numbers() {
    // A jittered lattice of discs at two sizes.
    use crate::node::place::TileSampler;
    let lattice = TileSampler {
        pattern_kind: crate::node::place::PatternKind::Disc,
        x_amount: 9,
        y_amount: 11,
        position_random: 0.12,
        size_x: 0.7,
        size_y: 0.7,
        offset: 0.5,
        ..TileSampler::default()
    };
    let at = |n: usize| {
        let domain = Domain::square(n);
        let mask = &run_node(&lattice, &domain, 5, &[], &Assets::new(), 0)[0];
        run(&FloodFill::default(), &domain, mask)
    };
    let (small, large) = (at(256), at(512));
    assert_eq!((count(&small), count(&large)), (99, 99));
    for (k, most) in [(0, 0.05), (1, 0.05)] {
        let differ = (0..256 * 256i64)
            .filter(|i| {
                let (a, b) = (small[k].at(i % 256, i / 256), large[k].at(i % 256 * 2, i / 256 * 2));
                a > 0.0 && b > 0.0 && a != b
            })
            .count();
        assert!((differ as f64) < most * 65536.0, "output {k}: {differ}");
    }
}

#[test]
fn one_texel_an_empty_mask_and_absurd_values_are_finite() {
    for value in [0.0, 1.0, 1e30, -1e30, f32::MAX, 1e-40] {
        for domain in [Domain::square(1), Domain { width: 1, height: 5, girth_mm: 1.0, length_mm: 5.0 }] {
            let mask = Plane::filled(domain.width, domain.height, value);
            for connectivity in [Connectivity::Four, Connectivity::Eight] {
                let out = run(&FloodFill { connectivity, ..FloodFill::default() }, &domain, &mask);
                assert!(out.iter().all(|p| p.data().iter().all(|v| v.is_finite())));
                assert_eq!(count(&out), usize::from(value >= 0.5));
            }
        }
    }
}
