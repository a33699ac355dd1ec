//! Where on the tile each texel of a row is evaluated.

use std::borrow::Cow;
use std::ops::Range;

use crate::base::{Domain, num};
use crate::multiversion;
use crate::node::Inputs;

/// Wrapped coordinates of one row of texels, moved by the inputs `du`, `dv`; reused from row to row.
#[derive(Debug)]
pub(in crate::node) struct Coords {
    /// u of the columns, not moved.
    columns: Vec<f32>,
    us: Vec<f32>,
    /// v of the texels, where they have not all the same.
    vs: Vec<f32>,
    row_v: Option<f32>,
    /// The offset around the body, where it is a constant.
    du: Option<f32>,
}

impl Coords {
    /// Room for rows of `width` texels.
    pub(in crate::node) fn new(width: usize) -> Self {
        Self { columns: Vec::new(), us: vec![0.0; width], vs: vec![0.0; width], row_v: None, du: None }
    }

    /// The coordinates of row `y`, whose offsets are the inputs `du` and `du + 1`.
    pub(in crate::node) fn set(&mut self, domain: &Domain, ins: &Inputs<'_>, du: usize, y: i64) {
        if self.columns.is_empty() {
            self.columns = columns(domain, self.us.len());
        }
        // A constant offset around the body is the same in every row.
        let constant = ins.constant(du);
        if constant.is_none() || constant != self.du {
            moved(&self.columns, ins.row(du, y), &mut self.us);
            self.du = constant;
        }
        let v = domain.v(y);
        self.row_v = ins.constant(du + 1).map(|dv| num::fract(v + dv));
        if self.row_v.is_none() {
            moved_from(v, ins.row(du + 1, y), &mut self.vs);
        }
    }

    /// All texels of the row.
    pub(in crate::node) fn all(&self) -> Part<'_> {
        self.part(0..self.us.len())
    }

    /// Some texels of the row.
    pub(in crate::node) fn part(&self, texels: Range<usize>) -> Part<'_> {
        Part { row: self, texels }
    }
}

/// Neighbouring texels of a row.
#[derive(Clone, Debug)]
pub(in crate::node) struct Part<'a> {
    row: &'a Coords,
    texels: Range<usize>,
}

impl<'a> Part<'a> {
    /// Which texels of the row.
    pub(in crate::node) fn texels(&self) -> Range<usize> {
        self.texels.clone()
    }

    /// u of every texel, in [0, 1].
    pub(in crate::node) fn us(&self) -> &'a [f32] {
        &self.row.us[self.texels()]
    }

    /// u of the whole row's texels.
    pub(in crate::node) fn row_us(&self) -> &'a [f32] {
        &self.row.us
    }

    /// The offset around the body, where it is a constant: rows of the same one have the same `row_us`.
    pub(in crate::node) fn du(&self) -> Option<f32> {
        self.row.du
    }

    /// v of every texel, in [0, 1].
    pub(in crate::node) fn vs(&self) -> Cow<'a, [f32]> {
        match self.row.row_v {
            Some(v) => vec![v; self.texels.len()].into(),
            None => self.row.vs[self.texels()].into(),
        }
    }

    /// v of the whole row, where it is one.
    pub(in crate::node) fn row_v(&self) -> Option<f32> {
        self.row.row_v
    }
}

/// u of the first `len` columns, which may lie past the last one.
pub(in crate::node) fn columns(domain: &Domain, len: usize) -> Vec<f32> {
    let mut us = vec![0.0; len];
    fill_columns(domain, &mut us);
    us
}

multiversion! {
    fn fill_columns(domain: &Domain, us: &mut [f32]) {
        let width = domain.width as f32;
        // As `Domain::u`, of an index that takes one instruction to convert.
        for x in 0..us.len() { us[x] = (x as i32 as f32 + 0.5) / width; }
    }
}

multiversion! {
    fn moved(from: &[f32], by: &[f32], to: &mut [f32]) {
        for ((t, f), b) in to.iter_mut().zip(from).zip(by) { *t = num::fract(*f + *b); }
    }
}

multiversion! {
    fn moved_from(from: f32, by: &[f32], to: &mut [f32]) {
        for (t, b) in to.iter_mut().zip(by) { *t = num::fract(from + *b); }
    }
}
