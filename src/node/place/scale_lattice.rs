//! Every scale of the skin, placed once: the instance table that all maps share.

use std::ops::Range;

use super::scale_paint::{Band, paint};
use super::scale_table::Table;
use super::scale_write::{Line, write};
use crate::base::Domain;
use crate::base::kept::Kept;
use crate::node::{Category, Cx, Inputs, Operation, OutputSpec, Outputs, ParamError, Prepared, Spec};

/// Outline of a dorsal scale.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum ScaleShape {
    /// Lanceolate: two arcs that meet in a tip. Vipers, garter snakes.
    Leaf,
    /// A rhomb, smooth and close-set. Boas, pythons.
    #[default]
    Rhombus,
    /// Straight sides and a blunt tip, weak overlap. Coral snakes, kraits.
    Hexagon,
    /// A small cone that overlaps nothing. File snakes.
    Granule,
}

/// Places the scales: dorsal rows on a quincunx lattice, mirrored about the mid-back row, shingled like roof tiles,
/// and scutes across the belly.
///
/// Lengths are in pitches: the *length pitch* is the tile's length over `count`, the *width pitch* is the girth left by
/// the scutes over `rows`. A rhomb of one length pitch by two width pitches fills the lattice exactly.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScaleLattice {
    /// Lengthwise rows around the back and flanks; odd counts have a row on the mid-back. 13 (mamba) to 79 (python).
    #[schemars(range(min = 1, max = 1000))]
    pub rows: u32,
    /// Scales of one row along the tile.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u32,
    /// Scutes along the tile across the belly; 0 leaves the belly to the rows.
    #[schemars(range(min = 0, max = 100_000))]
    pub ventrals: u32,
    /// Share of the girth that the scutes span. 0.17 (python) to 0.34.
    #[schemars(range(min = 0.0, max = 0.8))]
    pub ventral_width: f32,
    /// Outline of the dorsal scales.
    pub shape: ScaleShape,
    /// Length of a scale beyond its pitch: what lies under the scale before it. 0.2 to 0.5; 0 does not shingle.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "pitch"))]
    pub overlap: f32,
    /// Size of every scale on the same lattice: below 1 they part and skin shows, above 1 they crowd.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub size: f32,
    /// Width of a scale against its length: above 1 is broader, below 1 narrower.
    #[schemars(range(min = 0.2, max = 2.0))]
    pub width: f32,
    /// Sharpness of the tip: 1 is a point, 0 is cut square. Rhombus and hexagon only.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub apex: f32,
    /// Rounding of the corners: 0 sharp, 1 as round as the scale allows.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roundness: f32,
    /// Width of the vertebral row against the others. 1.6 for a krait's hexagonal row.
    #[schemars(range(min = 0.5, max = 4.0))]
    pub vertebral: f32,
    /// Width of the lowest row against the mid-back; rows grow toward it. 1.3 to 1.6.
    #[schemars(range(min = 0.3, max = 4.0))]
    pub lowest: f32,
    /// Rows next to the scutes over which the width grows. 5 in pythons; a number past `rows` / 2 spreads it evenly.
    #[schemars(range(min = 1.0, max = 1000.0), extend("x-unit" = "rows"))]
    pub lowest_rows: f32,
    /// Slant of the rows away from the mid-back, tail-ward. 15 to 40 in racers, kraits, mambas.
    #[schemars(range(min = -60.0, max = 60.0), extend("x-unit" = "degrees"))]
    pub oblique_deg: f32,
    /// Height of a dorsal scale over its base, as a share of the length pitch. 0.04 to 0.12.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub relief: f32,
    /// Height of a scute over its base, as a share of its pitch. 0.08 to 0.1.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub ventral_relief: f32,
    /// Where along a scale it is highest, from base 0 to tip 1: a long ramp and a short drop. 0.72 to 0.86 measured.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub peak: f32,
    /// How much a scale falls off to its sides: 0 flat across, 1 down to the base.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub dome: f32,
    /// Width of the rounded rim, as a share of the width pitch. 0.1 is crisp, 0.4 is a cushion.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "pitch"))]
    pub bevel: f32,
    /// Height of the keel over the scale, as a share of the width pitch; 0 is smooth, 0.06 to 0.12 is keeled.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub keel: f32,
    /// Width of the keel, as a share of the scale's.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub keel_width: f32,
    /// How far the keel runs from the base toward the tip; weak keels stop short.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keel_length: f32,
    /// Share of the rows, from the mid-back down, that are keeled; it fades over the last fifth.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub keel_rows: f32,
    /// Random shift of each scale.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "pitch"))]
    pub jitter_position: f32,
    /// Random size of each scale, plus or minus.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub jitter_size: f32,
    /// Random turn of each scale, plus or minus.
    #[schemars(range(min = 0.0, max = 45.0), extend("x-unit" = "degrees"))]
    pub jitter_rotation_deg: f32,
    /// Random height of each scale, as a share of its relief, plus or minus.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub jitter_height: f32,
}

