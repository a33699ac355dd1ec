//! Move, turn, tile and stretch.

use std::ops::Range;

use super::sample::Sampler;
use crate::base::Domain;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// How a stretch goes on towards the borders of the tile.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum StretchProfile {
    /// Full at the centre, undone towards the borders, which stay where they are: no seam. Stretches below 0.5 count
    /// as 0.5.
    #[default]
    Seamless,
    /// The same everywhere: what was at the borders is pushed out, and a seam shows unless the image is mirrored about
    /// its middle.
    Even,
}

/// Moves, turns, tiles and stretches an image about the centre of the tile.
///
/// The image goes on outside the tile as its own repetition. The result joins at the seams for any move, any number
/// of tiles, a seamless stretch, and turns by 180 degrees (on square tiles also by 90); other turns and even
/// stretches show a seam at the tile's border. Shrunk images are averaged over up to 8 x 8 points per texel.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Transform {
    /// Moves the image around the body (+u), as a fraction of the girth.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub offset_u: f32,
    /// Moves the image tail-ward (+v), as a fraction of the length.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "tile"))]
    pub offset_v: f32,
    /// Turns the image from +u towards +v; multiples of 90 join at the seams of square tiles, of 180 at all.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-unit" = "deg"))]
    pub angle: f32,
    /// How many times the image is repeated around the body.
    #[schemars(range(min = 1, max = 1000))]
    pub tiles_u: u32,
    /// How many times the image is repeated along the body.
    #[schemars(range(min = 1, max = 1000))]
    pub tiles_v: u32,
    /// Stretches the image from the centre, around the body; 1 leaves it, 2 doubles.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub stretch_u: f32,
    /// Stretches the image from the centre, along the body; 1 leaves it, 2 doubles.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub stretch_v: f32,
    /// How the stretch goes on towards the borders of the tile.
    pub profile: StretchProfile,
}

impl Default for Transform {
    fn default() -> Self {
        Self {
            offset_u: 0.0,
            offset_v: 0.0,
            angle: 0.0,
            tiles_u: 1,
            tiles_v: 1,
            stretch_u: 1.0,
            stretch_v: 1.0,
            profile: StretchProfile::default(),
        }
    }
}

/// Most points per texel and direction that a shrunk image is averaged over.
const MAX_POINTS: f64 = 8.0;

impl Transform {
    /// Cosine and sine of the angle, exact for quarter turns.
    fn direction(&self) -> (f64, f64) {
        match self.angle.rem_euclid(360.0) {
            0.0 => (1.0, 0.0),
            90.0 => (0.0, 1.0),
            180.0 => (-1.0, 0.0),
            270.0 => (0.0, -1.0),
            other => {
                let a = f64::from(other).to_radians();
                (libm::cos(a), libm::sin(a))
            }
        }
    }

    /// Where the image is looked up for a point, both in tile fractions from the centre.
    fn source(&self, domain: &Domain, (cos, sin): (f64, f64), p: [f64; 2]) -> [f64; 2] {
        let (girth, length) = (f64::from(domain.girth_mm), f64::from(domain.length_mm));
        // Each step undone, the last one first: move, turn (in mm), tile, stretch.
        let u = (p[0] - f64::from(self.offset_u)) * girth;
        let v = (p[1] - f64::from(self.offset_v)) * length;
        let u2 = (cos * u + sin * v) / girth * f64::from(self.tiles_u.max(1));
        let v2 = (cos * v - sin * u) / length * f64::from(self.tiles_v.max(1));
        [self.unstretch(u2, self.stretch_u), self.unstretch(v2, self.stretch_v)]
    }

    fn unstretch(&self, x: f64, stretch: f32) -> f64 {
        if stretch == 1.0 {
            return x;
        }
        match self.profile {
            StretchProfile::Even => x / f64::from(stretch.max(1e-3)),
            // Slope 1 / stretch at the centre and 2 - 1 / stretch at the border; x + 1 goes to its value + 1.
            StretchProfile::Seamless => {
                let squeeze = 1.0 - 1.0 / f64::from(stretch.max(0.5));
                x - squeeze * libm::sin(std::f64::consts::TAU * x) / std::f64::consts::TAU
            }
        }
    }

    /// Points per texel and direction that a texel is averaged over.
    fn points(&self) -> usize {
        let shrink = |stretch: f32, tiles: u32| {
            let s = f64::from(stretch);
            let steepest = match self.profile {
                StretchProfile::Even => 1.0 / s.max(1e-3),
                StretchProfile::Seamless => (1.0 / s.max(0.5)).max(2.0 - 1.0 / s.max(0.5)),
            };
            steepest * f64::from(tiles.max(1))
        };
        let shrink = shrink(self.stretch_u, self.tiles_u).max(shrink(self.stretch_v, self.tiles_v));
        (shrink - 0.01).ceil().clamp(1.0, MAX_POINTS) as usize
    }
}

impl Operation for Transform {
    const SPEC: Spec = Spec {
        name: "transform",
        summary: "Moves, turns, tiles and stretches an image.",
        inputs: &[InputSpec::image("image", "What is transformed.")],
        outputs: &[OutputSpec::same("result", "The transformed image.")],
        // It turns and stretches about the centre of the tile.
        positional: true,
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Anywhere
    }

    fn cost_ns(&self) -> f32 {
        20.0 * (self.points() as f32).powi(2)
    }

