//! The nodes' formulas once more, written plainly in any number: what a plan is checked against.
//!
//! They follow the definitions in the nodes' documents, not their code: no vectors, no tables, no bands.

use super::number::Number;
use crate::base::domain::MAX_SIDE;
use crate::base::{Domain, hash};
use crate::node::color::OklabJitter;
use crate::node::convert::{
    FilmThickness, HeightToAmbientOcclusion, HeightToCurvature, HeightToNormal, NormalFormat,
};
use crate::node::generate::{Basis, Fractal, Sum, WhiteNoise};
use crate::node::pattern::BodyStripe;
use crate::plan::Step;

/// One lane of values.
#[derive(Clone, Debug)]
pub(super) enum Lane<N> {
    /// The same everywhere.
    Same(N),
    /// A value for each texel, row by row.
    Each(Vec<N>),
}

/// The inputs of one call.
pub(super) struct Ins<'a, N> {
    pub(super) domain: &'a Domain,
    pub(super) offsets: &'a [usize],
    pub(super) lanes: Vec<&'a Lane<N>>,
}

impl<N: Number> Ins<'_, N> {
    /// Value of a lane, through the torus.
    fn lane(&self, lane: usize, x: i64, y: i64) -> N {
        match self.lanes[lane] {
            Lane::Same(v) => *v,
            Lane::Each(all) => {
                let (w, h) = (self.domain.width, self.domain.height);
                all[y.rem_euclid(h as i64) as usize * w + x.rem_euclid(w as i64) as usize]
            }
        }
    }

    /// Value of a scalar input.
    fn at(&self, input: usize, x: i64, y: i64) -> N {
        self.lane(self.offsets[input], x, y)
    }

    /// Place of a texel's centre, moved by inputs `du` and `du + 1`, both in [0, 1].
    fn place(&self, du: usize, x: i64, y: i64) -> (N, N) {
        let centre = |i: i64, n: usize| N::new(i as f64 + 0.5) / N::new(n as f64);
        let u = centre(x, self.domain.width) + self.at(du, x, y);
        let v = centre(y, self.domain.height) + self.at(du + 1, x, y);
        (u.fract(), v.fract())
    }

    /// `K` lanes from a formula of the texel.
    fn map<const K: usize>(&self, f: impl Fn(i64, i64) -> [N; K]) -> Vec<Lane<N>> {
        let (w, h) = (self.domain.width, self.domain.height);
        let mut out: [Vec<N>; K] = std::array::from_fn(|_| Vec::with_capacity(w * h));
        for y in 0..h as i64 {
            for x in 0..w as i64 {
                for (out, v) in out.iter_mut().zip(f(x, y)) {
                    out.push(v);
                }
            }
        }
        out.into_iter().map(Lane::Each).collect()
    }
}

