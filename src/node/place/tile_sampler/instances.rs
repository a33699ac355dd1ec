//! The table of copies: where, how large, how turned, how bright.

use super::settings::{
    Affect, Distribution, MaskSampling, OffsetType, Parametrization, SizeMode, Symmetry, TileSampler,
};
use super::{
    COLOR_MAP, DISPLACEMENT_MAP, MASK_MAP, PATTERN_DISTRIBUTION_MAP, ROTATION_MAP, SCALE_MAP, VECTOR_MAP_X,
    VECTOR_MAP_Y,
};
use crate::base::{Domain, hash, num};
use crate::node::{Cx, Inputs};

/// One copy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instance {
    /// Centre, tile fractions in [0, 1].
    pub(super) u: f32,
    pub(super) v: f32,
    /// Half sizes before it is turned, mm.
    pub(super) half: [f32; 2],
    /// Cosine and sine of its rotation.
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// Value.
    pub(super) color: f32,
    /// Which pattern input it shows, from 0.
    pub(super) pattern: u32,
    /// Quarter turns of the pattern within the box.
    pub(super) quarter: u32,
    /// Mirrored left-right, head-tail.
    pub(super) flip: [bool; 2],
    /// Random number of its own in (0, 1].
    pub(super) id: f32,
    /// Number, row by row, from 0.
    pub(super) index: u32,
}

/// What a random number is for; each has its own stream.
#[derive(Clone, Copy)]
enum Chance {
    Id,
    PositionU,
    PositionV,
    SizeX,
    SizeY,
    Scale,
    Rotation,
    Color,
    Parameter,
    Mask,
    Pattern,
    Quarter,
    QuarterKind,
    Flip,
    FlipKind,
}

/// A map's value at a place, limited so that products with it stay finite.
fn read(ins: &Inputs<'_>, input: usize, domain: &Domain, u: f32, v: f32) -> f32 {
    let value = ins.scalar(input).bilinear(u * domain.width as f32, v * domain.height as f32);
    value.max(-1e15).min(1e15)
}

/// Every copy that is shown, in painting order.
pub(super) fn table(node: &TileSampler, cx: &Cx<'_>, ins: &Inputs<'_>) -> Vec<Instance> {
    let count = node.x_amount.max(1) as usize * node.y_amount.max(1) as usize;
    let mut table = Vec::with_capacity(count);
    for iy in 0..node.y_amount.max(1) {
        for ix in 0..node.x_amount.max(1) {
            table.extend(instance(node, cx, ins, ix, iy));
        }
    }
    if node.reverse_rendering_order {
        table.reverse();
    }
    table
}

