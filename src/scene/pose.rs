//! How a snake lies: a drawing of its centre line on the ground, and what gravity makes of it.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::curve::{Curve, cumulative};

/// Distance of the points that a pose is drawn with, body diameters.
const STEP: f64 = 0.05;
/// Parts of the body closer than this along it touch anyway and do not lift each other, body diameters.
const NEIGHBOURHOOD: f64 = 2.0;
/// Length over which the body begins to rise before it meets what lies below, body diameters.
const RISE: f64 = 0.8;
/// Distance of a coil's turns as a share of their thickness.
const OVERLAP: f64 = 0.93;

/// How the body lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pose {
    /// Outstretched, the head to the left.
    Straight,
    /// In bends like a river's: a sine-generated curve (Langbein & Leopold 1966).
    Serpentine,
    /// At rest: a spiral, each turn against and a little upon the next one out, the head upon the outer turns.
    Coil,
    /// One loop that crosses itself, the fore part on top.
    Loop,
}

/// How far the body reaches from its centre line, body diameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// To each side.
    pub side: f64,
    /// Upwards.
    pub up: f64,
    /// Downwards.
    pub down: f64,
}

impl Pose {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Straight, Self::Serpentine, Self::Coil, Self::Loop];

    /// Its name in scene texts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Serpentine => "s",
            Self::Coil => "coil",
            Self::Loop => "loop",
        }
    }

    /// The pose of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|pose| pose.name() == name)
    }

    /// Length of a body that shows the pose well, in body diameters. Snakes have about 12 (a fat python) to 60 (a whip
    /// snake); a coil takes more of it than other poses do.
    pub const fn usual_length_in_diameters(self) -> f32 {
        match self {
            Self::Coil => 36.0,
            _ => 24.0,
        }
    }

    /// The centre line of a body of this length, snout first, around the y axis, resting on the plane y = 0.
    ///
    /// `extent` tells the body's reach at a distance from the snout. Where the drawing comes nearer to itself than the
    /// reaches allow, the fore part is laid upon the other. `None` if the length or an extent is not finite and positive.
    pub fn curve(self, length: f64, extent: impl Fn(f64) -> Extent) -> Option<Curve> {
        if !(length > 0.0 && length <= 1000.0) {
            return None;
        }
        let laid = laid(&self.drawing(length, &extent), length, &extent);
        Curve::through(&laid, length)
    }

    /// Points on the ground at about [`STEP`], snout first, at least `length` in all.
    fn drawing(self, length: f64, extent: &dyn Fn(f64) -> Extent) -> Vec<DVec2> {
        let heading: Box<dyn Fn(f64) -> f64> = match self {
            Self::Straight => Box::new(|_| 0.0),
            Self::Serpentine => {
                let waves = (length / 9.0).round().max(1.0);
                Box::new(move |s| 1.05 * libm::sin(TAU * (s / length) * waves))
            }
            Self::Loop => {
                // A bend of mean radius length/8.7 through 1.55 half turns: the ends cross nearly at right angles.
                Box::new(move |s| {
                    let x = s / length;
                    let wave = libm::sin(TAU * 1.5 * x);
                    1.55 * PI * smootherstep((x - 0.2) / 0.6) + 0.35 * wave
                })
            }
            Self::Coil => return coil(length, extent),
        };
        let mut place = DVec2::ZERO;
        let count = (length / STEP) as usize + 4;
        let points = (0..count).map(|i| {
            let angle = heading((i as f64 + 0.5) * STEP);
            let here = place;
            place += DVec2::new(libm::cos(angle), libm::sin(angle)) * STEP;
            here
        });
        points.collect()
    }
}

