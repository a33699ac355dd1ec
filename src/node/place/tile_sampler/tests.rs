//! Claims of the tile sampler.

use super::*;
use crate::base::{Plane, num};
use crate::eval::{Input, run_node};
use crate::node::Assets;

const TILE: Domain = Domain { width: 192, height: 256, girth_mm: 60.0, length_mm: 80.0 };

fn run(node: &TileSampler, domain: &Domain, ins: &[Input<'_>]) -> Vec<Plane> {
    run_node(node, domain, 7, ins, &Assets::new(), 0)
}

fn difference(a: &Plane, b: &Plane) -> f32 {
    a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Everything that chance can change.
fn wild() -> TileSampler {
    TileSampler {
        x_amount: 7,
        y_amount: 9,
        size_random_x: 0.5,
        size_random_y: 0.3,
        scale: 1.7,
        scale_random: 0.4,
        position_random: 0.8,
        rotation_random: 180.0,
        color_random: 0.6,
        mask_random: 0.1,
        pattern_rotation_random: 0.5,
        symmetry_random: 0.5,
        pattern_kind: PatternKind::Brick,
        pattern_specific: 0.4,
        ..TileSampler::default()
    }
}

#[test]
fn squares_cover_their_share_of_the_tile() {
    for (nx, ny, size) in [(3, 5, 0.9), (1, 1, 0.5), (50, 60, 0.7), (1024, 1024, 0.5)] {
        let node =
            TileSampler { x_amount: nx, y_amount: ny, size_x: size, size_y: 0.5, ..TileSampler::default() };
        let mean = num::mean(run(&node, &Domain::square(128), &[])[0].data());
        // Where gaps are thinner than texels, copies share texels: `max` shows one, `add` all.
        if nx < 50 {
            assert!((mean - f64::from(size) * 0.5).abs() < 1e-3, "{nx} {ny}: {mean}");
        }
        let add = TileSampler { blending: Blending::Add, ..node };
        let mean = num::mean(run(&add, &Domain::square(128), &[])[0].data());
        assert!((mean - f64::from(size) * 0.5).abs() < 1e-3, "{nx} {ny} added: {mean}");
    }
}

#[test]
fn added_patterns_have_their_volume_however_they_are_turned() {
    let pi = std::f64::consts::PI;
    for (kind, volume) in [
        (PatternKind::Disc, pi / 4.0),
        (PatternKind::Paraboloid, pi / 8.0),
        (PatternKind::Cone, pi / 12.0),
        (PatternKind::Thorn, pi / 24.0),
        (PatternKind::Pyramid, 1.0 / 3.0),
        (PatternKind::Gradation, 0.5),
        (PatternKind::Waves, 0.5),
        (PatternKind::Capsule, 0.25 + pi / 16.0),
    ] {
        let node = TileSampler {
            pattern_kind: kind,
            blending: Blending::Add,
            x_amount: 3,
            y_amount: 4,
            rotation: 25.0,
            position_random: 1.0,
            symmetry_random: 0.5,
            ..TileSampler::default()
        };
        let mean = num::mean(run(&node, &TILE, &[])[0].data());
        assert!((mean - 0.81 * volume).abs() < 4e-3, "{kind:?}: {mean}, not {}", 0.81 * volume);
    }
}

#[test]
fn moving_everything_moves_all_outputs_over_the_seams() {
    for blending in [Blending::Max, Blending::Add, Blending::Alpha, Blending::Order] {
        let still = TileSampler { blending, ..wild() };
        let moved = TileSampler { global_offset_u: 0.25, global_offset_v: -0.5, ..still.clone() };
        let (a, b) = (run(&still, &TILE, &[]), run(&moved, &TILE, &[]));
        let differ = |k: usize, dx: i64, dy: i64| {
            let shifted = a[k].shifted(dx, dy);
            let differs = |(x, y): (&f32, &f32)| (x - y).abs() > 2e-3;
            shifted.data().iter().zip(b[k].data()).filter(|&p| differs(p)).count()
        };
        for k in 0..a.len() {
            // Rounding may turn the owner of a texel on an edge.
            assert!(differ(k, 48, -128) < TILE.texels() / 1000, "{blending:?} {k}: {}", differ(k, 48, -128));
            assert!(differ(k, 0, 0) > TILE.texels() / 4);
        }
    }
}

#[test]
fn an_input_is_copied_whole_into_every_cell() {
    let image = Plane::from_fn(192, 256, |x, y| (x as f32 / 192.0) * (1.0 - y as f32 / 256.0));
    let node = TileSampler {
        pattern_kind: PatternKind::Input,
        x_amount: 2,
        y_amount: 2,
        size_x: 1.0,
        size_y: 1.0,
        ..TileSampler::default()
    };
    let out = run(&node, &TILE, &[Input::Plane(&image)]);
    assert!(difference(&out[0], &out[0].shifted(96, 128)) < 1e-6);
    let half = image.halved();
    for (x, y) in [(10, 20), (80, 90), (95, 127)] {
        assert!((out[0].at(x, y) - half.at(x, y)).abs() < 1e-2);
        assert!((out[3].at(x, y) - (x as f32 + 0.5) / 96.0).abs() < 1e-4);
        assert!((out[4].at(x, y) - (y as f32 + 0.5) / 128.0).abs() < 1e-4);
    }
    // A quarter turn from u towards v: the image's left border lies on top.
    let turned = TileSampler { pattern_rotation: 1, ..node };
    let out = run(&turned, &TILE, &[Input::Plane(&image)]);
    assert!(out[3].at(50, 0) < 0.01 && out[3].at(50, 127) > 0.99);
}

#[test]
fn ids_and_indices_name_the_copies() {
    let node = TileSampler { x_amount: 3, y_amount: 2, size_x: 1.0, size_y: 1.0, ..TileSampler::default() };
    let out = run(&node, &TILE, &[]);
    assert_eq!(num::min_max(out[2].data()), (1.0, 6.0));
    assert_eq!(out[2].at(100, 200), 5.0);
    let mut ids: Vec<u32> = out[1].data().iter().map(|v| v.to_bits()).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), 6);
}