/// The copy of cell (`ix`, `iy`), or `None` where it is masked or has no size.
fn instance(node: &TileSampler, cx: &Cx<'_>, ins: &Inputs<'_>, ix: u32, iy: u32) -> Option<Instance> {
    let domain = &cx.domain;
    let chance = |what: Chance| hash::hash2(hash::hash1(cx.seed, what as u32), ix, iy);
    let unit = |what: Chance| hash::unit(chance(what));
    let amount = [node.x_amount.max(1) as f32, node.y_amount.max(1) as f32];
    let index = iy * node.x_amount.max(1) + ix;

    // Place on the grid.
    let (mut gu, mut gv) = (ix as f32 + 0.5, iy as f32 + 0.5);
    match node.offset_type {
        OffsetType::HorizontalQuincunx => gu += node.offset * (iy % 2) as f32,
        OffsetType::VerticalQuincunx => gv += node.offset * (ix % 2) as f32,
        OffsetType::HorizontalGlobal => gu += num::fract(node.offset * iy as f32),
        OffsetType::VerticalGlobal => gv += num::fract(node.offset * ix as f32),
    }
    gu += node.position_random * hash::signed(chance(Chance::PositionU));
    gv += node.position_random * hash::signed(chance(Chance::PositionV));
    let u = num::fract(gu / amount[0] + node.global_offset_u);
    let v = num::fract(gv / amount[1] + node.global_offset_v);
    let map = |input: usize| read(ins, input, domain, u, v);

    // Size, mm.
    let cell = [domain.girth_mm / amount[0], domain.length_mm / amount[1]];
    let base = match node.size_mode {
        SizeMode::Normal => cell,
        SizeMode::KeepRatio => [cell[0].min(cell[1]); 2],
        SizeMode::Absolute => [domain.shorter_mm(); 2],
    };
    let by_map = num::lerp(1.0, map(SCALE_MAP).max(0.0), node.scale_map_multiplier);
    let (map_x, map_y) = match node.scale_parametrization_affect {
        Affect::Xy => (by_map, by_map),
        Affect::X => (by_map, 1.0),
        Affect::Y => (1.0, by_map),
    };
    let less = 1.0 - node.scale_random * unit(Chance::Scale);
    let scale = node.scale * less;
    let half = [
        0.5 * base[0] * node.size_x * (1.0 - node.size_random_x * unit(Chance::SizeX)) * scale * map_x,
        0.5 * base[1] * node.size_y * (1.0 - node.size_random_y * unit(Chance::SizeY)) * scale * map_y,
    ];
    let half = [half[0].min(domain.girth_mm), half[1].min(domain.length_mm)];

    // Displacement and rotation.
    let vector = [map(VECTOR_MAP_X), map(VECTOR_MAP_Y)];
    let push = node.displacement_map_intensity * map(DISPLACEMENT_MAP);
    let towards = node.displacement_angle / 360.0;
    let pull = node.vector_map_displacement;
    let shorter = domain.shorter_mm();
    let move_u = (push * num::cos_turns(towards) + pull * vector[0]) * shorter / domain.girth_mm;
    let move_v = (push * num::sin_turns(towards) + pull * vector[1]) * shorter / domain.length_mm;
    let turns = (node.rotation + node.rotation_random * hash::signed(chance(Chance::Rotation))) / 360.0
        + num::wrap_half(node.rotation_map_multiplier / 360.0 * map(ROTATION_MAP))
        + node.vector_map_multiplier * num::atan2_turns(vector[1], vector[0]);
    let turns = num::wrap_half(turns);

    // Left out?
    let mask = match node.mask_map_sampling {
        MaskSampling::PatternCenter => map(MASK_MAP),
        MaskSampling::BoundingBox => {
            let mean: f32 = (0..25)
                .map(|k| {
                    let (s, t) = ((k % 5) as f32 * 0.4 - 0.8, (k / 5) as f32 * 0.4 - 0.8);
                    let (du, dv) = (s * half[0] / domain.girth_mm, t * half[1] / domain.length_mm);
                    read(ins, MASK_MAP, domain, u + du, v + dv)
                })
                .sum();
            mean / 25.0
        }
    };
    let passes = (mask >= node.mask_map_threshold) != node.mask_map_invert;
    let shown = (passes && unit(Chance::Mask) >= node.mask_random) != node.invert_mask;
    if !shown || half[0] <= 0.0 || half[1] <= 0.0 {
        return None;
    }

    // Value.
    let parameter = match node.color_parametrization_mode {
        Parametrization::Input => map(COLOR_MAP),
        Parametrization::Random => unit(Chance::Parameter),
        Parametrization::Scale => less * by_map,
        Parametrization::RowIndex => iy as f32 / (amount[1] - 1.0).max(1.0),
        Parametrization::ColumnIndex => ix as f32 / (amount[0] - 1.0).max(1.0),
        Parametrization::PatternIndex => index as f32 / (amount[0] * amount[1] - 1.0).max(1.0),
        Parametrization::CenterPosition => v,
    };
    let color = node.color
        * (1.0 - node.color_random * unit(Chance::Color))
        * num::lerp(1.0, parameter, node.color_parametrization_multiplier);

    // Which input, how oriented.
    let patterns = node.pattern_input_number.clamp(1, 4);
    let pattern = match node.pattern_input_distribution {
        Distribution::Random => (unit(Chance::Pattern) * patterns as f32) as u32,
        Distribution::PatternIndex => index % patterns,
        Distribution::RowIndex => iy % patterns,
        Distribution::ColumnIndex => ix % patterns,
        Distribution::DistributionMap => {
            (num::saturate(map(PATTERN_DISTRIBUTION_MAP)) * patterns as f32) as u32
        }
    }
    .min(patterns - 1);
    let turned = unit(Chance::Quarter) < node.pattern_rotation_random;
    let quarter = node.pattern_rotation + if turned { 1 + chance(Chance::QuarterKind) % 3 } else { 0 };
    let kinds = match node.symmetry_random_mode {
        Symmetry::Horizontal => 1,
        Symmetry::Vertical => 2,
        Symmetry::Both => 1 + chance(Chance::FlipKind) % 3,
    };
    let flips = if unit(Chance::Flip) < node.symmetry_random { kinds } else { 0 };

    Some(Instance {
        u: num::fract(u + num::wrap_half(move_u)),
        v: num::fract(v + num::wrap_half(move_v)),
        half,
        cos: num::cos_turns(turns),
        sin: num::sin_turns(turns),
        color: color.max(-1e15).min(1e15),
        pattern,
        quarter: quarter % 4,
        flip: [flips & 1 != 0, flips & 2 != 0],
        id: ((chance(Chance::Id) >> 8) + 1) as f32 / 16_777_216.0,
        index,
    })
}
