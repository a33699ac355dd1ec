//! What the sections share while they add nodes.

use crate::node::Operation;
use crate::node::combine::{Mix, Multiply};
use crate::node::draft::{Draft, Wire};
use crate::node::filter::Levels;
use crate::node::generate::Fractal;
use crate::node::pattern::BodyPosition;
use crate::node::place::ScaleLattice;

/// The draft under construction and the measures that sections read.
pub(super) struct Lowering<'a> {
    pub(super) draft: &'a mut Draft,
    /// The lattice's first output; its ports carry the instance table.
    pub(super) scales: Wire,
    pub(super) lattice: ScaleLattice,
    pub(super) girth_mm: f32,
    pub(super) length_mm: f32,
    /// Mean width of a dorsal row, mm: the width pitch.
    pub(super) row_mm: f32,
    /// Length pitch, mm.
    pub(super) pitch_mm: f32,
    /// Share of the girth that the belly spans.
    pub(super) belly: f32,
    /// Pattern repeats in the tile.
    pub(super) repeats: u32,
}

impl Lowering<'_> {
    pub(super) fn add<T: Operation>(
        &mut self,
        name: impl Into<String>,
        node: T,
        inputs: &[(&str, Wire)],
    ) -> Wire {
        self.draft.add(name, node, inputs)
    }

    pub(super) fn mix(&mut self, name: impl Into<String>, a: Wire, b: Wire, mask: Wire) -> Wire {
        self.add(name, Mix::default(), &[("a", a), ("b", b), ("mask", mask)])
    }

    pub(super) fn multiply(&mut self, name: impl Into<String>, a: Wire, b: Wire) -> Wire {
        self.add(name, Multiply::default(), &[("a", a), ("b", b)])
    }

    /// Cells of a noise whose features are `size_mm` long, at least one.
    pub(super) fn cells(&self, size_mm: f32) -> (u32, u32) {
        let cells = |side: f32| ((side / size_mm.max(1e-6)).round() as u32).clamp(1, 4096);
        (cells(self.girth_mm), cells(self.length_mm))
    }

    /// The offsets to the scale's centre, times `amount`: what quantises a pattern to scales.
    pub(super) fn offsets(&mut self, amount: f32) -> (Wire, Wire) {
        let (du, dv) = (self.scales.port("du"), self.scales.port("dv"));
        if amount >= 1.0 {
            return (du, dv);
        }
        if amount <= 0.0 {
            return (0.0.into(), 0.0.into());
        }
        let name = |axis: &str| format!("quantise_{axis}_{:03}", (amount * 100.0).round() as u32);
        let mut once = |name: String, wire: Wire| {
            if self.draft.find(&name).is_some() {
                Wire::Output(name)
            } else {
                self.multiply(name, wire, amount.into())
            }
        };
        (once(name("du"), du), once(name("dv"), dv))
    }

    /// Noise in patches of `scales` scales, evaluated at scale centres by `quantise`, in [0, 1]; 0.5 where the image of `seen` is
    /// not between its bounds.
    pub(super) fn patches(
        &mut self,
        name: &str,
        scales: f32,
        octaves: u32,
        quantise: f32,
        seen: Option<(Wire, [f32; 2])>,
    ) -> Wire {
        let (cells_u, cells_v) = self.cells(scales * (self.pitch_mm * self.row_mm * 2.0).sqrt());
        let (du, dv) = self.offsets(quantise);
        let mut noise = Fractal { cells_u, cells_v, octaves, ..Fractal::default() };
        let mut inputs = vec![("du", du), ("dv", dv)];
        if let Some((image, [above, below])) = seen {
            noise = Fractal { above, below, ..noise };
            inputs.push(("where", image));
        }
        self.add(name, noise, &inputs)
    }

    /// Fine noise of `per_row` cells to a row width, in [0, 1].
    pub(super) fn grain(&mut self, name: &str, per_row: f32, octaves: u32) -> Wire {
        let (cells_u, cells_v) = self.cells(self.row_mm / per_row);
        self.add(name, Fractal { cells_u, cells_v, octaves, ..Fractal::default() }, &[])
    }

    /// `flank` units (0 mid-back, 1 the belly's edge) as the body's lateral position (1 is the belly's middle).
    pub(super) fn lateral(&self, flank: f32) -> f32 {
        flank * (1.0 - self.belly)
    }

    /// Lateral position at the scale's centre.
    fn position(&mut self) -> Wire {
        let name = "position";
        if self.draft.find(name).is_some() {
            return Wire::Output(name.into());
        }
        let (du, dv) = self.offsets(0.85);
        self.add(name, BodyPosition::default(), &[("du", du), ("dv", dv)])
    }

    /// 0 before `from`, 1 past `to` (falling where `from > to`), both in flanks.
    pub(super) fn lateral_ramp(&mut self, name: &str, from: f32, to: f32) -> Wire {
        let position = self.position();
        let (from, to) = (self.lateral(from), self.lateral(to));
        let (low, high, at_low, at_high) =
            if from <= to { (from, to, 0.0, 1.0) } else { (to, from, 1.0, 0.0) };
        self.add(
            name,
            Levels::default(),
            &[
                ("image", position),
                ("in_low", low.into()),
                ("in_high", (high.max(low + 1e-4)).into()),
                ("out_low", at_low.into()),
                ("out_high", at_high.into()),
            ],
        )
    }

    /// 1 on belly scutes, 0 elsewhere.
    pub(super) fn scute_mask(&mut self) -> Wire {
        let name = "scute_mask";
        if self.draft.find(name).is_some() {
            return Wire::Output(name.into());
        }
        let kind = self.scales.port("kind");
        self.add(name, Levels::default(), &[("image", kind), ("in_low", 1.4.into()), ("in_high", 1.6.into())])
    }

    /// `mask` on dorsal scales, 0 on scutes.
    pub(super) fn dorsal_only(&mut self, name: &str, mask: Wire) -> Wire {
        if self.lattice.ventrals == 0 {
            return mask;
        }
        let scutes = self.scute_mask();
        self.mix(name, mask, 0.0.into(), scutes)
    }
}
