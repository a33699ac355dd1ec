//! Gray-Scott reaction-diffusion.

use std::ops::Range;

use rayon::prelude::*;

use super::field::{Field, grid};
use crate::base::{hash, num};
use crate::multiversion;
use crate::node::generate::Coords;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, Inputs, Operation, OutputSpec, Outputs, ParamError, Prepared, Spec};

/// A stationary pattern of the Gray-Scott model, named by its look.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Reaction {
    /// Packed hexagonal spots, a quarter of the area (feed 0.0300, kill 0.0620).
    #[default]
    Spots,
    /// Even round spots (0.0367, 0.0649).
    EvenSpots,
    /// Sparser spots, for scattered marks (0.0350, 0.0650).
    SparseSpots,
    /// A maze of joined parallel lines: vermiculation (0.0290, 0.0570).
    Maze,
    /// Fingerprint lines (0.0370, 0.0600).
    Fingerprint,
    /// A connected net: reticulation (0.0400, 0.0600).
    Net,
    /// A labyrinth with closed rings: ocelli (0.0545, 0.0620).
    Rings,
    /// Short worms: mottling (0.0460, 0.0630).
    Worms,
    /// Separate dashes: streaks (0.0580, 0.0650).
    Dashes,
    /// Dark spots on light, hexagonal (0.0390, 0.0580).
    InverseSpots,
    /// Dark beans on light: blotches (0.0420, 0.0590).
    InverseBeans,
    /// Dark spots in clusters and chains (0.0500, 0.0600).
    Chains,
    /// Feed and kill as given by `feed` and `kill`.
    Custom,
}

impl Reaction {
    /// Feed and kill rates; `None` for custom ones. That each comes to rest is tested.
    pub fn rates(self) -> Option<(f32, f32)> {
        Some(match self {
            Self::Spots => (0.0300, 0.0620),
            Self::EvenSpots => (0.0367, 0.0649),
            Self::SparseSpots => (0.0350, 0.0650),
            Self::Maze => (0.0290, 0.0570),
            Self::Fingerprint => (0.0370, 0.0600),
            Self::Net => (0.0400, 0.0600),
            Self::Rings => (0.0545, 0.0620),
            Self::Worms => (0.0460, 0.0630),
            Self::Dashes => (0.0580, 0.0650),
            Self::InverseSpots => (0.0390, 0.0580),
            Self::InverseBeans => (0.0420, 0.0590),
            Self::Chains => (0.0500, 0.0600),
            Self::Custom => return None,
        })
    }
}

/// Spots, worms, mazes and nets that grow by reaction and diffusion, as pigment cells may lay them.
///
/// Solved once per plan on a grid of its own (about 12 texels per period, whatever the map's size) until it stands still,
/// then sampled smoothly, so the pattern is the same at every resolution. Costs about 0.1 s for eight cells.
///
/// Source: Pearson, "Complex Patterns in a Simple System" (1993): u' = Du lap u - u v^2 + F (1 - u),
/// v' = Dv lap v + u v^2 - (F + k) v with Du = 2 Dv. Only rates whose pattern comes to rest are accepted.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GrayScott {
    /// The kind of pattern.
    pub reaction: Reaction,
    /// Size: about so many periods of the pattern across the tile's shorter side. 4 to 16 are usual; 1 is one mark.
    #[schemars(range(min = 1, max = 64))]
    pub cells: u32,
    /// Makes the pattern so many times longer along the body: 0.5 flattens spots to bars, 2 draws them out.
    #[schemars(range(min = 0.25, max = 4.0))]
    pub stretch: f32,
    /// Feed rate F, only read when `reaction` is `custom`.
    #[schemars(range(min = 0.01, max = 0.1))]
    pub feed: f32,
    /// Kill rate k, only read when `reaction` is `custom`.
    #[schemars(range(min = 0.04, max = 0.07))]
    pub kill: f32,
}

