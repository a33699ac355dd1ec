//! Young's cellular automaton.

use std::ops::Range;

use rayon::prelude::*;

use super::field::{Field, grid};
use crate::base::hash;
use crate::node::generate::Coords;
use crate::node::spec::OFFSETS;
use crate::node::{Category, Cx, Inputs, Operation, OutputSpec, Outputs, ParamError, Prepared, Spec};

/// A pattern of Young's automaton, named by its look.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// Separate spots, a third of the area (weight -0.34).
    #[default]
    Spots,
    /// Spots and beans (-0.30).
    Beans,
    /// Worms, nearly half of the area (-0.24).
    Worms,
    /// A labyrinth, half and half (-0.22).
    Labyrinth,
    /// A net of marks (-0.20).
    Net,
    /// A dark surface with small holes (-0.16).
    Holes,
    /// Stripes along the body: the activator reaches 1.6 times farther along it (-0.43).
    Stripes,
    /// Bars across the body: the inhibitor reaches 1.6 times farther along it (-0.141).
    Bars,
    /// As given by `weight`, `activator_stretch` and `inhibitor_stretch`.
    Custom,
}

/// Irregular spots, worms, labyrinths, stripes and bars from cells that excite near and inhibit far neighbours.
///
/// Much cheaper than reaction-diffusion. Solved once per plan on a grid of its own (about 10 texels per period,
/// whatever the map's size), then sampled smoothly; `value` above 0.5 is the mark.
///
/// Source: David Young, "A local activator-inhibitor model of vertebrate skin patterns" (1984): a cell turns on where
/// the sum over the others within 2.30 texels (+1 each) and beyond that within 6.01 (`weight` each) is positive, off
/// where it is negative; repeated from 5 % random cells until nothing changes.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct YoungAutomaton {
    /// The kind of pattern.
    pub activation: Activation,
    /// Size: about so many periods of the pattern across the tile's shorter side. 4 to 24 are usual.
    #[schemars(range(min = 1, max = 128))]
    pub cells: u32,
    /// Weight of the inhibitor, only read for `custom`: -0.34 spots, -0.24 worms, -0.16 holes.
    #[schemars(range(min = -1.0, max = -0.01))]
    pub weight: f32,
    /// How many times farther the activator reaches along the body than around it, only read for `custom`. Make
    /// `weight` stronger in proportion.
    #[schemars(range(min = 1.0, max = 2.5))]
    pub activator_stretch: f32,
    /// How many times farther the inhibitor reaches along the body, only read for `custom`. Make `weight` weaker in
    /// proportion.
    #[schemars(range(min = 1.0, max = 2.5))]
    pub inhibitor_stretch: f32,
}

impl Default for YoungAutomaton {
    fn default() -> Self {
        Self {
            activation: Activation::Spots,
            cells: 8,
            weight: -0.34,
            activator_stretch: 1.0,
            inhibitor_stretch: 1.0,
        }
    }
}

/// Radii of the activator and the inhibitor, texels of the solver's grid.
const NEAR: f32 = 2.30;
const FAR: f32 = 6.01;
/// Period of the pattern, texels of the solver's grid.
const PERIOD: f32 = 10.0;
/// Passes after which it stops in any case; 10 to 20 are usual.
const MAX_PASSES: usize = 60;
/// Share of cells that are on at the start.
const SEEDS: f32 = 0.05;

impl YoungAutomaton {
    /// Weight and stretches.
    fn rule(&self) -> (f32, f32, f32) {
        match self.activation {
            Activation::Spots => (-0.34, 1.0, 1.0),
            Activation::Beans => (-0.30, 1.0, 1.0),
            Activation::Worms => (-0.24, 1.0, 1.0),
            Activation::Labyrinth => (-0.22, 1.0, 1.0),
            Activation::Net => (-0.20, 1.0, 1.0),
            Activation::Holes => (-0.16, 1.0, 1.0),
            Activation::Stripes => (-0.43, 1.6, 1.0),
            Activation::Bars => (-0.141, 1.0, 1.6),
            Activation::Custom => (self.weight, self.activator_stretch, self.inhibitor_stretch),
        }
    }
}

