//! The outline of a mask as a line of given width.

use std::ops::Range;

use rayon::prelude::*;

use super::distance::LEVEL_INPUT;
use super::edt::{LengthUnit, own_bytes, signed_distance};
use crate::base::Domain;
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Where the line lies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// Within the mask.
    Inside,
    /// Half within, half without.
    #[default]
    Centred,
    /// Around the mask.
    Outside,
}

/// A line of even width along the outline of a mask, anti-aliased, through the seams; a line thinner than a texel
/// fades by its width, down to nothing at 0.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Outline {
    /// Where the line lies.
    pub placement: Placement,
    /// What `width` is measured in.
    pub unit: LengthUnit,
}

const MASK: usize = 0;
const LEVEL: usize = 1;
const WIDTH: usize = 2;

impl Operation for Outline {
    const SPEC: Spec = Spec {
        name: "outline",
        summary: "Draws the outline of a mask as a line of given width.",
        inputs: &[
            InputSpec::plane("mask", "", "The mask."),
            LEVEL_INPUT,
            InputSpec::drive(
                "width",
                0.005,
                (0.0, 1000.0),
                "tile or mm",
                "Width of the line, in tile fractions or mm by `unit`; 0.002 to 0.02 tile.",
            ),
        ],
        outputs: &[OutputSpec::scalar("line", "", "Coverage by the line, in [0, 1].")],
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Whole
    }

    fn cost_ns(&self) -> f32 {
        31.0
    }

    fn own_bytes(&self, domain: &Domain, _: usize) -> u64 {
        own_bytes(domain)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let width = outs.width();
        let Some(out) = outs.band(0) else { return };
        signed_distance(&cx.domain, ins, MASK, LEVEL, out);
        let texel = cx.domain.texel_mm();
        let unit = self.unit.mm(&cx.domain) / texel;
        let (inside, outside) = match self.placement {
            Placement::Inside => (1.0, 0.0),
            Placement::Centred => (0.5, 0.5),
            Placement::Outside => (0.0, 1.0),
        };
        let widths = ins.scalar(WIDTH);
        out.par_chunks_mut(width).enumerate().for_each(|(i, out)| {
            kernel(widths.row(rows.start + i as i64), unit, 1.0 / texel, inside, outside, out);
        });
    }
}

multiversion! {
    // `out` holds the signed distance in mm.
    fn kernel(width: &[f32], unit: f32, per_texel: f32, inside: f32, outside: f32, out: &mut [f32]) {
        for (o, w) in out.iter_mut().zip(width) {
            let d = *o * per_texel;
            let w = (w.max(0.0) * unit).min(1e30);
            // The part of a texel-wide box around d that lies in the line.
            *o = ((d + 0.5).min(w * outside) - (d - 0.5).max(-w * inside)).max(0.0).min(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_finite, grid, run};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Unset, Value};

    /// A band of texels 10 to 29 of 40, hard, 1 mm each.
    fn band() -> Plane {
        Plane::from_fn(40, 6, |x, _| f32::from(u8::from((10..30).contains(&x))))
    }

    fn line(placement: Placement, width: f32) -> Plane {
        let node = Outline { placement, unit: LengthUnit::Mm };
        run(&node, &grid(40, 6), &[P(&band()), Unset, Value(width)])
    }

    #[test]
    fn the_line_has_its_width_on_its_side() {
        for (placement, first) in [(Placement::Inside, 10), (Placement::Centred, 8), (Placement::Outside, 6)]
        {
            let out = line(placement, 4.0);
            for x in 0..20 {
                let on = (first..first + 4).contains(&x);
                assert!((out.at(x, 3) - f32::from(u8::from(on))).abs() < 1e-4, "{placement:?} {x}");
            }
        }
    }

    #[test]
    fn the_amount_of_line_is_its_width_at_any_width_and_none_at_0() {
        for placement in [Placement::Inside, Placement::Centred, Placement::Outside] {
            for width in [0.0, 0.1, 0.7, 1.0, 2.5, 7.3] {
                let sum: f32 = line(placement, width).row(2).iter().sum();
                assert!((sum - 2.0 * width).abs() < 1e-3, "{placement:?} {width}: {sum}");
            }
        }
    }

    #[test]
    fn tile_fractions_count_the_shorter_side() {
        let node = Outline::default();
        let out = run(&node, &grid(40, 6), &[P(&band()), Unset, Value(0.5)]);
        assert!((out.row(0).iter().sum::<f32>() - 6.0).abs() < 1e-3);
    }

    #[test]
    fn it_is_finite() {
        for width in [0.0, 1e30, -1.0, f32::MAX] {
            assert_finite(&Outline::default(), &[Unset, Value(width)]);
        }
    }
}