/// A spiral outwards whose turns are as far apart as the body is thick; before it the neck, which leaves its inner end and
/// crosses the turns, and the head, which lies upon them and looks at the viewer.
fn coil(length: f64, extent: &dyn Fn(f64) -> Extent) -> Vec<DVec2> {
    let fore = 3.9;
    let mut spiral = vec![];
    let (mut radius, mut angle, mut along) = (1.0, 0.0, fore);
    while along < length + 1.0 {
        spiral.push(DVec2::new(libm::cos(angle), libm::sin(angle)) * radius);
        // A little closer than side by side: each turn leans on the next one out.
        let growth = OVERLAP * extent(along).side / PI;
        let turn = STEP / (radius * radius + growth * growth).sqrt();
        radius += growth * turn;
        angle += turn;
        along += STEP;
    }
    let [a, b, c] = [spiral[0], spiral[1], spiral[2]];
    let curvature = libm::atan2((b - c).perp_dot(a - b), (b - c).dot(a - b)) / STEP;
    let mut heading = libm::atan2(a.y - b.y, a.x - b.x);
    let mut place = a;
    let mut points: Vec<DVec2> = (0..(fore / STEP) as usize)
        .map(|i| {
            // An S: out of the spiral, over its turns, and along them again.
            let s = (i as f64 + 0.5) * STEP;
            let bend = 1.0 - 1.4 * smootherstep(s / 1.3) + 1.5 * smootherstep((s - 1.2) / 1.6);
            heading += curvature * bend * STEP;
            place += DVec2::new(libm::cos(heading), libm::sin(heading)) * STEP;
            place
        })
        .collect();
    points.reverse();
    points.extend(spiral);
    let look = (points[0] - points[20]).normalize_or_zero();
    let turned = DVec2::new(0.6, 0.8).rotate(DVec2::new(look.x, -look.y));
    points.into_iter().map(|p| turned.rotate(p)).collect()
}

/// A step from 0 to 1 with two continuous derivatives (Perlin 2002).
fn smootherstep(x: f64) -> f64 {
    let x = x.max(0.0).min(1.0);
    x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
}

/// The drawing with heights: on the ground, or upon what lies there already; tail first, head last.
fn laid(drawing: &[DVec2], length: f64, extent: &dyn Fn(f64) -> Extent) -> Vec<DVec3> {
    let middle = {
        let count = ((length / STEP) as usize).min(drawing.len());
        let (low, high) = drawing[..count]
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        (low + high) * 0.5
    };
    let mut points: Vec<DVec3> =
        drawing.iter().map(|p| DVec3::new(p.x - middle.x, 0.0, p.y - middle.y)).collect();
    // Each layer settles on the one below it in one round; lengths change a little with the heights.
    for _ in 0..6 {
        let along = cumulative(&points);
        let reach: Vec<Extent> = along.iter().map(|&s| extent(s.min(length))).collect();
        let lifts: Vec<f64> = (0..points.len())
            .map(|i| {
                let below = (i + 1..points.len())
                    .filter(|&j| along[j] - along[i] > NEIGHBOURHOOD && along[j] <= length)
                    .map(|j| {
                        let apart = (points[j] - points[i]).with_y(0.0).length();
                        let share = apart / (reach[i].side + reach[j].side);
                        let rise = (reach[i].down + reach[j].up) * (1.0 - share * share).max(0.0).sqrt();
                        if share < 1.0 { points[j].y + rise - reach[i].down } else { 0.0 }
                    });
                below.fold(0.0, f64::max)
            })
            .collect();
        for ((point, lift), reach) in points.iter_mut().zip(eased(&lifts)).zip(&reach) {
            point.y = reach.down + lift;
        }
    }
    points
}

/// A smooth curve over `lifts`: the greatest within [`RISE`], averaged over the same window, so never below.
fn eased(lifts: &[f64]) -> Vec<f64> {
    let half = (RISE / STEP) as i64;
    let window = |values: &[f64], f: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
        let last = values.len() as i64 - 1;
        let at = |i: i64| values[i.max(0).min(last) as usize];
        (0..=last).map(|i| f(&(-half..=half).map(|k| at(i + k)).collect::<Vec<f64>>())).collect()
    };
    let greatest = window(lifts, &|near| near.iter().copied().fold(0.0, f64::max));
    // Weights (1 - x^2)^2: the mean has two continuous derivatives.
    let weight = |k: i64| {
        let x = k as f64 / (half as f64 + 1.0);
        (1.0 - x * x) * (1.0 - x * x)
    };
    let weights: Vec<f64> = (-half..=half).map(weight).collect();
    let total: f64 = weights.iter().sum();
    window(&greatest, &|near| near.iter().zip(&weights).map(|(lift, w)| w * lift).sum::<f64>() / total)
}
