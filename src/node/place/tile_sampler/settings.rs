//! Settings of the tile sampler, in the words of the industry's tile samplers.

use super::pattern::PatternKind;
use serde::{Deserialize, Serialize};

/// Scatters copies of an image or of a built-in pattern over a grid of cells, each changed by numbers, chance and maps.
///
/// Copies go on behind the seams, in both directions. Maps are read at the copies' places.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TileSampler {
    /// Copies around the body.
    #[schemars(range(min = 1, max = 1024))]
    pub x_amount: u32,
    /// Copies along the body.
    #[schemars(range(min = 1, max = 1024))]
    pub y_amount: u32,

    /// What a copy shows.
    pub pattern_kind: PatternKind,
    /// How many of the inputs `pattern` to `pattern_4` are used, for kind `input`.
    #[schemars(range(min = 1, max = 4))]
    pub pattern_input_number: u32,
    /// Which input a copy shows.
    pub pattern_input_distribution: Distribution,
    /// The built-in pattern's own number; see the kinds.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub pattern_specific: f32,
    /// Quarter turns of the pattern within its box.
    #[schemars(range(min = 0, max = 3))]
    pub pattern_rotation: u32,
    /// Part of the copies that get a random quarter turn more.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub pattern_rotation_random: f32,
    /// Part of the copies that are mirrored.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub symmetry_random: f32,
    /// How they are mirrored.
    pub symmetry_random_mode: Symmetry,

    /// What `size_x` and `size_y` are fractions of.
    pub size_mode: SizeMode,
    /// Width of a copy; 1 fills its cell.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub size_x: f32,
    /// Height of a copy; 1 fills its cell.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub size_y: f32,
    /// Part of the width that chance takes away at most.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub size_random_x: f32,
    /// Part of the height that chance takes away at most.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub size_random_y: f32,
    /// Scale of width and height together. A copy is never larger than two tiles.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub scale: f32,
    /// Part of the scale that chance takes away at most.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub scale_random: f32,
    /// How much `scale_map` multiplies the scale: 0 not at all, 1 fully.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub scale_map_multiplier: f32,
    /// What `scale_map` scales.
    pub scale_parametrization_affect: Affect,

    /// How far chance moves a copy, in cells: 0.5 at most half a cell to each side.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-unit" = "cell"))]
    pub position_random: f32,
    /// How far rows (or columns) are moved against each other, in cells: 0.5 with a quincunx is the brick bond.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "cell"))]
    pub offset: f32,
    /// What `offset` moves. A quincunx meets itself at the seam where the number of moved rows is even.
    pub offset_type: OffsetType,
    /// Moves everything around the body.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub global_offset_u: f32,
    /// Moves everything along the body.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub global_offset_v: f32,
    /// How far `displacement_map` = 1 moves a copy.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub displacement_map_intensity: f32,
    /// Where `displacement_map` moves it: 0 along u, 90 along v.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "deg"))]
    pub displacement_angle: f32,
    /// How far a vector of length 1 moves a copy.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub vector_map_displacement: f32,

    /// Turns every copy, from u towards v.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "deg"))]
    pub rotation: f32,
    /// How far chance turns a copy, to either side.
    #[schemars(range(min = 0.0, max = 180.0), extend("x-unit" = "deg"))]
    pub rotation_random: f32,
    /// How far `rotation_map` = 1 turns a copy.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "deg"))]
    pub rotation_map_multiplier: f32,
    /// How much of the vector's own angle a copy is turned by: 0 none, 1 it points along the vector.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub vector_map_multiplier: f32,

    /// Value of a copy: the pattern is multiplied with it.
    #[schemars(range(min = -100.0, max = 100.0))]
    pub color: f32,
    /// Part of the value that chance takes away at most.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub color_random: f32,
    /// What else the value depends on.
    pub color_parametrization_mode: Parametrization,
    /// How much it depends on that: 0 not at all, 1 fully.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub color_parametrization_multiplier: f32,

    /// Copies where `mask_map` is below this are left out.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub mask_map_threshold: f32,
    /// Leave out where the map is high instead.
    pub mask_map_invert: bool,
    /// Where `mask_map` is read.
    pub mask_map_sampling: MaskSampling,
    /// Part of the copies that chance leaves out.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub mask_random: f32,
    /// Show only the copies that would be left out.
    pub invert_mask: bool,

    /// How copies that overlap come together.
    pub blending: Blending,
    /// How opaque all copies are.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub global_opacity: f32,
    /// Paint the last copy first.
    pub reverse_rendering_order: bool,
}

