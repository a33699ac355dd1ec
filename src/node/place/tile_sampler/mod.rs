//! The tile sampler: copies of an image or a built-in pattern over a grid.

mod instances;
mod paint;
mod pattern;
mod settings;
mod stamp;
#[cfg(test)]
mod tests;

use std::ops::Range;

use rayon::prelude::*;

use crate::base::Domain;
use crate::node::{
    Category, Cx, Fallback, InputSpec, Inputs, Operation, OutputSpec, Outputs, PortKind, Reach, Spec,
};

pub use pattern::PatternKind;
pub use settings::{
    Affect, Blending, Distribution, MaskSampling, OffsetType, Parametrization, SizeMode, Symmetry,
    TileSampler,
};

const PATTERN: usize = 0;
const SCALE_MAP: usize = 4;
const DISPLACEMENT_MAP: usize = 5;
const ROTATION_MAP: usize = 6;
const VECTOR_MAP_X: usize = 7;
const VECTOR_MAP_Y: usize = 8;
const COLOR_MAP: usize = 9;
const MASK_MAP: usize = 10;
const PATTERN_DISTRIBUTION_MAP: usize = 11;
const BACKGROUND: usize = 12;

/// A scalar image that may stay unset.
const fn map(name: &'static str, unset: f32, doc: &'static str) -> InputSpec {
    InputSpec {
        name,
        kind: PortKind::Scalar,
        fallback: Fallback::Scalar(unset),
        min: f32::MIN,
        max: f32::MAX,
        unit: "",
        doc,
    }
}

impl Operation for TileSampler {
    const SPEC: Spec = Spec {
        name: "tile_sampler",
        category: Category::Place,
        summary: "Scatters copies of an image or a built-in pattern over a grid, changed by numbers, chance and maps.",
        inputs: &[
            map("pattern", 1.0, "What is copied, for kind `input`: the whole tile goes into each copy."),
            map("pattern_2", 1.0, "A second image to copy."),
            map("pattern_3", 1.0, "A third image to copy."),
            map("pattern_4", 1.0, "A fourth image to copy."),
            map("scale_map", 1.0, "Scale of the copies, 1 as they are."),
            map("displacement_map", 0.0, "How far copies move along `displacement_angle`."),
            map("rotation_map", 0.0, "How far copies turn."),
            map("vector_map_x", 0.0, "Moves or turns copies: the vector's part along u."),
            map("vector_map_y", 0.0, "Moves or turns copies: the vector's part along v."),
            map("color_map", 1.0, "Value of the copies, for parametrisation `input`."),
            map("mask_map", 1.0, "Leaves out copies where it is below the threshold."),
            map("pattern_distribution_map", 0.0, "Which of the images is copied: 0 the first, 1 the last."),
            map("background", 0.0, "What lies beneath."),
        ],
        outputs: &[
            OutputSpec::scalar("value", "", "The copies over the background."),
            OutputSpec::scalar("id", "", "A random number in (0, 1] for each copy, 0 where there is none."),
            OutputSpec::scalar("index", "", "1 + the copy's number, row by row; 0 where there is none."),
            OutputSpec::scalar("s", "", "Place in the copy across it, 0 to 1, as its pattern lies."),
            OutputSpec::scalar("t", "", "Place in the copy along it, 0 to 1, as its pattern lies."),
        ],
        positional: true,
        random: true,
        // Numbers and places jump from copy to copy, sharp at every size.
        scale_tolerance: 0.2,
    };

    fn reach(&self, _: &Domain) -> Reach {
        // Whole, not Anywhere: the table of copies and the smaller stamps are made once, not for every band.
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        // Boxes overlap as their sizes say.
        let boxes = (self.size_x * self.size_y * self.scale * self.scale).max(0.1);
        let texel = if self.pattern_kind == PatternKind::Input { 25.0 } else { 12.0 };
        5.0 + texel * boxes
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        debug_assert_eq!(rows, 0..domain.height as i64, "a whole node gets all rows");
        let stamps: Vec<stamp::Stamp<'_>> =
            (PATTERN..PATTERN + 4).map(|i| stamp::Stamp::new(ins.scalar(i), domain.height)).collect();
        let table = instances::table(self, cx, ins);
        let lists = paint::by_band(&table, domain, &stamps);
        let scene = paint::Scene { node: self, domain, stamps: &stamps, table: &table };

        // One part of every wanted output per band.
        let chunk = paint::BAND * domain.width;
        let mut parts: Vec<paint::Lanes<'_>> = lists.iter().map(|_| [const { None }; 5]).collect();
        for (k, lane) in outs.bands().iter_mut().enumerate() {
            if let Some(lane) = lane {
                for (part, rows) in parts.iter_mut().zip(lane.chunks_mut(chunk)) {
                    part[k] = Some(rows);
                }
            }
        }
        parts.into_par_iter().zip(&lists).enumerate().for_each(|(band, (mut lanes, list))| {
            let first = band * paint::BAND;
            let count = paint::BAND.min(domain.height - first);
            for lane in lanes[1..].iter_mut().flatten() {
                lane.fill(0.0);
            }
            let mut value = Vec::with_capacity(count * domain.width);
            for y in first..first + count {
                // Sums with a background beyond this would overflow.
                value.extend(ins.row(BACKGROUND, y as i64).iter().map(|b| b.max(-1e30).min(1e30)));
            }
            scene.paint(list, first, &mut value, &mut lanes);
            if let Some(lane) = &mut lanes[0] {
                lane.copy_from_slice(&value);
            }
        });
    }
}
