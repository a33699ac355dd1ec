//! A straight gradient in each area.

use std::ops::Range;

use super::flood_fill_random::of_id;
use crate::base::{hash, num};
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// A straight gradient from 0 to 1 across each area's box, in a direction that may differ from area to area.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloodFillGradient {
    /// How far chance turns the gradient of an area, to either side; 180 is any direction.
    #[schemars(range(min = 0.0, max = 180.0), extend("x-unit" = "deg"))]
    pub angle_variation: f32,
    /// Give all gradients one slope instead of one height: small areas stay near 0.5. The height is 1 where the box is
    /// as long as the tile's shorter side.
    pub multiply_by_bbox_size: bool,
}

impl Default for FloodFillGradient {
    fn default() -> Self {
        Self { angle_variation: 0.0, multiply_by_bbox_size: false }
    }
}

const ID: usize = 0;
const S: usize = 1;
const T: usize = 2;
const SIZE_U: usize = 3;
const SIZE_V: usize = 4;
const ANGLE: usize = 5;

impl Operation for FloodFillGradient {
    const SPEC: Spec = Spec {
        name: "flood_fill_gradient",
        category: Category::Place,
        summary: "A straight gradient in each area, copy or scale.",
        inputs: &[
            InputSpec::plane(
                "id",
                "",
                "The `id` of `flood_fill` or `tile_sampler`; 0 is outside, where it is 0.",
            ),
            InputSpec::plane("s", "", "Place in the box, around the body: the `s` of the same node."),
            InputSpec::plane("t", "", "Place in the box, along the body: the `t` of the same node."),
            InputSpec::drive(
                "size_u",
                0.1,
                (0.0, 2.0),
                "tile",
                "Width of the box: the `size_u` of the same node.",
            ),
            InputSpec::drive(
                "size_v",
                0.1,
                (0.0, 2.0),
                "tile",
                "Height of the box: the `size_v` of the same node.",
            ),
            InputSpec::drive(
                "angle",
                0.0,
                (-360.0, 360.0),
                "deg",
                "Where the gradient rises: 0 along u, 90 along v.",
            ),
        ],
        outputs: &[OutputSpec::scalar("value", "", "The gradient, 0 to 1; 0 outside.")],
        random: true,
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        3.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let shorter = domain.shorter_mm();
        let sides = [domain.girth_mm / shorter, domain.length_mm / shorter];
        for y in rows {
            let place = [ins.row(S, y), ins.row(T, y)];
            let size = [ins.row(SIZE_U, y), ins.row(SIZE_V, y)];
            kernel(
                ins.row(ID, y),
                place,
                size,
                ins.row(ANGLE, y),
                sides,
                self.angle_variation / 360.0,
                self.multiply_by_bbox_size,
                hash::pcg(cx.seed),
                outs.only(y),
            );
        }
    }
}

multiversion! {
    fn kernel(
        id: &[f32],
        place: [&[f32]; 2],
        size: [&[f32]; 2],
        angle: &[f32],
        sides: [f32; 2],
        variation: f32,
        by_size: bool,
        seed: u32,
        out: &mut [f32],
    ) {
        let n = out.len();
        let (id, angle) = (&id[..n], &angle[..n]);
        let (s, t, size_u, size_v) = (&place[0][..n], &place[1][..n], &size[0][..n], &size[1][..n]);
        for i in 0..n {
            let turns = num::wrap_half(angle[i] * (1.0 / 360.0)) + variation * (2.0 * of_id(seed, id[i]) - 1.0);
            let (cos, sin) = (num::cos_turns(turns), num::sin_turns(turns));
            // The box, in units of the shorter side; a box of no size counts as a tiny square.
            let w = (size_u[i] * sides[0]).max(1e-9).min(1e9);
            let h = (size_v[i] * sides[1]).max(1e-9).min(1e9);
            let along = (num::saturate(s[i]) - 0.5) * w * cos + (num::saturate(t[i]) - 0.5) * h * sin;
            let length = w * cos.abs() + h * sin.abs();
            let value = 0.5 + along / if by_size { 1.0 } else { length };
            out[i] = if id[i] == 0.0 { 0.0 } else { num::saturate(value) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    use crate::node::Assets;
    use crate::node::place::FloodFill;

    fn gradient(node: &FloodFillGradient, angle: f32) -> Plane {
        let domain = Domain { width: 60, height: 80, girth_mm: 30.0, length_mm: 40.0 };
        // A block 20 by 40 over both seams.
        let mask =
            Plane::from_fn(60, 80, |x, y| f32::from(u8::from((x + 10) % 60 < 20 && (y + 20) % 80 < 40)));
        let fill = run_node(&FloodFill::default(), &domain, 3, &[Input::Plane(&mask)], &Assets::new(), 0);
        let mut ins: Vec<Input<'_>> = [0, 2, 3, 4, 5].iter().map(|&k| Input::Plane(&fill[k])).collect();
        ins.push(Input::Value(angle));
        run_node(node, &domain, 4, &ins, &Assets::new(), 0)[0].clone()
    }

    #[test]
    fn it_rises_from_0_to_1_across_the_box_over_the_seam() {
        let node = FloodFillGradient::default();
        let (u, v, back) = (gradient(&node, 0.0), gradient(&node, 90.0), gradient(&node, 180.0));
        for k in 0..20 {
            let expected = (k as f32 + 0.5) / 20.0;
            assert!((u.at(k - 10, 3) - expected).abs() < 1e-5);
            assert!((back.at(k - 10, 3) - (1.0 - expected)).abs() < 1e-5);
        }
        assert!((v.at(0, -20) - 0.5 / 40.0).abs() < 1e-5);
        assert_eq!(u.at(30, 40), 0.0);
        // In millimetres: at 45 degrees the corners are the ends, the middle is 0.5.
        let d = gradient(&node, 45.0);
        assert!(d.at(-10, -20) < 0.02 && d.at(9, 19) > 0.98 && (d.at(0, 0) - 0.5).abs() < 0.02);
    }

    #[test]
    fn by_size_the_slope_is_one_per_shorter_side() {
        let node = FloodFillGradient { multiply_by_bbox_size: true, ..FloodFillGradient::default() };
        let u = gradient(&node, 0.0);
        assert!((u.at(5, 0) - u.at(-5, 0) - 10.0 / 60.0).abs() < 1e-5);
        assert!(
            (gradient(&node, 90.0).at(0, 9) - gradient(&node, 90.0).at(0, -1) - 10.0 / 60.0).abs() < 1e-5
        );
    }

    #[test]
    fn variation_turns_it() {
        let node = FloodFillGradient { angle_variation: 180.0, ..FloodFillGradient::default() };
        assert_ne!(gradient(&node, 0.0), gradient(&FloodFillGradient::default(), 0.0));
    }
}