impl Default for TileSampler {
    fn default() -> Self {
        Self {
            x_amount: 8,
            y_amount: 8,
            pattern_kind: PatternKind::Square,
            pattern_input_number: 1,
            pattern_input_distribution: Distribution::Random,
            pattern_specific: 0.0,
            pattern_rotation: 0,
            pattern_rotation_random: 0.0,
            symmetry_random: 0.0,
            symmetry_random_mode: Symmetry::Both,
            size_mode: SizeMode::Normal,
            size_x: 0.9,
            size_y: 0.9,
            size_random_x: 0.0,
            size_random_y: 0.0,
            scale: 1.0,
            scale_random: 0.0,
            scale_map_multiplier: 1.0,
            scale_parametrization_affect: Affect::Xy,
            position_random: 0.0,
            offset: 0.0,
            offset_type: OffsetType::HorizontalQuincunx,
            global_offset_u: 0.0,
            global_offset_v: 0.0,
            displacement_map_intensity: 0.1,
            displacement_angle: 0.0,
            vector_map_displacement: 0.1,
            rotation: 0.0,
            rotation_random: 0.0,
            rotation_map_multiplier: 360.0,
            vector_map_multiplier: 0.0,
            color: 1.0,
            color_random: 0.0,
            color_parametrization_mode: Parametrization::Input,
            color_parametrization_multiplier: 1.0,
            mask_map_threshold: 0.5,
            mask_map_invert: false,
            mask_map_sampling: MaskSampling::PatternCenter,
            mask_random: 0.0,
            invert_mask: false,
            blending: Blending::Max,
            global_opacity: 1.0,
            reverse_rendering_order: false,
        }
    }
}

/// Which pattern input a copy shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// By chance.
    Random,
    /// In turn, copy by copy.
    PatternIndex,
    /// In turn, row by row.
    RowIndex,
    /// In turn, column by column.
    ColumnIndex,
    /// By `pattern_distribution_map`: 0 the first, 1 the last.
    DistributionMap,
}

/// How a copy is mirrored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Either way or both, by chance.
    Both,
    /// Left and right change places.
    Horizontal,
    /// Head and tail change places.
    Vertical,
}

/// What a size is a fraction of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SizeMode {
    /// The cell's width and height.
    Normal,
    /// The cell's shorter side, in mm: a disc stays round.
    KeepRatio,
    /// The tile's shorter side, in mm, whatever the amounts.
    Absolute,
}

/// What a scale changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Affect {
    /// Width and height.
    Xy,
    /// The width.
    X,
    /// The height.
    Y,
}

/// What `offset` moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OffsetType {
    /// Every second row, around the body.
    HorizontalQuincunx,
    /// Every second column, along the body.
    VerticalQuincunx,
    /// Every row by as much more than the row before it.
    HorizontalGlobal,
    /// Every column by as much more than the column before it.
    VerticalGlobal,
}

/// What the value of a copy depends on; each runs from 0 to 1 and multiplies the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Parametrization {
    /// `color_map`.
    Input,
    /// A random number.
    Random,
    /// The scale, relative to `scale`.
    Scale,
    /// The number of the row.
    RowIndex,
    /// The number of the column.
    ColumnIndex,
    /// The number of the copy.
    PatternIndex,
    /// The place along the body.
    CenterPosition,
}

/// Where the mask map is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MaskSampling {
    /// At the copy's centre.
    PatternCenter,
    /// As the mean over the copy's box (25 points).
    BoundingBox,
}

/// How copies that overlap come together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Blending {
    /// They add up, on top of the background.
    Add,
    /// The greatest shows.
    Max,
    /// Later copies lie on top; the pattern is their opacity, their value is flat.
    Alpha,
    /// Later copies lie on top and hide all below where their pattern is above 0.
    Order,
}
