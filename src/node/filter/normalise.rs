//! Normalise: the whole plane's values onto [0, 1].

use std::ops::Range;

use rayon::prelude::*;

use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// The least value of the plane becomes 0, the greatest 1. A constant becomes 0. Channels of a colour are taken each
/// for itself.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Normalise {}

impl Operation for Normalise {
    const SPEC: Spec = Spec {
        name: "normalise",
        summary: "Stretches the image so that its least value is 0 and its greatest 1.",
        inputs: &[InputSpec::image("image", "What is stretched.")],
        outputs: &[OutputSpec::same("result", "In [0, 1]; 0 where the image is constant.")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        1.0
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let image = ins.scalar(0);
        // Minimum and maximum do not depend on the order.
        let (low, high) = rows
            .clone()
            .into_par_iter()
            .map(|y| range(image.row(y)))
            .reduce(|| (f32::INFINITY, f32::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (width, first) = (outs.width(), rows.start);
        let Some(band) = outs.band(0) else { return };
        band.par_chunks_mut(width).enumerate().for_each(|(i, out)| {
            kernel(low, high, image.row(first + i as i64), out);
        });
    }
}

multiversion! {
    // Least and greatest value of a row, lane by lane.
    fn range(row: &[f32]) -> (f32, f32) {
        let (mut low, mut high) = ([f32::INFINITY; 32], [f32::NEG_INFINITY; 32]);
        let (blocks, rest) = row.as_chunks::<32>();
        for block in blocks {
            for i in 0..32 {
                low[i] = low[i].min(block[i]);
                high[i] = high[i].max(block[i]);
            }
        }
        let least = low.iter().chain(rest).fold(f32::INFINITY, |a, &b| a.min(b));
        let most = high.iter().chain(rest).fold(f32::NEG_INFINITY, |a, &b| a.max(b));
        (least, most)
    }
}

multiversion! {
    fn kernel(low: f32, high: f32, image: &[f32], out: &mut [f32]) {
        // Halved, so that the range of the widest plane is finite; divided, so that a denormal range works.
        let range = 0.5 * high - 0.5 * low;
        let safe = if range > 0.0 { range } else { 1.0 };
        for (o, x) in out.iter_mut().zip(image) {
            let v = num::saturate((0.5 * *x - 0.5 * low) / safe);
            *o = if range > 0.0 { v } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_finite, grid, noise, run};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Value};

    #[test]
    fn the_ends_become_0_and_1_and_order_stays() {
        let a = noise(77, 5, 1);
        let b = Plane::from_fn(77, 5, |x, y| -7.0 + 40.0 * a.at(x as i64, y as i64));
        let out = run(&Normalise::default(), &grid(77, 5), &[P(&b)]);
        assert_eq!(num::min_max(out.data()), (0.0, 1.0));
        let (lo, hi) = num::min_max(a.data());
        for (o, x) in out.data().iter().zip(a.data()) {
            assert!((o - (x - lo) / (hi - lo)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_constant_becomes_0_and_huge_planes_stay_finite() {
        for v in [0.0, 3.0, 1e30, -1e-40] {
            let out = run(&Normalise::default(), &grid(3, 2), &[Value(v)]);
            assert!(out.data().iter().all(|&x| x == 0.0));
        }
        assert_finite(&Normalise::default(), &[]);
    }
}
