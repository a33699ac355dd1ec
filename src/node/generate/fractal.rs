//! Fractal sums of noise.

use std::ops::Range;

use super::lattice::{Bands, Cells, Coords, Metric, Part, Perlin, PerlinRow, Shear, simplex, value, worley};
use crate::base::kept::Kept;
use crate::base::{hash, num};
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Prepared, Spec};

/// The noise that is summed.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Value noise: soft and blotchy.
    Value,
    /// Perlin's gradient noise.
    #[default]
    Perlin,
    /// Gradient noise on triangles: less of a grid.
    Simplex,
    /// Distance to the nearest point, Euclidean, held at 1: round pits.
    WorleyF1,
    /// Distance from the borders of cells (f2 - f1), held at 1: cracks.
    WorleyEdge,
}

/// How the octaves are summed. `n` is an octave's noise, in [-1, 1]; sums are divided by the sum of the gains.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Sum {
    /// `0.5 + 0.5 n`: clouds, mean 0.5.
    #[default]
    Fbm,
    /// `|n|`: lumps parted by sharp dark creases; mean near 0.25 for Perlin. (libnoise calls `2 |n| - 1` billow.)
    Turbulence,
    /// `1 - (1 - |n|)^2`: pillows, rounder than turbulence, with narrow creases; mean near 0.4 for Perlin.
    Billow,
    /// `(1 - |n|)^2`, each octave weighted by the one before: sharp light ridges, smooth valleys (Musgrave 1994).
    Ridged,
}

/// Noise with detail at every size: octaves of a noise, each finer and weaker than the one before.
///
/// Octave k has `round(cells * lacunarity^k)` cells in each direction (65536 at most), so it tiles for any
/// lacunarity, and a seed and a phase of its own. Octaves finer than the map's texels are sampled, not averaged: keep
/// `cells * lacunarity^(octaves - 1)` below the map's size.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fractal {
    /// The noise that is summed.
    pub basis: Basis,
    /// How the octaves are summed.
    pub sum: Sum,
    /// Cells of the first octave around the body: more makes the whole finer.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_u: u32,
    /// Cells of the first octave along the body.
    #[schemars(range(min = 1, max = 4096))]
    pub cells_v: u32,
    /// How many sizes of detail: 1 is the plain noise, 4 to 6 look natural.
    #[schemars(range(min = 1, max = 12))]
    pub octaves: u32,
    /// How much finer each octave is: 2 is usual, slightly odd values such as 1.9 hide the doubling.
    #[schemars(range(min = 1.0, max = 4.0))]
    pub lacunarity: f32,
    /// Noise is computed only where `where` is above this.
    #[schemars(range(min = -1e9, max = 1e9))]
    pub above: f32,
    /// Noise is computed only where `where` is below this.
    #[schemars(range(min = -1e9, max = 1e9))]
    pub below: f32,
}

impl Default for Fractal {
    fn default() -> Self {
        Self {
            basis: Basis::Perlin,
            sum: Sum::Fbm,
            cells_u: 4,
            cells_v: 4,
            octaves: 5,
            lacunarity: 2.0,
            above: 0.0,
            below: 1e9,
        }
    }
}

const GAIN: usize = 0;
const WHERE: usize = 1;
const DU: usize = 2;

/// Where no noise is computed, this stands for it: its mean, for `fbm`.
const ELSEWHERE: f32 = 0.5;
/// Texels that are computed together if any of them is wanted.
const BLOCK: usize = 64;

/// Of Musgrave's feedback: the weight of an octave is the one before times this.
const RIDGED_FEEDBACK: f32 = 2.0;

/// The noise of one octave.
#[derive(Debug)]
enum Octave {
    Value(Cells),
    Perlin(Perlin),
    Simplex(Cells, Shear),
    WorleyF1(Cells),
    WorleyEdge(Cells),
}

impl Fractal {
    fn octaves(&self, seed: u32) -> Vec<Octave> {
        // Lacunarity may be anything in a struct made by hand.
        let lacunarity = f64::from(self.lacunarity.max(1.0).min(4.0));
        let mut factor = 1.0f64;
        (0..self.octaves.clamp(1, 12))
            .map(|k| {
                // f64 to u32 saturates.
                let side = |n: u32| (f64::from(n) * factor).round() as u32;
                let cells =
                    Cells::new(side(self.cells_u), side(self.cells_v), hash::hash1(seed, k)).out_of_phase();
                factor *= lacunarity;
                match self.basis {
                    Basis::Value => Octave::Value(cells),
                    Basis::Perlin => Octave::Perlin(Perlin::new(cells)),
                    Basis::Simplex => Octave::Simplex(cells, Shear::new(cells.v)),
                    Basis::WorleyF1 => Octave::WorleyF1(cells),
                    Basis::WorleyEdge => Octave::WorleyEdge(cells),
                }
            })
            .collect()
    }
}

