//! What the tests of this folder share.

use crate::base::{Domain, Plane, hash};
use crate::eval::{Input, run_node};
use crate::node::{Assets, Node};

/// A square domain of 100 mm.
pub(crate) fn square(size: usize) -> Domain {
    Domain::square(size)
}

/// A domain of square texels of 1 mm.
pub(crate) fn grid(width: usize, height: usize) -> Domain {
    Domain { width, height, girth_mm: width as f32, length_mm: height as f32 }
}

/// White noise in [0, 1).
pub(crate) fn noise(width: usize, height: usize, seed: u32) -> Plane {
    Plane::from_fn(width, height, |x, y| hash::unit(hash::hash2(seed, x as u32, y as u32)))
}

/// One texel of 1 at (`x`, `y`), else 0.
pub(crate) fn impulse(width: usize, height: usize, x: usize, y: usize) -> Plane {
    Plane::from_fn(width, height, |i, j| if (i, j) == (x, y) { 1.0 } else { 0.0 })
}

/// The first output of `node`.
pub(crate) fn run(node: &dyn Node, domain: &Domain, inputs: &[Input<'_>]) -> Plane {
    run_node(node, domain, 1, inputs, &Assets::new(), 0).swap_remove(0)
}

/// Bands of 1 and 7 rows give the same bits as the whole.
pub(crate) fn assert_bands_agree(node: &dyn Node, domain: &Domain, inputs: &[Input<'_>]) {
    let whole = run_node(node, domain, 1, inputs, &Assets::new(), 0);
    for band in [1, 7] {
        let banded = run_node(node, domain, 1, inputs, &Assets::new(), band);
        for (a, b) in whole.iter().zip(&banded) {
            assert!(a.data().iter().zip(b.data()).all(|(a, b)| a.to_bits() == b.to_bits()), "band {band}");
        }
    }
}

/// The greatest difference of two planes.
pub(crate) fn max_difference(a: &Plane, b: &Plane) -> f32 {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Moving the input on the torus moves the first output alike, to the bit.
pub(crate) fn assert_shifts_along(node: &dyn Node, domain: &Domain, image: &Plane, rest: &[Input<'_>]) {
    let with = |p: &Plane| {
        let mut inputs = vec![Input::Plane(p)];
        inputs.extend_from_slice(rest);
        run(node, domain, &inputs)
    };
    let (dx, dy) = (5, -3);
    let (a, b) = (with(image).shifted(dx, dy), with(&image.shifted(dx, dy)));
    assert!(a.data().iter().zip(b.data()).all(|(a, b)| a.to_bits() == b.to_bits()), "{node:?}");
}

/// The first output is finite for constants of any size, for huge noise, and on a 1x1 map.
pub(crate) fn assert_finite(node: &dyn Node, rest: &[Input<'_>]) {
    for domain in [grid(1, 1), grid(1, 5), grid(6, 1), grid(9, 7)] {
        for v in [0.0, 1.0, -1.0, 1e30, -1e30, f32::MAX, f32::MIN, 1e-40] {
            let p = Plane::from_fn(domain.width, domain.height, |x, y| {
                v * (2.0 * hash::unit(hash::hash2(7, x as u32, y as u32)) - 1.0)
            });
            let flat = Plane::filled(domain.width, domain.height, v);
            for first in [Input::Plane(&p), Input::Plane(&flat), Input::Value(v)] {
                let mut inputs = vec![first];
                inputs.extend_from_slice(rest);
                for out in run_node(node, &domain, 1, &inputs, &Assets::new(), 0) {
                    assert!(out.data().iter().all(|x| x.is_finite()), "{node:?} {domain:?} {v}");
                }
            }
        }
    }
}