impl Default for ScaleLattice {
    fn default() -> Self {
        Self {
            rows: 21,
            count: 24,
            ventrals: 24,
            ventral_width: 0.3,
            shape: ScaleShape::Rhombus,
            overlap: 0.25,
            size: 1.0,
            width: 1.05,
            apex: 0.8,
            roundness: 0.25,
            vertebral: 1.0,
            lowest: 1.35,
            lowest_rows: 6.0,
            oblique_deg: 0.0,
            relief: 0.06,
            ventral_relief: 0.08,
            peak: 0.8,
            dome: 0.35,
            bevel: 0.14,
            keel: 0.0,
            keel_width: 0.16,
            keel_length: 0.9,
            keel_rows: 1.0,
            jitter_position: 0.02,
            jitter_size: 0.03,
            jitter_rotation_deg: 1.0,
            jitter_height: 0.1,
        }
    }
}

/// Most scales that one lattice may hold.
pub const MAX_SCALES: u64 = 4_000_000;

/// Indices of the outputs.
pub(super) mod port {
    pub(in super::super) const HEIGHT: usize = 0;
    pub(in super::super) const EDGE: usize = 1;
    pub(in super::super) const OUTLINE: usize = 2;
    pub(in super::super) const COVER: usize = 3;
    pub(in super::super) const S: usize = 4;
    pub(in super::super) const T: usize = 5;
    pub(in super::super) const DU: usize = 6;
    pub(in super::super) const DV: usize = 7;
    pub(in super::super) const RANDOM: usize = 8;
    pub(in super::super) const ID: usize = 9;
    pub(in super::super) const ROW: usize = 10;
    pub(in super::super) const COLUMN: usize = 11;
    pub(in super::super) const KIND: usize = 12;
    pub(in super::super) const COUNT: usize = 13;
}

impl Operation for ScaleLattice {
    const SPEC: Spec = Spec {
        name: "scale_lattice",
        category: Category::Place,
        summary: "Places the scales and scutes of a snake, overlapping like roof tiles; every map reads this table.",
        inputs: &[],
        outputs: &[
            OutputSpec::scalar(
                "height",
                "mm",
                "Height of the shingled scales over the skin between them, at least 0.",
            ),
            OutputSpec::scalar(
                "edge",
                "mm",
                "Distance to the nearest visible border of the scale, at least 0; 0 on skin.",
            ),
            OutputSpec::scalar(
                "outline",
                "mm",
                "Distance to the scale's own outline, covered parts included, at least 0; 0 on skin.",
            ),
            OutputSpec::scalar("cover", "", "1 on scales, 0 on the skin between them, anti-aliased."),
            OutputSpec::scalar("s", "", "Across the scale, from -1 to 1 at its widest; 0 on skin."),
            OutputSpec::scalar(
                "t",
                "",
                "Along the scale, from 0 at its covered base to 1 at its tip; 0 on skin.",
            ),
            OutputSpec::scalar(
                "du",
                "tile",
                "From the texel to the scale's centre, around the body; 0 on skin.",
            ),
            OutputSpec::scalar(
                "dv",
                "tile",
                "From the texel to the scale's centre, along the body; 0 on skin.",
            ),
            OutputSpec::scalar("random", "", "A random number of the scale in [0, 1); 0 on skin."),
            OutputSpec::scalar("id", "", "1 + the scale's index in the table; 0 on skin."),
            OutputSpec::scalar(
                "row",
                "rows",
                "Row from the mid-back, negative left; scutes lie half a row past the lowest.",
            ),
            OutputSpec::scalar("column", "", "Index of the scale along its row; 0 on skin."),
            OutputSpec::scalar("kind", "", "0 skin, 1 dorsal scale, 2 ventral scute."),
        ],
        positional: true,
        random: true,
        scale_tolerance: 0.25,
    };

    fn check(&self) -> Vec<ParamError> {
        let scales = u64::from(self.rows) * u64::from(self.count) + u64::from(self.ventrals);
        if scales > MAX_SCALES {
            return vec![ParamError::new(
                "count",
                format!("{} rows of {} scales are {scales} scales", self.rows, self.count),
                format!("a tile may hold {MAX_SCALES}: lower `rows` or `count`"),
            )];
        }
        Vec::new()
    }

    fn cost_ns(&self) -> f32 {
        14.0 * (1.0 + self.overlap)
    }

    fn own_bytes(&self, domain: &Domain, rows: usize) -> u64 {
        Band::bytes(domain, rows)
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(Places { table: Table::new(self, &cx.domain, cx.seed), room: Kept::new() }))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, _: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let Places { table, room } = cx.prepared();
        room.lend(
            || (Band::new(&cx.domain), Line::new(&cx.domain)),
            |(band, line)| {
                paint(table, &cx.domain, rows, band);
                write(table, &cx.domain, band, line, outs);
            },
        );
    }
}

/// What all bands share.
struct Places {
    table: Table,
    room: Kept<(Band, Line)>,
}

/// Physical size of a texel, for one-texel ramps, mm.
pub(super) fn texel_mm(domain: &Domain) -> f32 {
    domain.texel_u_mm().max(domain.texel_v_mm())
}