impl Operation for YoungAutomaton {
    const SPEC: Spec = Spec {
        name: "young_automaton",
        category: Category::Pattern,
        summary: "Irregular spots, worms, stripes or bars from a cellular automaton.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[OutputSpec::scalar(
            "value",
            "",
            "The pigment, 0 to 1, smooth across outlines: above 0.5 it is a mark.",
        )],
        random: true,
        ..Spec::GENERATOR
    };

    fn check(&self) -> Vec<ParamError> {
        let (weight, near, far) = self.rule();
        let (activator, inhibitor) = discs(near, far);
        let balance = weight * inhibitor.count() as f32 / activator.count() as f32;
        // At -1 a fully covered surface holds itself; far below -2 lone cells die.
        let message = |what: &str| {
            vec![ParamError::new(
                "weight",
                format!(
                    "weight = {weight} {what}: the inhibitor has {:.2} times the activator's strength",
                    -balance
                ),
                "choose the weight so that it has 0.8 to 2 times; 1.4 makes worms",
            )]
        };
        if self.activation != Activation::Custom {
            Vec::new()
        } else if balance > -0.65 {
            message("floods the surface")
        } else if balance < -2.2 {
            message("dies out")
        } else {
            Vec::new()
        }
    }

    fn cost_ns(&self) -> f32 {
        6.0
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        let (width, height, _) = grid(&cx.domain, self.cells, PERIOD, PERIOD * 0.25, 1.0);
        let (weight, near, far) = self.rule();
        Some(Box::new(solve(width, height, weight, near, far, cx.seed).0))
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

/// A set of offsets as one run per row: (dy, first dx, last dx).
#[derive(Clone, Debug, PartialEq)]
struct Runs(Vec<(i64, i64, i64)>);

impl Runs {
    /// The ellipse with semi-axes `r` around and `r * stretch` along the body.
    fn ellipse(r: f32, stretch: f32) -> Self {
        let along = r * stretch.max(1.0).min(2.5);
        let reach = along.floor() as i64;
        Self(
            (-reach..=reach)
                .map(|dy| {
                    let y = dy as f32 / along;
                    let half = (r * (1.0 - y * y).max(0.0).sqrt()).floor() as i64;
                    (dy, -half, half)
                })
                .collect(),
        )
    }

    fn count(&self) -> i64 {
        self.0.iter().map(|(_, a, b)| b - a + 1).sum()
    }
}

/// The ring that inhibits has the activator's cells too, so it is counted by their difference.
#[derive(Clone, Debug)]
struct Ring {
    outer: Runs,
    inner: Runs,
}

impl Ring {
    fn count(&self) -> i64 {
        self.outer.count() - self.inner.count()
    }
}

/// The activator's disc and the inhibitor's ring around it.
fn discs(activator_stretch: f32, inhibitor_stretch: f32) -> (Runs, Ring) {
    let inner = Runs::ellipse(NEAR, activator_stretch);
    (inner.clone(), Ring { outer: Runs::ellipse(FAR, inhibitor_stretch), inner })
}

/// Cells that are on, counted along each row from its start: sums over runs are differences.
struct Sums {
    width: i64,
    height: i64,
    /// `width + 1` per row.
    counts: Vec<i32>,
}

impl Sums {
    fn new(width: usize, height: usize, on: &[bool]) -> Self {
        let mut counts = Vec::with_capacity((width + 1) * height);
        for row in on.chunks_exact(width) {
            let mut sum = 0;
            counts.push(0);
            for &cell in row {
                sum += i32::from(cell);
                counts.push(sum);
            }
        }
        Self { width: width as i64, height: height as i64, counts }
    }

    /// Cells on in columns before `x` of a row, where the row repeats for ever.
    fn before(&self, row: &[i32], x: i64) -> i64 {
        let turns = x.div_euclid(self.width);
        turns * i64::from(row[self.width as usize]) + i64::from(row[x.rem_euclid(self.width) as usize])
    }

    fn over(&self, runs: &Runs, x: i64, y: i64) -> i64 {
        let stride = self.width as usize + 1;
        runs.0
            .iter()
            .map(|&(dy, a, b)| {
                let y = (y + dy).rem_euclid(self.height) as usize;
                let row = &self.counts[y * stride..(y + 1) * stride];
                self.before(row, x + b + 1) - self.before(row, x + a)
            })
            .sum()
    }
}

/// The pattern, and the passes it took.
fn solve(width: usize, height: usize, weight: f32, near: f32, far: f32, seed: u32) -> (Field, usize) {
    let (activator, inhibitor) = discs(near, far);
    // The rule in whole numbers, so that no sum depends on its order.
    let weight = (f64::from(weight) * 65_536.0).round() as i64;
    let seed = hash::pcg(seed);
    let mut on: Vec<bool> =
        (0..width * height).map(|i| hash::unit(hash::hash1(seed, i as u32)) < SEEDS).collect();
    let mut before: Vec<bool> = Vec::new();
    for pass in 1..=MAX_PASSES {
        let sums = Sums::new(width, height, &on);
        let mut next = on.clone();
        next.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, cell) in row.iter_mut().enumerate() {
                let (x, y) = (x as i64, y as i64);
                let close = sums.over(&activator, x, y);
                let wide = sums.over(&inhibitor.outer, x, y) - sums.over(&inhibitor.inner, x, y);
                let field = close * 65_536 + wide * weight;
                if field != 0 {
                    *cell = field > 0;
                }
            }
        });
        // Rest, or two states in turn.
        let done = next == on || next == before;
        before = std::mem::replace(&mut on, next);
        if done {
            return (field(width, height, &on), pass);
        }
    }
    (field(width, height, &on), MAX_PASSES)
}