impl Octave {
    /// Its signed noise.
    fn sample(&self, at: &Part<'_>, kept: &mut PerlinRow, out: &mut [f32]) {
        let mut bands = Bands { f1: &mut [], f2: &mut [], edge: &mut [], id: &mut [] };
        match self {
            Self::Value(cells) => value(at, *cells, out),
            Self::Perlin(noise) => noise.sample(at, kept, out),
            Self::Simplex(cells, shear) => simplex(at, *cells, *shear, out),
            Self::WorleyF1(cells) => {
                bands.f1 = &mut *out;
                worley(at, *cells, Metric::Euclidean, 1.0, &mut bands);
                signed_distance(out);
            }
            Self::WorleyEdge(cells) => {
                bands.edge = &mut *out;
                worley(at, *cells, Metric::Euclidean, 1.0, &mut bands);
                signed_distance(out);
            }
        }
    }
}

impl Octave {
    /// Add what it gives to a sum; `noise` is scratch, `weight` the ridges' feedback.
    #[expect(clippy::too_many_arguments, reason = "a row's whole state, used here only")]
    fn add(
        &self,
        sum: Sum,
        at: &Part<'_>,
        kept: &mut PerlinRow,
        amp: f32,
        noise: &mut [f32],
        weight: &mut [f32],
        out: &mut [f32],
    ) {
        // The usual noise in one pass over the row.
        if let (Self::Perlin(perlin), Sum::Fbm) = (self, sum)
            && perlin.add(at, kept, amp, out)
        {
            return;
        }
        self.sample(at, kept, noise);
        add(sum, noise, amp, weight, out);
    }
}

/// What all bands share.
struct Octaves {
    octaves: Vec<Octave>,
    room: Kept<Room>,
}

/// What a row of texels takes.
struct Room {
    at: Coords,
    /// For each octave.
    kept: Vec<PerlinRow>,
    noise: Vec<f32>,
    /// The ridges' feedback.
    weight: Vec<f32>,
    sums: Sums,
    /// Texels that are computed.
    wanted: Vec<Range<usize>>,
}

impl Room {
    fn new(width: usize, octaves: usize) -> Self {
        Self {
            at: Coords::new(width),
            kept: (0..octaves).map(|_| PerlinRow::default()).collect(),
            noise: vec![0.0; width],
            weight: vec![0.0; width],
            sums: Sums::default(),
            wanted: Vec::new(),
        }
    }
}

/// Running sums of a row of texels whose gain differs.
#[derive(Default)]
struct Sums {
    amp: Vec<f32>,
    total: Vec<f32>,
}

impl Sums {
    fn begin(&mut self, width: usize) {
        self.amp.resize(width, 1.0);
        self.amp.fill(1.0);
        self.total.resize(width, 0.0);
        self.total.fill(0.0);
    }
}

impl Operation for Fractal {
    const SPEC: Spec = Spec {
        name: "fractal",
        summary: "Noise with detail at every size: clouds, creases, pillows or ridges.",
        inputs: &[
            InputSpec::drive(
                "gain",
                0.5,
                (0.0, 1.0),
                "",
                "Strength of each octave against the one before: 0 smooth, 0.5 natural, 0.8 rough.",
            ),
            InputSpec::drive(
                "where",
                1.0,
                (-1e9, 1e9),
                "",
                "A mask: where it is not between `above` and `below` the value is 0.5, and no noise is computed.",
            ),
            OFFSETS[0],
            OFFSETS[1],
        ],
        outputs: &[OutputSpec::scalar("value", "", "The sum, in [0, 1]; mean 0.5 for fbm.")],
        random: true,
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        let octave = match self.basis {
            Basis::Value => 1.5,
            Basis::Perlin => 2.0,
            Basis::Simplex => 2.5,
            Basis::WorleyF1 | Basis::WorleyEdge => 6.0,
        };
        0.5 + self.octaves as f32 * (octave + 0.4)
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Some(Box::new(Octaves { octaves: self.octaves(cx.seed), room: Kept::new() }))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let Octaves { octaves, room } = cx.prepared();
        room.lend(
            || Room::new(cx.domain.width, octaves.len()),
            |room| match self.even_gain(ins) {
                Some(gain) => self.octave_by_octave(cx, octaves, gain, rows, ins, outs, room),
                None => rows.for_each(|y| self.row(cx, octaves, y, ins, outs.only(y), room)),
            },
        );
    }
}

