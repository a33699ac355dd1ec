//! One node over whole planes: for tests, node previews and library users.

use crate::base::{Domain, Plane, Rows};
use crate::node::{Assets, Cx, Fallback, Inputs, Node, OutputKind, Outputs, PortKind, Reach};

/// What an input of [`run_node`] reads.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// The input's own fallback; 0 where it is required.
    Unset,
    /// A constant (grey where the input is a colour).
    Value(f32),
    /// One plane of the domain's size.
    Plane(&'a Plane),
    /// Three planes of the domain's size; only for colour inputs.
    Color([&'a Plane; 3]),
}

/// Evaluate every output of one node over the whole domain, on one thread, in bands of `band_rows` rows
/// (0 for all at once): one plane per lane, in the order of the spec's outputs (three for a colour).
///
/// `Any` inputs are taken as scalar. Missing trailing inputs count as [`Input::Unset`].
pub fn run_node(
    node: &dyn Node,
    domain: &Domain,
    seed: u32,
    inputs: &[Input<'_>],
    assets: &Assets,
    band_rows: usize,
) -> Vec<Plane> {
    let (width, height) = (domain.width, domain.height);
    let spec = node.spec();
    let constant = |v: f32| vec![v; width];

    // Lanes of every input: constants as broadcast rows.
    let mut constants: Vec<Vec<f32>> = Vec::new();
    let mut offsets = vec![0];
    for (i, input) in spec.inputs.iter().enumerate() {
        let lanes = if input.kind == PortKind::Color { 3 } else { 1 };
        match (inputs.get(i).copied().unwrap_or(Input::Unset), input.fallback) {
            (Input::Value(v), _) => constants.extend((0..lanes).map(|_| constant(v))),
            (Input::Unset, Fallback::Scalar(v)) => constants.extend((0..lanes).map(|_| constant(v))),
            (Input::Unset, Fallback::Color(c)) => {
                constants.extend(c.iter().take(lanes).map(|&v| constant(v)))
            }
            _ => constants.extend((0..lanes).map(|_| constant(0.0))),
        }
        offsets.push(offsets[i] + lanes);
    }
    let mut lanes: Vec<Rows<'_>> = constants.iter().map(|row| Rows::broadcast(row)).collect();
    for (i, input) in inputs.iter().enumerate() {
        for (k, lane) in lanes[offsets[i]..offsets[i + 1]].iter_mut().enumerate() {
            match input {
                Input::Plane(p) => *lane = p.rows(),
                Input::Color(c) => *lane = c[k].rows(),
                _ => {}
            }
        }
    }
    let ins = Inputs::new(&offsets, &lanes);

    let mut out_offsets = vec![0];
    for output in spec.outputs {
        let lanes = if output.kind == OutputKind::Color { 3 } else { 1 };
        out_offsets.push(out_offsets.last().copied().unwrap_or(0) + lanes);
    }
    let lane_count = out_offsets.last().copied().unwrap_or(0);
    let mut planes: Vec<Plane> = (0..lane_count).map(|_| Plane::filled(width, height, 0.0)).collect();

    let cx = Cx { domain: *domain, seed, assets, prepared: None };
    let prepared = node.prepare(&cx);
    let cx = Cx { prepared: prepared.as_ref(), ..cx };
    let band = if node.reach(domain) == Reach::Whole || band_rows == 0 { height } else { band_rows };
    for first in (0..height).step_by(band.max(1)) {
        let last = (first + band).min(height);
        let lanes = planes.iter_mut().map(|p| Some(&mut p.data_mut()[first * width..last * width])).collect();
        let mut outs = Outputs::new(&out_offsets, lanes, width, first as i64);
        node.eval(&cx, first as i64..last as i64, &ins, &mut outs);
    }
    planes
}
