//! The built-in patterns of an instance.

use crate::base::{num, sdf};

/// What an instance shows. Patterns fill the instance's box; those without a straight edge touch its sides.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum PatternKind {
    /// The inputs `pattern` to `pattern_4`.
    Input,
    /// 1 in the whole box.
    #[default]
    Square,
    /// A flat disc.
    Disc,
    /// A round bowl upside down, 1 - r².
    Paraboloid,
    /// A round bell, flat at its top and its rim.
    Bell,
    /// A Gaussian bell whose sigma is 0.4 of the half size less 0.25 of `pattern_specific`; 0 at the rim.
    Gaussian,
    /// A sharp peak, (1 - r)².
    Thorn,
    /// Four straight sides.
    Pyramid,
    /// A flat box with sloping sides; `pattern_specific` is their width, 0 to the middle at 1.
    Brick,
    /// From 0 at the head's end to 1 at the tail's.
    Gradation,
    /// Waves across the box: one at `pattern_specific` 0, nine at 1.
    Waves,
    /// Half a bell, cut at its top: the cut faces the tail.
    HalfBell,
    /// A bell with a sharp ridge along its middle.
    RidgedBell,
    /// A disc without a second disc, which `pattern_specific` moves out from the middle.
    Crescent,
    /// A flat bar with round ends; `pattern_specific` narrows it.
    Capsule,
    /// A round cone, 1 - r.
    Cone,
}

/// Value in [0, 1] at (`x`, `y`) in [-1, 1]², `specific` in [0, 1], `texel` the width of an edge in these units.
pub(super) fn value(kind: PatternKind, x: f32, y: f32, specific: f32, texel: f32) -> f32 {
    let r = sdf::length(x, y);
    let inside = (1.0 - r).max(0.0);
    // Zero with zero slope at the rim.
    let bell = |r: f32| 0.5 + 0.5 * num::cos_turns(0.5 * r.min(1.0));
    let value = match kind {
        PatternKind::Input | PatternKind::Square => 1.0,
        PatternKind::Disc => sdf::coverage(r - 1.0, texel),
        PatternKind::Paraboloid => 1.0 - r * r,
        PatternKind::Bell => bell(r),
        PatternKind::Gaussian => {
            let sigma = 0.4 - 0.25 * specific;
            let at = |r: f32| num::exp(-0.5 * (r / sigma) * (r / sigma));
            (at(r) - at(1.0)) / (1.0 - at(1.0))
        }
        PatternKind::Thorn => inside * inside,
        PatternKind::Pyramid => 1.0 - x.abs().max(y.abs()),
        PatternKind::Brick => {
            let slope = specific.max(0.5 * texel).max(1e-6);
            (1.0 - x.abs().max(y.abs())) / slope
        }
        PatternKind::Gradation => 0.5 + 0.5 * y,
        PatternKind::Waves => {
            let waves = 1.0 + (8.0 * specific + 0.5).floor();
            0.5 + 0.5 * num::cos_turns(0.5 * waves * (x + 1.0) + 0.5)
        }
        PatternKind::HalfBell => bell(r) * sdf::coverage(y, texel),
        PatternKind::RidgedBell => bell(y.abs()) * (1.0 - x.abs()),
        PatternKind::Crescent => {
            let bite = sdf::disc(x - 0.25 - 1.5 * specific, y, 0.85);
            sdf::coverage((r - 1.0).max(-bite), texel)
        }
        PatternKind::Capsule => {
            let radius = 0.5 - 0.4 * specific;
            sdf::coverage(sdf::capsule(x, y, 1.0 - radius, radius), texel)
        }
        PatternKind::Cone => inside,
    };
    num::saturate(value)
}

#[cfg(test)]
pub(super) const ALL: [PatternKind; 16] = [
    PatternKind::Input,
    PatternKind::Square,
    PatternKind::Disc,
    PatternKind::Paraboloid,
    PatternKind::Bell,
    PatternKind::Gaussian,
    PatternKind::Thorn,
    PatternKind::Pyramid,
    PatternKind::Brick,
    PatternKind::Gradation,
    PatternKind::Waves,
    PatternKind::HalfBell,
    PatternKind::RidgedBell,
    PatternKind::Crescent,
    PatternKind::Capsule,
    PatternKind::Cone,
];