fn field(width: usize, height: usize, on: &[bool]) -> Field {
    Field::new(width, height, on.iter().map(|&b| f32::from(u8::from(b))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(field: &Field) -> f64 {
        crate::base::num::mean(&field.values())
    }

    /// Steps between on and off, around and along the body.
    fn outlines(f: &Field) -> (usize, usize) {
        let (w, h, values) = (f.width, f.height, f.values());
        let mut n = (0, 0);
        for y in 0..h {
            for x in 0..w {
                let at = |x: usize, y: usize| values[(y % h) * w + x % w] > 0.5;
                n.0 += usize::from(at(x, y) != at(x + 1, y));
                n.1 += usize::from(at(x, y) != at(x, y + 1));
            }
        }
        n
    }

    /// Shares measured by an independent program on a grid of 192 x 192.
    #[test]
    fn the_weights_cover_the_published_shares() {
        for (weight, expected) in
            [(-0.34, 0.31), (-0.24, 0.46), (-0.22, 0.51), (-0.20, 0.57), (-0.18, 0.67), (-0.16, 0.82)]
        {
            let (field, passes) = solve(128, 128, weight, 1.0, 1.0, 2);
            let on = share(&field);
            assert!((on - expected).abs() < 0.05, "{weight}: {on}, expected {expected}");
            assert!(passes <= 50, "{weight}: {passes} passes");
        }
    }

    #[test]
    fn discs_have_the_number_of_points_that_their_radii_enclose() {
        let brute = |r: f32| {
            (-7i64..=7)
                .flat_map(|y| (-7i64..=7).map(move |x| (x, y)))
                .filter(|(x, y)| ((x * x + y * y) as f32) <= r * r)
                .count()
        };
        let (near, ring) = discs(1.0, 1.0);
        assert_eq!(near.count(), brute(NEAR) as i64);
        assert_eq!(ring.count(), (brute(FAR) - brute(NEAR)) as i64);
    }

    #[test]
    fn run_sums_are_sums_over_the_torus_also_on_tiny_ones() {
        for (w, h) in [(1, 1), (4, 4), (5, 9), (30, 17)] {
            let on: Vec<bool> = (0..w * h).map(|i| hash::pcg(i as u32) & 3 == 0).collect();
            let sums = Sums::new(w, h, &on);
            let runs = Runs::ellipse(FAR, 1.6);
            for y in 0..h as i64 {
                for x in 0..w as i64 {
                    let mut sum = 0;
                    for &(dy, a, b) in &runs.0 {
                        for dx in a..=b {
                            let (x, y) = ((x + dx).rem_euclid(w as i64), (y + dy).rem_euclid(h as i64));
                            sum += i64::from(on[y as usize * w + x as usize]);
                        }
                    }
                    assert_eq!(sums.over(&runs, x, y), sum);
                }
            }
        }
    }

    #[test]
    fn stripes_run_along_and_bars_across_the_body() {
        let rule = |activation| YoungAutomaton { activation, ..YoungAutomaton::default() }.rule();
        let (w, a, i) = rule(Activation::Stripes);
        let (u, v) = outlines(&solve(96, 96, w, a, i, 1).0);
        assert!(u > 2 * v, "stripes: {u} {v}");
        let (w, a, i) = rule(Activation::Bars);
        let (u, v) = outlines(&solve(96, 96, w, a, i, 1).0);
        assert!(5 * u < 4 * v, "bars: {u} {v}");
        let (w, a, i) = rule(Activation::Worms);
        let (u, v) = outlines(&solve(96, 96, w, a, i, 1).0);
        assert!((u as f64 / v as f64 - 1.0).abs() < 0.2, "worms have no direction: {u} {v}");
    }

    #[test]
    fn weights_that_flood_or_die_are_refused_and_do() {
        let custom =
            |weight| YoungAutomaton { activation: Activation::Custom, weight, ..YoungAutomaton::default() };
        assert!(custom(-0.34).check().is_empty() && custom(-0.16).check().is_empty());
        assert!(custom(-0.1).check()[0].message.contains("floods"));
        assert!(custom(-0.9).check()[0].message.contains("dies"));
        assert!(share(&solve(64, 64, -0.1, 1.0, 1.0, 1).0) > 0.97);
    }

    #[test]
    fn threads_change_nothing() {
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool of threads");
            pool.install(|| solve(50, 40, -0.3, 1.0, 1.0, 9))
        };
        assert_eq!(with(1), with(2));
    }
}
