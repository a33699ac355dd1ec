//! Colour nodes. Colours on edges are linear RGB; a node that works in another space says so.

mod gradient_map;
mod grayscale;
mod hsl_adjust;
mod hsl_jitter;
mod jitter;
mod merge;
mod oklab_jitter;
mod split;

use super::Op;

pub use gradient_map::{GradientMap, Interpolation, MixSpace, Stop};
pub use grayscale::{Grayscale, GrayscaleMode};
pub use hsl_adjust::HslAdjust;
pub use hsl_jitter::HslJitter;
pub use merge::Merge;
pub use oklab_jitter::OklabJitter;
pub use split::Split;

/// The operations of this category.
pub const OPS: &[Op] = &[
    Op::of::<GradientMap>(),
    Op::of::<HslAdjust>(),
    Op::of::<HslJitter>(),
    Op::of::<OklabJitter>(),
    Op::of::<Grayscale>(),
    Op::of::<Split>(),
    Op::of::<Merge>(),
];

/// One texel of a node, for tests: each input one or three numbers.
#[cfg(test)]
fn texel(node: &dyn super::Node, seed: u32, inputs: &[&[f32]]) -> Vec<f32> {
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    let planes: Vec<Vec<Plane>> =
        inputs.iter().map(|lanes| lanes.iter().map(|&v| Plane::filled(1, 1, v)).collect()).collect();
    let inputs: Vec<_> = planes
        .iter()
        .map(|lanes| match lanes.as_slice() {
            [r, g, b] => Input::Color([r, g, b]),
            lanes => Input::Plane(&lanes[0]),
        })
        .collect();
    let out = run_node(node, &Domain::square(1), seed, &inputs, &super::Assets::new(), 0);
    out.iter().map(|p| p.at(0, 0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::PortKind;

    #[test]
    fn wild_values_stay_finite() {
        for op in OPS {
            for v in [0.0, 1.0, -1.0, 1e-40, 1e30, -1e30, f32::MAX, -f32::MAX] {
                for w in [v, 0.5, -v] {
                    let lanes: Vec<Vec<f32>> = (op.spec.inputs.iter())
                        .map(|i| if i.kind == PortKind::Color { vec![v, w, 0.3] } else { vec![w] })
                        .collect();
                    let lanes: Vec<&[f32]> = lanes.iter().map(Vec::as_slice).collect();
                    let out = texel((op.default)().as_ref(), 1, &lanes);
                    assert!(out.iter().all(|o| o.is_finite()), "{} {v} {w}: {out:?}", op.spec.name);
                }
            }
        }
    }
}