impl Fractal {
    /// Whether `where` is a constant at which the noise is wanted.
    fn everywhere(&self, ins: &Inputs<'_>) -> bool {
        ins.constant(WHERE).is_some_and(|v| self.above < v && v < self.below)
    }

    /// The gain of the usual noise, everywhere the same and not moved.
    fn even_gain(&self, ins: &Inputs<'_>) -> Option<f32> {
        let usual = self.basis == Basis::Perlin && self.sum == Sum::Fbm;
        let moved = ins.constant(DU).and(ins.constant(DU + 1)).is_none();
        ins.constant(GAIN).filter(|_| usual && !moved && self.everywhere(ins)).map(num::saturate)
    }

    /// The usual noise: what a row of texels takes of an octave is in the first cache when the next row takes it.
    #[expect(clippy::too_many_arguments, reason = "those of `eval`, and what it has found")]
    fn octave_by_octave(
        &self,
        cx: &Cx<'_>,
        octaves: &[Octave],
        gain: f32,
        rows: Range<i64>,
        ins: &Inputs<'_>,
        outs: &mut Outputs<'_>,
        room: &mut Room,
    ) {
        let Room { at, kept, noise, weight, .. } = room;
        rows.clone().for_each(|y| outs.only(y).fill(0.0));
        let (mut amp, mut total) = (1.0, 0.0);
        for (octave, kept) in octaves.iter().zip(kept) {
            for y in rows.clone() {
                at.set(&cx.domain, ins, DU, y);
                octave.add(self.sum, &at.all(), kept, amp, noise, weight, outs.only(y));
            }
            total += amp;
            amp *= gain;
        }
        rows.for_each(|y| divide(total, outs.only(y)));
    }

    fn row(
        &self,
        cx: &Cx<'_>,
        octaves: &[Octave],
        y: i64,
        ins: &Inputs<'_>,
        out: &mut [f32],
        room: &mut Room,
    ) {
        let by = ins.row(WHERE, y);
        let everywhere = self.everywhere(ins);
        room.wanted.clear();
        if everywhere {
            room.wanted.push(0..out.len());
        } else {
            find(by, self.above, self.below, &mut room.wanted);
            out.fill(ELSEWHERE);
        }
        if room.wanted.is_empty() {
            return;
        }
        room.at.set(&cx.domain, ins, DU, y);
        let wanted = std::mem::take(&mut room.wanted);
        for texels in &wanted {
            let out = &mut out[texels.clone()];
            self.texels(octaves, ins, y, texels.clone(), out, room);
            if !everywhere {
                choose(&by[texels.clone()], self.above, self.below, out);
            }
        }
        room.wanted = wanted;
    }

    /// The noise at some texels of a row.
    fn texels(
        &self,
        octaves: &[Octave],
        ins: &Inputs<'_>,
        y: i64,
        texels: Range<usize>,
        out: &mut [f32],
        room: &mut Room,
    ) {
        let Room { at, kept, noise, weight, sums, .. } = room;
        let at = at.part(texels.clone());
        let (noise, weight) = (&mut noise[..out.len()], &mut weight[..out.len()]);
        let gain = ins.constant(GAIN).map(num::saturate);
        out.fill(0.0);
        if self.sum == Sum::Ridged {
            weight.fill(1.0);
        }
        let (mut amp, mut total) = (1.0, 0.0);
        if gain.is_none() {
            sums.begin(out.len());
        }
        for (octave, kept) in octaves.iter().zip(kept) {
            match gain {
                Some(gain) => {
                    octave.add(self.sum, &at, kept, amp, noise, weight, out);
                    total += amp;
                    amp *= gain;
                }
                None => {
                    octave.sample(&at, kept, noise);
                    signal(self.sum, noise, weight);
                    let gain = &ins.row(GAIN, y)[texels.clone()];
                    add_weighted(noise, gain, &mut sums.amp, &mut sums.total, out);
                }
            }
        }
        match gain {
            Some(_) => divide(total, out),
            None => divide_each(&sums.total, out),
        }
    }
}

