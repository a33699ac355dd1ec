//! Levels: stretch, gamma, output range.

use std::ops::Range;

use super::finite;
use crate::base::num;
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Spec};

/// The input range `in_low ..= in_high` is stretched to `out_low ..= out_high`, with a gamma between.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Levels {}

const IMAGE: usize = 0;
const IN_LOW: usize = 1;
const IN_HIGH: usize = 2;
const GAMMA: usize = 3;
const OUT_LOW: usize = 4;
const OUT_HIGH: usize = 5;

/// Least gamma that is used; smaller values are read as this.
const GAMMA_MIN: f32 = 0.01;

impl Operation for Levels {
    const SPEC: Spec = Spec {
        name: "levels",
        summary: "Stretches a range of values to another, with gamma.",
        inputs: &[
            InputSpec::image("image", "What is changed."),
            InputSpec::drive("in_low", 0.0, (-1e6, 1e6), "", "Becomes `out_low`, as does all below."),
            InputSpec::drive(
                "in_high",
                1.0,
                (-1e6, 1e6),
                "",
                "Becomes `out_high`, as does all above. Below `in_low` it inverts; equal to it gives a hard step.",
            ),
            InputSpec::drive(
                "gamma",
                1.0,
                (GAMMA_MIN, 100.0),
                "",
                "Lifts the middle values where above 1, lowers them where below; 0.3 to 3. Ends stay.",
            ),
            InputSpec::drive("out_low", 0.0, (-1e6, 1e6), "", "Value that `in_low` becomes."),
            InputSpec::drive("out_high", 1.0, (-1e6, 1e6), "", "Value that `in_high` becomes."),
        ],
        outputs: &[OutputSpec::same("result", "Values between `out_low` and `out_high`.")],
        ..Spec::FILTER
    };

    fn cost_ns(&self) -> f32 {
        1.0
    }

    fn overwrites(&self) -> Option<usize> {
        Some(IMAGE)
    }

    fn eval(&self, _: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let is_output = ins.is_output(IMAGE);
        let linear = ins.constant(GAMMA) == Some(1.0);
        let levels = [IN_LOW, IN_HIGH, OUT_LOW, OUT_HIGH].map(|level| ins.constant(level));
        for y in rows {
            if let (true, [Some(in_low), Some(in_high), Some(out_low), Some(out_high)]) = (linear, levels) {
                let (from, to) = ([in_low, in_high], [out_low, out_high]);
                match is_output {
                    true => stretch_over(from, to, outs.only(y)),
                    false => stretch_all(ins.row(IMAGE, y), from, to, outs.only(y)),
                }
                continue;
            }
            if !is_output {
                outs.only(y).copy_from_slice(ins.row(IMAGE, y));
            }
            stretch(ins.row(IN_LOW, y), ins.row(IN_HIGH, y), outs.only(y));
            if !linear {
                power(ins.row(GAMMA, y), outs.only(y));
            }
            rescale(ins.row(OUT_LOW, y), ins.row(OUT_HIGH, y), outs.only(y));
        }
    }
}

/// Between the output levels. Weighted so that both ends are exact and huge ends do not overflow.
#[inline(always)]
fn between(low: f32, high: f32, at: f32) -> f32 {
    finite(low * (1.0 - at) + high * at)
}

multiversion! {
    /// Levels that are the same everywhere, which is usual: one pass.
    fn stretch_all(image: &[f32], from: [f32; 2], to: [f32; 2], out: &mut [f32]) {
        for (o, x) in out.iter_mut().zip(image) {
            *o = between(to[0], to[1], num::linear_step(from[0], from[1], *x));
        }
    }
}

multiversion! {
    /// The same of what is in `out`.
    fn stretch_over(from: [f32; 2], to: [f32; 2], out: &mut [f32]) {
        for o in out { *o = between(to[0], to[1], num::linear_step(from[0], from[1], *o)); }
    }
}

multiversion! {
    fn stretch(low: &[f32], high: &[f32], out: &mut [f32]) {
        for ((o, lo), hi) in out.iter_mut().zip(low).zip(high) { *o = num::linear_step(*lo, *hi, *o); }
    }
}

multiversion! {
    fn power(gamma: &[f32], out: &mut [f32]) {
        for (o, g) in out.iter_mut().zip(gamma) {
            let p = num::powf(*o, 1.0 / g.max(GAMMA_MIN));
            *o = if *g == 1.0 { *o } else { p };
        }
    }
}

multiversion! {
    fn rescale(low: &[f32], high: &[f32], out: &mut [f32]) {
        for ((o, lo), hi) in out.iter_mut().zip(low).zip(high) {
            *o = between(*lo, *hi, *o);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_bands_agree, noise, run, square};
    use super::*;
    use crate::base::Plane;
    use crate::eval::Input::{Plane as P, Unset, Value};

    #[test]
    fn defaults_only_limit_to_0_1() {
        let a = noise(16, 16, 1);
        assert!(run(&Levels::default(), &square(16), &[P(&a)]) == a);
    }

    #[test]
    fn gamma_2_takes_the_square_root_and_keeps_the_ends() {
        let a = Plane::from_vec(3, 1, vec![0.0, 0.25, 1.0]);
        let d = crate::base::Domain { width: 3, height: 1, ..square(1) };
        let out = run(&Levels::default(), &d, &[P(&a), Unset, Unset, Value(2.0), Value(2.0), Value(4.0)]);
        assert_eq!(out.data()[0], 2.0);
        assert!((out.data()[1] - 3.0).abs() < 1e-5);
        assert!((out.data()[2] - 4.0).abs() < 1e-6);
    }

    #[test]
    fn equal_input_levels_step_and_swapped_ones_invert() {
        let a = noise(9, 9, 2);
        let step = run(&Levels::default(), &square(9), &[P(&a), Value(0.5), Value(0.5)]);
        let inverse = run(&Levels::default(), &square(9), &[P(&a), Value(1.0), Value(0.0)]);
        for ((s, i), x) in step.data().iter().zip(inverse.data()).zip(a.data()) {
            assert_eq!(*s, if *x >= 0.5 { 1.0 } else { 0.0 });
            assert!((i - (1.0 - x)).abs() < 1e-6);
        }
    }

    #[test]
    fn huge_inputs_stay_finite_and_bands_agree() {
        let a = noise(8, 9, 3);
        let d = crate::base::Domain { height: 9, ..square(8) };
        for v in [1e30, -1e30, f32::MAX, f32::MIN, 1e-40] {
            let ins = [P(&a), Value(v), Value(-v), Value(v), Value(-v), Value(v)];
            assert!(run(&Levels::default(), &d, &ins).data().iter().all(|x| x.is_finite()));
            assert_bands_agree(&Levels::default(), &d, &ins);
        }
    }
}