impl Default for GrayScott {
    fn default() -> Self {
        Self { reaction: Reaction::Spots, cells: 8, stretch: 1.0, feed: 0.0300, kill: 0.0620 }
    }
}

/// Texels per period of the solver's grid, and the least where the grid would be too large.
const PERIOD: (f32, f32) = (12.0, 4.0);
/// The period that Du = 1 has with the nine-point Laplacian below, texels: measured, 17.7 for spots, 15.5 for lines;
/// it grows with sqrt(Du).
const NATURAL_PERIOD: f32 = 17.7;
/// Dv / Du.
const DIFFUSION_RATIO: f32 = 0.5;
/// Steps of [`GrayScott::STEP`] after which it stops in any case.
const MAX_STEPS: usize = 8_000;
/// Steps between looks at how much it still changes.
const LOOK: usize = 250;
/// It has come to rest when v changes by less than this per unit of time, on average over the tile.
const REST: f32 = 1e-5;
/// What still changes more than this after [`MAX_STEPS`] moves for ever (measured: 1.2e-4 and more; patterns that
/// still anneal: 2e-5).
const RESTLESS_CHANGE: f32 = 6e-5;

/// Rates whose patterns move, pulse or die, with what they do.
const RESTLESS: [(f32, f32, &str); 7] = [
    (0.034, 0.056, "never comes to rest"),
    (0.026, 0.051, "never comes to rest"),
    (0.018, 0.051, "never comes to rest"),
    (0.014, 0.054, "never comes to rest"),
    (0.025, 0.060, "never comes to rest"),
    (0.078, 0.061, "dies out"),
    (0.010, 0.041, "dies out"),
];

impl GrayScott {
    /// Time per step. Du * STEP stays below 1.25, where the explicit step of the Laplacian becomes unstable; what stands
    /// still does not depend on it.
    pub const STEP: f32 = 2.0;

    /// What [`Operation::prepare`] makes, in steps of another time in (0, [`GrayScott::STEP`]]: for as long, so with more
    /// of them.
    pub fn solved(&self, cx: &Cx<'_>, step: f32) -> Prepared {
        let (width, height, period) = grid(&cx.domain, self.cells, PERIOD.0, PERIOD.1, self.stretch);
        let mut solver = Solver::new(width, height, self.rates(), period, step);
        solver.seed(cx.seed, period);
        solver.settle((MAX_STEPS as f32 * Self::STEP / step) as usize);
        Box::new(solver.field())
    }

    fn rates(&self) -> (f32, f32) {
        self.reaction.rates().unwrap_or((self.feed, self.kill))
    }
}

impl Operation for GrayScott {
    const SPEC: Spec = Spec {
        name: "gray_scott",
        category: Category::Pattern,
        summary: "Spots, worms, mazes or nets grown by reaction and diffusion.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar(
            "value",
            "",
            "The pigment, 0 to 1: 1 in marks, 0 in the ground between; above 0.5 it is a mark.",
        )],
        random: true,
        ..Spec::GENERATOR
    };

    fn check(&self) -> Vec<ParamError> {
        if self.reaction != Reaction::Custom {
            return Vec::new();
        }
        let (feed, kill) = self.rates();
        let help = "take a named reaction, or rates near one, such as feed = 0.037, kill = 0.06";
        let near = |f: f32, k: f32| (feed - f).abs() < 0.0008 && (kill - k).abs() < 0.0008;
        let why = match RESTLESS.iter().find(|(f, k, _)| near(*f, *k)) {
            Some((_, _, why)) => why,
            // Out-of-range rates have their own message.
            None if !(0.01..=0.1).contains(&feed) || !(0.04..=0.07).contains(&kill) => return Vec::new(),
            None => match trial(feed, kill) {
                Outcome::Rests => return Vec::new(),
                Outcome::Moves => "never comes to rest",
                Outcome::Dies => "dies out",
            },
        };
        vec![ParamError::new("feed", format!("the pattern of feed = {feed}, kill = {kill} {why}"), help)]
    }

    fn cost_ns(&self) -> f32 {
        6.0
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(self.solved(cx, Self::STEP))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let field: &Field = cx.prepared();
        let mut at = Coords::new(cx.domain.width);
        let mut line = Vec::new();
        for y in rows {
            at.set(&cx.domain, ins, 0, y);
            field.sample(&at.all(), &mut line, outs.only(y));
        }
    }
}

