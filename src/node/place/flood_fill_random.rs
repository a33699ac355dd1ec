//! A random grey for each area or copy.

use std::ops::Range;

use crate::base::hash;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A random grey for each area, copy or scale, from its `id`; another node gives other greys for the same ids.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloodFillRandom {}

const ID: usize = 0;
const MIN: usize = 1;
const MAX: usize = 2;
const OUTSIDE: usize = 3;

impl Operation for FloodFillRandom {
    const SPEC: Spec = Spec {
        name: "flood_fill_random",
        category: Category::Place,
        summary: "A random grey for each area, copy or scale.",
        inputs: &[
            InputSpec::plane(
                "id",
                "",
                "The `id` of `flood_fill`, `tile_sampler` or `scale_lattice`; 0 is outside.",
            ),
            InputSpec::drive("min", 0.0, (-1000.0, 1000.0), "", "The least grey."),
            InputSpec::drive("max", 1.0, (-1000.0, 1000.0), "", "The greatest grey."),
            InputSpec::drive("outside", 0.0, (-1000.0, 1000.0), "", "The grey outside all areas."),
        ],
        outputs: &[OutputSpec::scalar("value", "", "The grey, `min` to `max`.")],
        random: true,
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        1.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        for y in rows {
            let (min, max, outside) = (ins.row(MIN, y), ins.row(MAX, y), ins.row(OUTSIDE, y));
            kernel(ins.row(ID, y), min, max, outside, cx.seed, outs.only(y));
        }
    }
}

/// A uniform number in [0, 1) of the area with this id, under `seed`.
#[inline(always)]
pub(super) fn of_id(seed: u32, id: f32) -> f32 {
    hash::unit(hash::pcg(hash::pcg(seed) ^ id.to_bits()))
}

multiversion! {
    fn kernel(id: &[f32], min: &[f32], max: &[f32], outside: &[f32], seed: u32, out: &mut [f32]) {
        for ((((out, id), min), max), outside) in out.iter_mut().zip(id).zip(min).zip(max).zip(outside) {
            let t = of_id(seed, *id);
            // Not `min + (max - min) t`: the difference of two huge numbers overflows.
            let grey = min * (1.0 - t) + max * t;
            *out = if *id == 0.0 { *outside } else { grey };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane, num};
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    #[test]
    fn greys_are_even_between_min_and_max_and_one_for_each_id() {
        let ids =
            Plane::from_fn(100, 100, |x, y| if x == 0 { 0.0 } else { (y * 50 + x / 2) as f32 / 8192.0 });
        let domain = Domain::square(100);
        let ins = [Input::Plane(&ids), Input::Value(2.0), Input::Value(4.0), Input::Value(-1.0)];
        let out = &run_node(&FloodFillRandom {}, &domain, 9, &ins, &Assets::new(), 0)[0];
        assert_eq!(out.at(0, 5), -1.0);
        assert_eq!(out.at(2, 5), out.at(3, 5));
        assert_ne!(out.at(2, 5), out.at(4, 5));
        let inside: Vec<f32> = out.data().iter().copied().filter(|v| *v != -1.0).collect();
        let (low, high) = num::min_max(&inside);
        assert!(low >= 2.0 && high <= 4.0 && (num::mean(&inside) - 3.0).abs() < 0.03);
    }
}