#[test]
fn later_copies_lie_on_top_unless_reversed() {
    let node = TileSampler {
        x_amount: 2,
        y_amount: 1,
        size_x: 1.5,
        blending: Blending::Order,
        color_parametrization_mode: Parametrization::PatternIndex,
        ..TileSampler::default()
    };
    // Copy 1 covers u in [0.375, 1.125]: at 0.5 both are.
    assert_eq!(run(&node, &TILE, &[])[2].at(96, 128), 2.0);
    let reversed = TileSampler { reverse_rendering_order: true, ..node };
    assert_eq!(run(&reversed, &TILE, &[])[2].at(96, 128), 1.0);
}

#[test]
fn maps_scale_mask_and_move() {
    let node = TileSampler { x_amount: 4, y_amount: 4, size_x: 1.0, size_y: 1.0, ..TileSampler::default() };
    let map = |i: usize, p: &Plane| {
        let mut ins = vec![Input::Unset; 13];
        ins[i] = Input::Plane(p);
        run(&node, &TILE, &ins)
    };
    let left = Plane::from_fn(192, 256, |x, _| if x < 96 { 1.0 } else { 0.0 });
    assert!((num::mean(map(MASK_MAP, &left)[0].data()) - 0.5).abs() < 1e-6);
    assert!((num::mean(map(COLOR_MAP, &left)[0].data()) - 0.5).abs() < 1e-6);
    let half = Plane::filled(192, 256, 0.5);
    assert!((num::mean(map(SCALE_MAP, &half)[0].data()) - 0.25).abs() < 1e-3);
    // 0.1 of 60 mm along u: 19.2 texels.
    let one = Plane::filled(192, 256, 1.0);
    assert!((map(DISPLACEMENT_MAP, &one)[3].at(19, 30) - 0.3 / 48.0).abs() < 1e-3);
}

#[test]
fn a_quincunx_moves_every_second_row_by_half_a_cell() {
    let node = TileSampler { x_amount: 4, y_amount: 4, offset: 0.5, ..TileSampler::default() };
    let out = &run(&node, &TILE, &[])[0];
    assert_eq!((out.at(24, 32), out.at(24, 96)), (1.0, 0.0));
    assert_eq!((out.at(0, 32), out.at(0, 96)), (0.0, 1.0));
}

#[test]
fn every_pattern_is_in_range_and_finite_at_any_size() {
    let huge = [1e30, -1e30, f32::MAX, 1e-40, 0.0];
    for kind in pattern::ALL {
        for domain in [Domain::square(1), Domain { width: 3, height: 40, girth_mm: 1e-3, length_mm: 1e5 }] {
            for value in huge {
                for blending in [Blending::Max, Blending::Add, Blending::Alpha, Blending::Order] {
                    let node =
                        TileSampler { pattern_kind: kind, blending, vector_map_multiplier: 1.0, ..wild() };
                    for plane in run(&node, &domain, &[Input::Value(value); 13]) {
                        assert!(plane.data().iter().all(|v| v.is_finite()), "{kind:?} {value} {blending:?}");
                    }
                }
            }
        }
        let node = TileSampler { pattern_kind: kind, ..TileSampler::default() };
        let (low, high) = num::min_max(run(&node, &TILE, &[])[0].data());
        assert!(low >= 0.0 && high <= 1.0 && high > 0.5, "{kind:?} {low} {high}");
    }
}

#[test]
fn the_same_copies_at_twice_the_size() {
    let double = Domain { width: 384, height: 512, ..TILE };
    let (a, b) = (run(&wild(), &TILE, &[]), run(&wild(), &double, &[]));
    let rms = |p: &Plane, q: &Plane| {
        let sum: f64 = p.data().iter().zip(q.data()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        (sum / p.data().len() as f64).sqrt()
    };
    assert!(rms(&a[0], &b[0].halved()) < 0.03, "{}", rms(&a[0], &b[0].halved()));
}