/// What becomes of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Rests,
    Moves,
    Dies,
}

/// Solve a small tile and see whether the pattern rests.
fn trial(feed: f32, kill: f32) -> Outcome {
    let mut solver = Solver::new(48, 48, (feed, kill), 12.0, GrayScott::STEP);
    solver.seed(1, 12.0);
    let change = solver.settle(MAX_STEPS);
    let (lo, hi) = num::min_max(&solver.field_of_v());
    if hi - lo < 0.05 {
        Outcome::Dies
    } else if change > RESTLESS_CHANGE {
        Outcome::Moves
    } else {
        Outcome::Rests
    }
}

/// Rates of one step.
#[derive(Clone, Copy, Debug)]
struct Rates {
    /// Share of the Laplacian that a step adds to u and to v.
    du: f32,
    dv: f32,
    /// Feed and feed + kill, per step.
    feed: f32,
    loss: f32,
    /// Strength of the reaction, per step: its time.
    reaction: f32,
}

/// Two fields on the torus. Rows have one column more on each side, a copy of the opposite one.
struct Solver {
    width: usize,
    height: usize,
    rates: Rates,
    u: Vec<f32>,
    v: Vec<f32>,
    next_u: Vec<f32>,
    next_v: Vec<f32>,
}

impl Solver {
    /// The rest state u = 1, v = 0, for a pattern with about `period` texels per period, in steps of so much time.
    fn new(width: usize, height: usize, (feed, kill): (f32, f32), period: f32, step: f32) -> Self {
        let n = (width + 2) * height;
        let scale = period / NATURAL_PERIOD;
        let du = step * scale * scale;
        let rates = Rates {
            du,
            dv: du * DIFFUSION_RATIO,
            feed: step * feed,
            loss: step * (feed + kill),
            reaction: step,
        };
        let (u, v) = (vec![1.0; n], vec![0.0; n]);
        Self { width, height, rates, next_u: u.clone(), next_v: v.clone(), u, v }
    }