/// What a node computes: all its output lanes.
pub(super) type Kernel<N> = Box<dyn Fn(&Ins<'_, N>) -> Vec<Lane<N>>>;

/// The formula of a step, if there is one here.
pub(super) fn of<N: Number>(step: &Step) -> Option<Kernel<N>> {
    let settings = step.node.settings();
    let seed = step.seed;
    Some(match step.node.spec().name {
        "add" => binary(|a, b| a + b),
        "subtract" => binary(|a, b| a - b),
        "multiply" => binary(|a, b| a * b),
        "min" => binary(N::min),
        "max" => binary(N::max),
        "mix" => Box::new(|ins| {
            ins.map(|x, y| [N::lerp(ins.at(0, x, y), ins.at(1, x, y), ins.at(2, x, y).saturate())])
        }),
        "clamp" => {
            Box::new(|ins| ins.map(|x, y| [ins.at(0, x, y).max(ins.at(1, x, y)).min(ins.at(2, x, y))]))
        }
        "levels" => Box::new(|ins| ins.map(|x, y| [levels(std::array::from_fn(|i| ins.at(i, x, y)))])),
        "body_position" => Box::new(|ins| {
            ins.map(|x, y| {
                let (u, v) = ins.place(0, x, y);
                let side = N::new(2.0) * (u - N::new(0.5)).wrap_half();
                [side.abs(), side, v]
            })
        }),
        "body_stripe" => {
            let BodyStripe { position, width } = settings.try_into().ok()?;
            Box::new(move |ins| {
                ins.map(|x, y| {
                    let lateral = (ins.place(1, x, y).0 - N::new(0.5)).wrap_half().abs();
                    let inside = N::new(0.5 * f64::from(width)) - (lateral - N::new(position.into())).abs();
                    [inside * N::new(ins.domain.girth_mm.into()) + ins.at(0, x, y)]
                })
            })
        }
        "white_noise" => {
            let WhiteNoise { cells_u, cells_v } = settings.try_into().ok()?;
            let lattice = Lattice::new(cells_u, cells_v, seed, false);
            Box::new(move |ins| {
                ins.map(|x, y| {
                    let (u, v) = ins.place(0, x, y);
                    [N::new(hash::unit(lattice.corners(u, v).0[0]).into())]
                })
            })
        }
        "fractal" => {
            let fractal: Fractal = settings.try_into().ok()?;
            if !matches!(fractal.basis, Basis::Perlin | Basis::Value) {
                return None;
            }
            let octaves = octaves(&fractal, seed);
            Box::new(move |ins| {
                let (above, below) = (N::new(fractal.above.into()), N::new(fractal.below.into()));
                ins.map(|x, y| {
                    let by = ins.at(1, x, y);
                    let noise = || fbm(&fractal, &octaves, ins.at(0, x, y), ins.place(2, x, y));
                    [if above < by && by < below { noise() } else { N::new(0.5) }]
                })
            })
        }
        "oklab_jitter" => {
            let OklabJitter { independent } = settings.try_into().ok()?;
            Box::new(move |ins| {
                ins.map(|x, y| {
                    let color = std::array::from_fn(|c| ins.lane(c, x, y));
                    let by = [2, 3, 4].map(|input| ins.at(input, x, y));
                    jitter(color, ins.at(1, x, y), by, seed, independent)
                })
            })
        }
        "film_thickness" => {
            let FilmThickness { min, max } = settings.try_into().ok()?;
            let [min, max] = [min, max].map(|nm| N::new(nm.into()));
            Box::new(move |ins| {
                ins.map(|x, y| {
                    let at = |input| ins.at(input, x, y);
                    let random = at(7) * (N::new(2.0) * at(8) - N::new(1.0));
                    let film = at(0) + at(1) * at(2) + at(3) * at(4) + at(5) * at(6) + random;
                    [N::lerp(at(10), film.max(min).min(max), at(9).saturate())]
                })
            })
        }
        "height_to_translucency" => Box::new(|ins| {
            ins.map(|x, y| {
                let thickness = (ins.at(0, x, y) - ins.at(1, x, y)).max(N::new(0.0));
                [(-(thickness / ins.at(2, x, y).max(N::new(1e-30)))).exp()]
            })
        }),
        "height_to_normal" => {
            let HeightToNormal { format } = settings.try_into().ok()?;
            let green = if format == NormalFormat::Opengl { 1.0 } else { -1.0 };
            Box::new(move |ins| {
                ins.map(|x, y| {
                    let ([su, sv], strength) = (slopes(ins, x, y), ins.at(1, x, y));
                    let (nx, ny) = (-(strength * su), strength * sv * N::new(green));
                    let length = (N::new(1.0) + nx * nx + ny * ny).sqrt();
                    [nx / length, ny / length, N::new(1.0) / length]
                })
            })
        }
        "height_to_ambient_occlusion" => {
            let node: HeightToAmbientOcclusion = settings.try_into().ok()?;
            Box::new(move |ins| occlusion(&node, ins))
        }
        "height_to_curvature" => {
            let HeightToCurvature { radius } = settings.try_into().ok()?;
            Box::new(move |ins| curvature(radius, 3.0, ins))
        }
        _ => return None,
    })
}

fn binary<N: Number>(f: impl Fn(N, N) -> N + 'static) -> Kernel<N> {
    Box::new(move |ins| ins.map(|x, y| [f(ins.at(0, x, y), ins.at(1, x, y))]))
}

/// Image, the two levels it comes from, gamma, the two that it goes to.
fn levels<N: Number>([image, in_low, in_high, gamma, out_low, out_high]: [N; 6]) -> N {
    let (zero, one) = (N::new(0.0), N::new(1.0));
    let t = if in_low == in_high {
        if image >= in_high { one } else { zero }
    } else {
        ((image - in_low) / (in_high - in_low)).saturate()
    };
    let t = if gamma == one { t } else { t.powf(one / gamma) };
    out_low * (one - t) + out_high * t
}

/// A lattice of cells on the torus.
struct Lattice {
    cells: [u32; 2],
    seed: u32,
    phase: [f32; 2],
}

impl Lattice {
    fn new(u: u32, v: u32, seed: u32, phase: bool) -> Self {
        let seed = hash::pcg(seed);
        let of = |axis| if phase { hash::unit(hash::hash1(seed, axis)) } else { 0.0 };
        Self { cells: [u, v].map(|n| n.clamp(1, MAX_SIDE as u32)), seed, phase: [of(0), of(1)] }
    }

    /// Hashes of the corners 00, 10, 01, 11 of the cell around a place, and the place in it.
    fn corners<N: Number>(&self, u: N, v: N) -> ([u32; 4], [N; 2]) {
        let axis = |t: N, k: usize| {
            let t = t * N::new(self.cells[k].into()) + N::new(self.phase[k].into());
            let low = t.floor();
            let i = low.get() as u32 % self.cells[k];
            (i, (i + 1) % self.cells[k], t - low)
        };
        let ((i0, i1, x), (j0, j1, y)) = (axis(u, 0), axis(v, 1));
        ([(j0, i0), (j0, i1), (j1, i0), (j1, i1)].map(|(j, i)| hash::hash2(self.seed, j, i)), [x, y])
    }
}

fn octaves(fractal: &Fractal, seed: u32) -> Vec<Lattice> {
    let mut factor = 1.0;
    (0..fractal.octaves)
        .map(|k| {
            let [u, v] = [fractal.cells_u, fractal.cells_v].map(|n| (f64::from(n) * factor).round() as u32);
            factor *= f64::from(fractal.lacunarity);
            Lattice::new(u, v, hash::hash1(seed, k), true)
        })
        .collect()
}

fn fbm<N: Number>(fractal: &Fractal, octaves: &[Lattice], gain: N, (u, v): (N, N)) -> N {
    let [zero, half, one, two] = [0.0, 0.5, 1.0, 2.0].map(N::new);
    let fade = |t: N| t * t * t * (t * (t * N::new(6.0) - N::new(15.0)) + N::new(10.0));
    let gain = gain.saturate();
    let (mut sum, mut total, mut amp, mut weight) = (zero, zero, one, one);
    for lattice in octaves {
        let (h, [x, y]) = lattice.corners(u, v);
        let corner = |k: usize| {
            let signed = |v: N, bit: u32| if h[k] >> bit & 1 == 1 { -v } else { v };
            match fractal.basis {
                Basis::Value => two * N::new(hash::unit(h[k]).into()) - one,
                _ => signed(x - N::new((k % 2) as f64), 0) + signed(y - N::new((k / 2) as f64), 1),
            }
        };
        let across = |row: usize| N::lerp(corner(2 * row), corner(2 * row + 1), fade(x));
        let n = N::lerp(across(0), across(1), fade(y));
        let signal = match fractal.sum {
            Sum::Fbm => half + half * n,
            Sum::Turbulence => n.abs(),
            Sum::Billow => n.abs() * (two - n.abs()),
            Sum::Ridged => {
                let ridge = one - n.abs();
                let signal = ridge * ridge * weight;
                weight = (signal * two).saturate();
                signal
            }
        };
        sum = sum + amp * signal;
        total = total + amp;
        amp = amp * gain;
    }
    sum / total
}

/// Hue, chroma and lightness of a colour moved in Oklab (Ottosson 2020, matrices of 2021).
fn jitter<N: Number>(
    color: [N; 3],
    random: N,
    [hue, chroma, lightness]: [N; 3],
    seed: u32,
    each: bool,
) -> [N; 3] {
    const LMS: [[f64; 3]; 3] = [
        [0.412_221_46, 0.536_332_55, 0.051_445_995],
        [0.211_903_5, 0.680_699_5, 0.107_396_96],
        [0.088_302_46, 0.281_718_85, 0.629_978_7],
    ];
    const LAB: [[f64; 3]; 3] = [
        [0.210_454_26, 0.793_617_8, -0.004_072_047],
        [1.977_998_5, -2.428_592_2, 0.450_593_7],
        [0.025_904_037, 0.782_771_77, -0.808_675_77],
    ];
    const ROOTS: [[f64; 3]; 3] = [
        [1.0, 0.396_337_78, 0.215_803_76],
        [1.0, -0.105_561_346, -0.063_854_17],
        [1.0, -0.089_484_18, -1.291_485_5],
    ];
    const RGB: [[f64; 3]; 3] = [
        [4.076_741_7, -3.307_711_6, 0.230_969_94],
        [-1.268_438, 2.609_757_4, -0.341_319_4],
        [-0.004_196_086_3, -0.703_418_6, 1.707_614_7],
    ];
    let by = |m: &[[f64; 3]; 3], v: [N; 3]| {
        m.map(|row| N::new(row[0]) * v[0] + N::new(row[1]) * v[1] + N::new(row[2]) * v[2])
    };
    let r = random.saturate();
    // The draw is a hash of the number's 24 bits: the same for every arithmetic.
    let bits = (r.get() * 16_777_216.0) as u32;
    let draw = |channel| match each {
        true => N::new(hash::signed(hash::hash2(seed, bits, channel)).into()),
        false => N::new(2.0) * r - N::new(1.0),
    };
    let (turn, scale, lift) =
        (draw(0) * hue, (N::new(1.0) + draw(1) * chroma).max(N::new(0.0)), draw(2) * lightness);
    if [turn, scale - N::new(1.0), lift].iter().all(|v| v.get() == 0.0) {
        return color;
    }
    let third = N::new(1.0) / N::new(3.0);
    let cones = by(&LMS, color.map(N::saturate)).map(|v| v.powf(third));
    let [l, a, b] = by(&LAB, cones);
    let (cos, sin) = (turn.cos_turns() * scale, turn.sin_turns() * scale);
    let roots = by(&ROOTS, [(l + lift).saturate(), a * cos - b * sin, a * sin + b * cos]);
    by(&RGB, roots.map(|v| v * v * v)).map(N::saturate)
}

/// Size of a texel around and along the body, mm.
fn texel<N: Number>(domain: &Domain) -> [N; 2] {
    let side = |mm: f32, n: usize| N::new(mm.into()) / N::new(n as f64);
    [side(domain.girth_mm, domain.width), side(domain.length_mm, domain.height)]
}

/// Slopes of input 0 around and along the body, by central differences.
fn slopes<N: Number>(ins: &Ins<'_, N>, x: i64, y: i64) -> [N; 2] {
    let [u, v] = texel::<N>(ins.domain);
    let per = |mm: N| N::new(0.5) / mm;
    [
        (ins.at(0, x + 1, y) - ins.at(0, x - 1, y)) * per(u),
        (ins.at(0, x, y + 1) - ins.at(0, x, y - 1)) * per(v),
    ]
}

/// See [`HeightToAmbientOcclusion`].
fn occlusion<N: Number>(node: &HeightToAmbientOcclusion, ins: &Ins<'_, N>) -> Vec<Lane<N>> {
    /// What is seen at one distance in one direction.
    struct Look<N> {
        texel: [i64; 2],
        rest: [N; 2],
        per_mm: N,
        weight: N,
    }
    let [zero, one, two] = [0.0, 1.0, 2.0].map(N::new);
    let [u, v] = texel::<N>(ins.domain);
    let radius = N::new(node.radius.into());
    let distance = |i: u32| {
        let t = N::new(f64::from(i) + 1.0) / N::new(f64::from(node.steps) + 0.5);
        radius * t * t
    };
    // Nearer than a texel there is nothing to see, but the last look stands for all.
    let count = if node.radius > 1e-9 { node.steps } else { 0 };
    let near = (u * v).sqrt();
    let first = (0..count).find(|&i| distance(i) >= near).unwrap_or(count.saturating_sub(1));
    let way = |k: u32| {
        let turns = N::new(f64::from(k) + 0.5) / N::new(node.directions.into());
        let (cos, sin) = (turns.cos_turns(), turns.sin_turns());
        let look = |i: u32| {
            let d = distance(i);
            let (x, y) = (d * cos / u, d * sin / v);
            let t = d / radius;
            Look {
                texel: [x, y].map(|c| c.floor().get() as i64),
                rest: [x.fract(), y.fract()],
                per_mm: one / d,
                weight: one - N::new(node.falloff.into()) * t * t,
            }
        };
        (cos, sin, (first..count).map(look).collect::<Vec<_>>())
    };
    let ways: Vec<_> = (0..node.directions).map(way).collect();
    ins.map(|x, y| {
        let [su, sv] = slopes(ins, x, y);
        let here = ins.at(0, x, y);
        let mut lost = zero;
        for (cos, sin, looks) in &ways {
            let g = su * *cos + sv * *sin;
            let mut excess = zero;
            for Look { texel: [dx, dy], rest: [tx, ty], per_mm, weight } in looks {
                let across = |y: i64| N::lerp(ins.at(0, x + dx, y), ins.at(0, x + dx + 1, y), *tx);
                let there = N::lerp(across(y + dy), across(y + dy + 1), *ty);
                excess = excess.max(((there - here) * *per_mm - g) * *weight);
            }
            // Angle from the tangent plane to the horizon: along (a, excess).
            let a = one + g * (g + excess);
            let square = a * a + excess * excess;
            let delta = N::new(std::f64::consts::TAU) * N::atan2_turns(excess, a);
            lost = lost + two * excess * excess / square + g * (two * a * excess / square - two * delta);
        }
        let length = (one + su * su + sv * sv).sqrt();
        let hidden = (lost * N::new(0.5) / N::new(node.directions.into()) / length).saturate();
        [(one - ins.at(1, x, y).max(zero) * hidden).saturate()]
    })
}

/// Mean curvature of input 0, 1/mm, blurred by a Gaussian of half the radius (mm) that is cut off at `tail` standard
/// deviations. See [`HeightToCurvature`].
pub(super) fn curvature<N: Number>(radius: f32, tail: f64, ins: &Ins<'_, N>) -> Vec<Lane<N>> {
    let size = texel::<N>(ins.domain);
    let weights = size.map(|mm| {
        let sigma = N::new(0.5 * f64::from(radius)) / mm;
        let taps = (tail * sigma.get()).floor() as usize;
        let bell = |i: usize| {
            let t = N::new(i as f64) / sigma;
            if i == 0 { N::new(1.0) } else { (N::new(-0.5) * t * t).exp() }
        };
        let total = (1..=taps).fold(N::new(1.0), |sum, i| sum + N::new(2.0) * bell(i));
        (0..=taps).map(|i| bell(i) / total).collect::<Vec<_>>()
    });
    let blurred = |ins: &Ins<'_, N>, axis: usize| {
        let by = |i: i64| if axis == 0 { (i, 0) } else { (0, i) };
        ins.map(|x, y| {
            let at = |i: i64| ins.at(0, x + by(i).0, y + by(i).1);
            let pairs = weights[axis].iter().enumerate().skip(1);
            [pairs.fold(at(0) * weights[axis][0], |sum, (i, w)| sum + (at(-(i as i64)) + at(i as i64)) * *w)]
        })
    };
    let across = blurred(ins, 0);
    let only = |lane| Ins { domain: ins.domain, offsets: &[0, 1], lanes: vec![lane] };
    let along = blurred(&only(&across[0]), 1);
    let smooth = only(&along[0]);
    let per = size.map(|mm| N::new(1.0) / mm);
    let quarter = N::new(0.25);
    let lean = |slope: N, cross: N| slope / (N::new(1.0) + slope * slope + cross * cross).sqrt();
    let h = |x: i64, y: i64| smooth.at(0, x, y);
    // What flows out through the right and the lower side of a texel.
    let right = |x: i64, y: i64| {
        let cross = h(x, y + 1) - h(x, y - 1) + h(x + 1, y + 1) - h(x + 1, y - 1);
        lean((h(x + 1, y) - h(x, y)) * per[0], cross * quarter * per[1])
    };
    let lower = |x: i64, y: i64| {
        let cross = h(x + 1, y) - h(x - 1, y) + h(x + 1, y + 1) - h(x - 1, y + 1);
        lean((h(x, y + 1) - h(x, y)) * per[1], cross * quarter * per[0])
    };
    smooth.map(|x, y| {
        let flow = (right(x, y) - right(x - 1, y)) * per[0] + (lower(x, y) - lower(x, y - 1)) * per[1];
        [N::new(-0.5) * flow]
    })
}