/// Blocks of texels with any between both bounds, neighbours joined.
fn find(by: &[f32], above: f32, below: f32, found: &mut Vec<Range<usize>>) {
    for (k, block) in by.chunks(BLOCK).enumerate() {
        if !any_between(block, above, below) {
            continue;
        }
        let first = k * BLOCK;
        match found.last_mut() {
            Some(last) if last.end == first => last.end += block.len(),
            _ => found.push(first..first + block.len()),
        }
    }
}

multiversion! {
    fn any_between(by: &[f32], above: f32, below: f32) -> bool {
        let mut any = false;
        for v in by { any |= (above < *v) & (*v < below); }
        any
    }
}

multiversion! {
    /// What was computed, where it was wanted.
    fn choose(by: &[f32], above: f32, below: f32, out: &mut [f32]) {
        for (o, v) in out.iter_mut().zip(by) { *o = if (above < *v) & (*v < below) { *o } else { ELSEWHERE }; }
    }
}

multiversion! {
    /// A distance in cells to [-1, 1], held at 1.
    fn signed_distance(out: &mut [f32]) {
        for o in out { *o = o.min(1.0) * 2.0 - 1.0; }
    }
}

/// What an octave's noise adds, before its amplitude; `weight` is the ridges' feedback.
#[inline(always)]
fn shaped<const SUM: u8>(n: f32, weight: &mut f32) -> f32 {
    match SUM {
        FBM => 0.5 + 0.5 * n,
        TURBULENCE => n.abs(),
        BILLOW => n.abs() * (2.0 - n.abs()),
        _ => {
            let ridge = 1.0 - n.abs();
            let signal = ridge * ridge * *weight;
            *weight = num::saturate(signal * RIDGED_FEEDBACK);
            signal
        }
    }
}

const FBM: u8 = Sum::Fbm as u8;
const TURBULENCE: u8 = Sum::Turbulence as u8;
const BILLOW: u8 = Sum::Billow as u8;
const RIDGED: u8 = Sum::Ridged as u8;

#[inline(always)]
fn add_as<const SUM: u8>(noise: &[f32], amp: f32, weight: &mut [f32], out: &mut [f32]) {
    for ((o, n), w) in out.iter_mut().zip(noise).zip(weight) {
        *o += amp * shaped::<SUM>(*n, w);
    }
}

multiversion! {
    /// Add one octave to the sum.
    fn add(sum: Sum, noise: &[f32], amp: f32, weight: &mut [f32], out: &mut [f32]) {
        match sum {
            Sum::Fbm => add_as::<FBM>(noise, amp, weight, out),
            Sum::Turbulence => add_as::<TURBULENCE>(noise, amp, weight, out),
            Sum::Billow => add_as::<BILLOW>(noise, amp, weight, out),
            Sum::Ridged => add_as::<RIDGED>(noise, amp, weight, out),
        }
    }
}

#[inline(always)]
fn signal_as<const SUM: u8>(noise: &mut [f32], weight: &mut [f32]) {
    for (n, w) in noise.iter_mut().zip(weight) {
        *n = shaped::<SUM>(*n, w);
    }
}

multiversion! {
    /// An octave's noise to what it adds, before its amplitude.
    fn signal(sum: Sum, noise: &mut [f32], weight: &mut [f32]) {
        match sum {
            Sum::Fbm => signal_as::<FBM>(noise, weight),
            Sum::Turbulence => signal_as::<TURBULENCE>(noise, weight),
            Sum::Billow => signal_as::<BILLOW>(noise, weight),
            Sum::Ridged => signal_as::<RIDGED>(noise, weight),
        }
    }
}

multiversion! {
    /// Add one octave to the sum and step its amplitude.
    fn add_weighted(signal: &[f32], gain: &[f32], amp: &mut [f32], total: &mut [f32], out: &mut [f32]) {
        let n = out.len();
        let (signal, gain, amp, total) = (&signal[..n], &gain[..n], &mut amp[..n], &mut total[..n]);
        for i in 0..n {
            out[i] += amp[i] * signal[i];
            total[i] += amp[i];
            amp[i] *= num::saturate(gain[i]);
        }
    }
}

multiversion! {
    fn divide(total: f32, out: &mut [f32]) {
        for o in out { *o = num::saturate(*o / total); }
    }
}

multiversion! {
    fn divide_each(total: &[f32], out: &mut [f32]) {
        for (o, t) in out.iter_mut().zip(total) { *o = num::saturate(*o / *t); }
    }
}
