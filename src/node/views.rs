//! What a node's evaluation reads and writes.

use std::collections::BTreeMap;
use std::sync::Arc;

use smallvec::SmallVec;

use crate::base::{Plane, Rows};

/// An image file as planes: 1 (grey) or 3 (linear RGB) channels, values as stored, alpha apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset {
    /// 1 or 3 planes of equal size.
    pub channels: Vec<Plane>,
    /// Coverage in [0, 1], if the file has it.
    pub alpha: Option<Plane>,
}

/// Image files by the path that the preset names.
pub type Assets = BTreeMap<String, Arc<Asset>>;

/// The inputs of one evaluation, in the order of the node's spec.
#[derive(Debug)]
pub struct Inputs<'a> {
    /// First lane of each input, and one past the last.
    offsets: &'a [usize],
    lanes: &'a [Rows<'a>],
    /// The lane that lies in the output.
    over: Option<usize>,
}

impl<'a> Inputs<'a> {
    /// Inputs over lanes; input `i` owns lanes `offsets[i] .. offsets[i + 1]`.
    pub fn new(offsets: &'a [usize], lanes: &'a [Rows<'a>]) -> Self {
        debug_assert_eq!(offsets.last(), Some(&lanes.len()));
        Self { offsets, lanes, over: None }
    }

    /// The same, where the rows of scalar input `input` lie in the only output, to be written over: its lane is not read.
    pub fn over(self, input: Option<usize>) -> Self {
        Self { over: input.map(|input| self.offsets[input]), ..self }
    }

    /// Whether the rows of this input are those that lie in the output. It has no rows of its own then.
    #[inline]
    pub fn is_output(&self, input: usize) -> bool {
        self.over == Some(self.offsets[input])
    }

    /// The rows of a scalar (or per-channel) input.
    #[inline]
    pub fn scalar(&self, input: usize) -> Rows<'a> {
        self.lanes[self.offsets[input]]
    }

    /// The rows of a colour input, R G B.
    #[inline]
    pub fn color(&self, input: usize) -> [Rows<'a>; 3] {
        let first = self.offsets[input];
        [self.lanes[first], self.lanes[first + 1], self.lanes[first + 2]]
    }

    /// Row `y` of a scalar (or per-channel) input.
    #[inline]
    pub fn row(&self, input: usize, y: i64) -> &'a [f32] {
        self.scalar(input).row(y)
    }

    /// Row `y` of a colour input, R G B.
    #[inline]
    pub fn color_row(&self, input: usize, y: i64) -> [&'a [f32]; 3] {
        self.color(input).map(|lane| lane.row(y))
    }

    /// The value of a scalar input, where it is a constant.
    #[inline]
    pub fn constant(&self, input: usize) -> Option<f32> {
        self.scalar(input).constant()
    }
}

/// The lanes of outputs, those that nobody reads `None`: on the stack, as nodes have few and a band takes microseconds.
pub type OutputLanes<'a> = SmallVec<[Option<&'a mut [f32]>; 16]>;

/// The outputs of one evaluation: a band of rows of every wanted output.
#[derive(Debug)]
pub struct Outputs<'a> {
    /// First lane of each output, and one past the last.
    offsets: &'a [usize],
    lanes: OutputLanes<'a>,
    width: usize,
    first: i64,
}

impl<'a> Outputs<'a> {
    /// Outputs over lanes, each a band of rows that starts at torus row `first`; a lane that nobody reads is `None`.
    pub fn new(offsets: &'a [usize], lanes: OutputLanes<'a>, width: usize, first: i64) -> Self {
        debug_assert_eq!(offsets.last(), Some(&lanes.len()));
        Self { offsets, lanes, width, first }
    }

    /// Texels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether anybody reads this output.
    pub fn wants(&self, output: usize) -> bool {
        self.lanes[self.offsets[output]].is_some()
    }

    fn span(&self, y: i64) -> std::ops::Range<usize> {
        let start = (y - self.first) as usize * self.width;
        start..start + self.width
    }

    /// Row `y` of a scalar output, or `None` where nobody reads it.
    #[inline]
    pub fn row(&mut self, output: usize, y: i64) -> Option<&mut [f32]> {
        let span = self.span(y);
        self.lanes[self.offsets[output]].as_deref_mut().map(|lane| &mut lane[span])
    }

    /// Row `y` of the one output of a node with a single scalar (or per-channel) output.
    #[inline]
    pub fn only(&mut self, y: i64) -> &mut [f32] {
        self.row(0, y).expect("a node's only output is evaluated because it is wanted")
    }

    /// Row `y` of a colour output, R G B, or `None` where nobody reads it.
    #[inline]
    pub fn color_row(&mut self, output: usize, y: i64) -> Option<[&mut [f32]; 3]> {
        let span = self.span(y);
        let first = self.offsets[output];
        let [r, g, b] = self.lanes.get_disjoint_mut([first, first + 1, first + 2]).ok()?;
        match (r, g, b) {
            (Some(r), Some(g), Some(b)) => Some([&mut r[span.clone()], &mut g[span.clone()], &mut b[span]]),
            _ => None,
        }
    }

    /// Every lane's whole band, in order: for nodes that write many outputs in one pass.
    pub fn bands(&mut self) -> &mut [Option<&'a mut [f32]>] {
        &mut self.lanes
    }

    /// The whole band of a scalar output, or `None` where nobody reads it.
    pub fn band(&mut self, output: usize) -> Option<&mut [f32]> {
        self.lanes[self.offsets[output]].as_deref_mut()
    }
}