    /// Put blobs of v in about as many places as there are periods in the tile.
    fn seed(&mut self, seed: u32, period: f32) {
        let (w, h) = (self.width, self.height);
        let count = ((w * h) as f32 / (period * period)).ceil().max(1.0) as u32;
        let seed = hash::pcg(seed);
        let radius = 0.2 * period;
        let reach = radius.ceil() as i64;
        for i in 0..count {
            let cx = (hash::unit(hash::hash2(seed, i, 0)) * w as f32) as i64;
            let cy = (hash::unit(hash::hash2(seed, i, 1)) * h as f32) as i64;
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    if (dx * dx + dy * dy) as f32 <= radius * radius {
                        let x = (cx + dx).rem_euclid(w as i64) as usize;
                        let y = (cy + dy).rem_euclid(h as i64) as usize;
                        // A little noise, so that no symmetry holds the pattern up.
                        let noise = 0.05 * hash::unit(hash::hash2(seed ^ 0x55, x as u32, y as u32));
                        let at = y * (w + 2) + x + 1;
                        self.u[at] = 0.5;
                        self.v[at] = 0.25 + noise;
                    }
                }
            }
        }
        for y in 0..h {
            for field in [&mut self.u, &mut self.v] {
                wrap(&mut field[y * (w + 2)..(y + 1) * (w + 2)]);
            }
        }
    }

    /// Step until it rests, `steps` at most; returns the mean change of v per unit of time in the last step.
    fn settle(&mut self, steps: usize) -> f32 {
        let mut change = f32::MAX;
        for i in 1..=steps {
            self.step();
            if i % LOOK == 0 || i == steps {
                // The buffers hold the last two states.
                let sum: f64 = self.v.iter().zip(&self.next_v).map(|(a, b)| f64::from((a - b).abs())).sum();
                change = (sum / (self.v.len() as f64 * f64::from(self.rates.reaction))) as f32;
                if change < REST {
                    break;
                }
            }
        }
        change
    }

    /// One explicit Euler step of the whole torus. Rows only read the state before, so threads change nothing.
    fn step(&mut self) {
        let (stride, h) = (self.width + 2, self.height);
        let (u, v, rates) = (&self.u, &self.v, self.rates);
        let rows = |y: usize| [(y + h - 1) % h, y, (y + 1) % h].map(|y| y * stride..(y + 1) * stride);
        // Enough rows per task that handing it out costs little.
        let band = (8192 / stride).clamp(1, h) * stride;
        self.next_u.par_chunks_mut(band).zip(self.next_v.par_chunks_mut(band)).enumerate().for_each(
            |(i, (next_u, next_v))| {
                let first = i * band / stride;
                let outs = next_u.chunks_exact_mut(stride).zip(next_v.chunks_exact_mut(stride));
                for (k, (out_u, out_v)) in outs.enumerate() {
                    let at = rows(first + k);
                    row_step(at.clone().map(|r| &u[r]), at.map(|r| &v[r]), rates, out_u, out_v);
                    wrap(out_u);
                    wrap(out_v);
                }
            },
        );
        std::mem::swap(&mut self.u, &mut self.next_u);
        std::mem::swap(&mut self.v, &mut self.next_v);
    }

    /// v without the copied columns.
    fn field_of_v(&self) -> Vec<f32> {
        self.v.chunks_exact(self.width + 2).flat_map(|row| &row[1..=self.width]).copied().collect()
    }

    /// v, stretched to [0, 1]; 0 where it died out.
    fn field(&self) -> Field {
        let mut values = self.field_of_v();
        let (lo, hi) = num::min_max(&values);
        let scale = if hi - lo > 1e-3 { 1.0 / (hi - lo) } else { 0.0 };
        for v in &mut values {
            *v = num::saturate((*v - lo) * scale);
        }
        Field::new(self.width, self.height, values)
    }
}

/// Copy the first and last columns to the other side.
fn wrap(row: &mut [f32]) {
    let n = row.len();
    row[0] = row[n - 2];
    row[n - 1] = row[1];
}

/// The nine-point Laplacian with weights 0.2 (sides), 0.05 (corners), -1: 0.3 times the true one, nearly isotropic.
#[inline(always)]
fn laplacian(rows: [&[f32]; 3], x: usize) -> f32 {
    let [a, b, c] = rows;
    0.2 * ((a[x] + c[x]) + (b[x - 1] + b[x + 1])) + 0.05 * ((a[x - 1] + a[x + 1]) + (c[x - 1] + c[x + 1]))
        - b[x]
}

multiversion! {
    /// One step of a row. Values are held in [0, 1], so that no rate can make them grow without bound.
    fn row_step(u: [&[f32]; 3], v: [&[f32]; 3], rates: Rates, out_u: &mut [f32], out_v: &mut [f32]) {
        let n = out_u.len();
        let (u, v) = (u.map(|r| &r[..n]), v.map(|r| &r[..n]));
        let out_v = &mut out_v[..n];
        for x in 1..n - 1 {
            let (a, b) = (u[1][x], v[1][x]);
            let reaction = rates.reaction * a * b * b;
            let next_u = a + rates.du * laplacian(u, x) - reaction + rates.feed * (1.0 - a);
            let next_v = b + rates.dv * laplacian(v, x) + reaction - rates.loss * b;
            out_u[x] = num::saturate(next_u);
            out_v[x] = num::saturate(next_v);
        }
    }
}

#[cfg(test)]
mod tests;
