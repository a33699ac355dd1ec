//! Where on the tile each texel of a row is evaluated.

use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::Inputs;

/// Wrapped coordinates of one row of texels, moved by the inputs `du`, `dv`; reused from row to row.
#[derive(Debug)]
pub(in crate::node) struct Coords {
    us: Vec<f32>,
    vs: Vec<f32>,
    row_v: Option<f32>,
    filled_u: bool,
}

impl Coords {
    /// Room for rows of `width` texels.
    pub(in crate::node) fn new(width: usize) -> Self {
        Self { us: vec![0.0; width], vs: vec![0.0; width], row_v: None, filled_u: false }
    }

    /// The coordinates of row `y`, whose offsets are the inputs `du` and `du + 1`.
    pub(in crate::node) fn set(&mut self, domain: &Domain, ins: &Inputs<'_>, du: usize, y: i64) {
        // A constant offset around the body is the same in every row.
        if !self.filled_u {
            for (x, u) in self.us.iter_mut().enumerate() {
                *u = domain.u(x);
            }
            add_wrapped(ins.row(du, y), &mut self.us);
            self.filled_u = ins.constant(du).is_some();
        }
        let v = domain.v(y);
        self.row_v = ins.constant(du + 1).map(|dv| num::fract(v + dv));
        if let Some(v) = self.row_v {
            self.vs.fill(v);
        } else {
            self.vs.fill(v);
            add_wrapped(ins.row(du + 1, y), &mut self.vs);
        }
    }

    /// u of every texel, in [0, 1].
    pub(in crate::node) fn us(&self) -> &[f32] {
        &self.us
    }

    /// v of every texel, in [0, 1].
    pub(in crate::node) fn vs(&self) -> &[f32] {
        &self.vs
    }

    /// v of the whole row, where it is one.
    pub(in crate::node) fn row_v(&self) -> Option<f32> {
        self.row_v
    }
}

multiversion! {
    fn add_wrapped(offset: &[f32], at: &mut [f32]) {
        for (a, o) in at.iter_mut().zip(offset) { *a = num::fract(*a + *o); }
    }
}