    fn forwards(&self) -> Option<usize> {
        let still = Self { profile: self.profile, ..Self::default() };
        (*self == still).then_some(0)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let sampler = Sampler::new(ins.scalar(0), domain.height);
        let (width, height) = (domain.width as f64, domain.height as f64);
        let direction = self.direction();
        let n = self.points();
        // Coordinates within 1e-9 of a texel centre are that centre: turns and moves by whole texels are exact.
        let snap = |x: f64| if (x - x.round()).abs() < 1e-9 { x.round() } else { x };
        let inside = |k: usize| (k as f64 + 0.5) / n as f64;
        for y in rows {
            for (x, out) in outs.only(y).iter_mut().enumerate() {
                let mut sum = 0.0f64;
                for j in 0..n {
                    for i in 0..n {
                        let p = [(x as f64 + inside(i)) / width - 0.5, (y as f64 + inside(j)) / height - 0.5];
                        let [u, v] = self.source(domain, direction, p);
                        let (sx, sy) = ((u + 0.5) * width - 0.5, (v + 0.5) * height - 0.5);
                        sum += f64::from(sampler.at(snap(sx), snap(sy)));
                    }
                }
                *out = (sum / (n * n) as f64) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_bands_agree, assert_finite, grid, max_difference, noise, run};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::Plane as P;
    use crate::node::Node;

    fn smooth(n: usize) -> Plane {
        let wave = |i: usize, k: f32| (std::f32::consts::TAU * k * (i as f32 + 0.5) / n as f32).sin();
        Plane::from_fn(n, n, |x, y| wave(x, 1.0) + 0.5 * wave(y, 2.0) + 0.3 * wave(x, 2.0) * wave(y, 1.0))
    }

    /// The greatest step from the last column to the first and from the last row to the first.
    fn seam(p: &Plane) -> f32 {
        let n = p.width() as i64;
        let across = |x: i64| (0..n).map(|y| (p.at(x, y) - p.at(x + 1, y)).abs()).fold(0.0, f32::max);
        let along = |y: i64| (0..n).map(|x| (p.at(x, y) - p.at(x, y + 1)).abs()).fold(0.0, f32::max);
        across(-1).max(along(-1))
    }

    #[test]
    fn the_default_is_the_identity_and_says_so() {
        let a = noise(9, 7, 1);
        assert!(run(&Transform::default(), &grid(9, 7), &[P(&a)]) == a);
        assert_eq!(Node::forwards(&Transform::default()), Some(0));
        assert_eq!(Node::forwards(&Transform { angle: 1.0, ..Transform::default() }), None);
    }

    #[test]
    fn quarter_turns_and_moves_by_texels_are_exact() {
        let a = noise(8, 8, 2);
        let turned = |angle| run(&Transform { angle, ..Transform::default() }, &grid(8, 8), &[P(&a)]);
        // From +u to +v: what was right of the centre is below it.
        assert!(turned(90.0) == Plane::from_fn(8, 8, |x, y| a.at(y as i64, 7 - x as i64)));
        assert!(turned(-180.0) == Plane::from_fn(8, 8, |x, y| a.at(7 - x as i64, 7 - y as i64)));
        let node = Transform { offset_u: 0.25, offset_v: -0.375, ..Transform::default() };
        assert!(run(&node, &grid(8, 8), &[P(&a)]) == a.shifted(2, -3));
    }

    #[test]
    fn tiles_repeat_and_keep_the_mean() {
        let a = smooth(32);
        let node = Transform { tiles_u: 2, tiles_v: 4, ..Transform::default() };
        let out = run(&node, &grid(32, 32), &[P(&a)]);
        assert!(max_difference(&out, &out.shifted(16, 8)) < 1e-5);
        assert!((crate::base::num::mean(out.data()) - crate::base::num::mean(a.data())).abs() < 1e-3);
    }

    #[test]
    fn a_seamless_stretch_magnifies_the_middle_without_a_seam_and_an_even_one_has_one() {
        let n = 64;
        let ramp = Plane::from_fn(n, n, |x, _| x as f32 + 0.5 - 32.0);
        for profile in [StretchProfile::Seamless, StretchProfile::Even] {
            let node = Transform { stretch_u: 2.0, profile, ..Transform::default() };
            let out = run(&node, &grid(n, n), &[P(&ramp)]);
            // Half as steep in the middle.
            assert!((out.at(33, 0) - out.at(30, 0) - 1.5).abs() < 0.05, "{profile:?}");
        }
        let of = |profile| {
            let node = Transform { stretch_u: 1.7, stretch_v: 1.7, profile, ..Transform::default() };
            seam(&run(&node, &grid(n, n), &[P(&smooth(n))]))
        };
        let (seamless, even) = (of(StretchProfile::Seamless), of(StretchProfile::Even));
        assert!(seamless < 0.4 && even > 0.8, "{seamless} {even}");
    }

    #[test]
    fn bands_agree_and_all_is_finite() {
        for angle in [0.0, 33.0] {
            for (stretch_u, profile) in [(0.01, StretchProfile::Even), (100.0, StretchProfile::Seamless)] {
                let node = Transform { angle, stretch_u, profile, tiles_v: 3, ..Transform::default() };
                assert_bands_agree(&node, &grid(13, 9), &[P(&noise(13, 9, 3))]);
                assert_finite(&node, &[]);
            }
        }
    }
}
