//! What the blending nodes share: `b` laid on `a` by a formula, shown by a mask.

use crate::node::InputSpec;

/// How much of the result shows: the last input of every blending node.
pub(super) const AMOUNT: InputSpec = InputSpec::drive(
    "amount",
    1.0,
    (0.0, 1.0),
    "",
    "How much of the result shows over `a`: 0 none, 1 all; values outside are clamped.",
);

/// `x`, with what overflowed to infinity brought back to the largest f32.
#[inline(always)]
pub(super) fn finite(x: f32) -> f32 {
    x.max(f32::MIN).min(f32::MAX)
}

/// `a` where the amount is 0 and `result` where it is 1, both exactly; linear between.
#[inline(always)]
pub(super) fn show(a: f32, result: f32, amount: f32) -> f32 {
    let m = crate::base::num::saturate(amount);
    // Two products, not `a + (result - a) m`: exact at both ends, and the difference may overflow.
    a * (1.0 - m) + finite(result) * m
}

/// A node of two images and an amount: `Type = "op": summary; a: doc, b: doc, result: doc; |a, b| formula`.
macro_rules! blend {
    (
        $(#[$doc:meta])*
        $node:ident = $name:literal: $summary:literal;
        a: $a_doc:literal, b: $b_doc:literal, result: $result_doc:literal;
        |$a:ident, $b:ident| $formula:expr
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $node {}

        impl $crate::node::Operation for $node {
            const SPEC: $crate::node::Spec = $crate::node::Spec {
                name: $name,
                category: $crate::node::Category::Combine,
                summary: $summary,
                inputs: &[
                    $crate::node::InputSpec::image("a", $a_doc),
                    $crate::node::InputSpec::image("b", $b_doc),
                    $crate::node::combine::blend::AMOUNT,
                ],
                outputs: &[$crate::node::OutputSpec::same("result", $result_doc)],
                ..$crate::node::Spec::FILTER
            };

            fn cost_ns(&self) -> f32 {
                0.3
            }

            fn overwrites(&self) -> Option<usize> {
                Some(0)
            }

            fn eval(
                &self,
                _: &$crate::node::Cx<'_>,
                rows: std::ops::Range<i64>,
                ins: &$crate::node::Inputs<'_>,
                outs: &mut $crate::node::Outputs<'_>,
            ) {
                let is_output = ins.is_output(0);
                for y in rows {
                    if is_output {
                        over(ins.row(1, y), ins.row(2, y), outs.only(y));
                    } else {
                        kernel(ins.row(0, y), ins.row(1, y), ins.row(2, y), outs.only(y));
                    }
                }
            }
        }

        #[inline(always)]
        fn formula($a: f32, $b: f32) -> f32 {
            $formula
        }

        $crate::multiversion! {
            fn kernel(a: &[f32], b: &[f32], amount: &[f32], out: &mut [f32]) {
                for (((o, a), b), m) in out.iter_mut().zip(a).zip(b).zip(amount) {
                    *o = $crate::node::combine::blend::show(*a, formula(*a, *b), *m);
                }
            }
        }

        $crate::multiversion! {
            /// `a` is in `out`.
            fn over(b: &[f32], amount: &[f32], out: &mut [f32]) {
                for ((o, b), m) in out.iter_mut().zip(b).zip(amount) {
                    *o = $crate::node::combine::blend::show(*o, formula(*o, *b), *m);
                }
            }
        }
    };
}
pub(super) use blend;

/// One texel of a combiner, for tests of identities.
#[cfg(test)]
pub(super) fn texel(node: &dyn crate::node::Node, inputs: &[f32]) -> f32 {
    use crate::base::{Domain, Plane};
    use crate::eval::{Input, run_node};
    let planes: Vec<_> = inputs.iter().map(|&v| Plane::filled(1, 1, v)).collect();
    let inputs: Vec<_> = planes.iter().map(Input::Plane).collect();
    run_node(node, &Domain::square(1), 0, &inputs, &crate::node::Assets::new(), 0)[0].at(0, 0)
}

#[cfg(test)]
mod tests {
    use super::texel;
    use crate::node::combine::OPS;

    /// Ops whose last input is the amount.
    fn blends() -> impl Iterator<Item = &'static crate::node::Op> {
        OPS.iter().filter(|op| op.spec.inputs.last().is_some_and(|i| i.name == "amount"))
    }

    #[test]
    fn amount_0_is_a_and_amount_1_the_result_exactly() {
        assert_eq!(blends().count(), 13);
        for op in blends() {
            let node = (op.default)();
            let with = |amount: f32| {
                let mut inputs = vec![0.3, 0.7];
                inputs.resize(op.spec.inputs.len() - 1, 0.1);
                inputs.push(amount);
                texel(node.as_ref(), &inputs)
            };
            assert_eq!(with(0.0), 0.3, "{}", op.spec.name);
            assert_eq!(with(-4.0), 0.3, "{}", op.spec.name);
            assert_eq!(with(1.0), with(9.0), "{}", op.spec.name);
            assert!((with(0.5) - 0.5 * (with(0.0) + with(1.0))).abs() < 1e-6, "{}", op.spec.name);
        }
    }

    #[test]
    fn wild_values_stay_finite() {
        let wild = [0.0, -0.0, 1.0, -1.0, 1e-40, -1e-40, 1e30, -1e30, f32::MAX, -f32::MAX];
        for op in OPS {
            let node = (op.default)();
            for a in wild {
                for b in wild {
                    for c in wild {
                        let inputs: Vec<_> =
                            [a, b, c].into_iter().cycle().take(op.spec.inputs.len()).collect();
                        let v = texel(node.as_ref(), &inputs);
                        // `mix` promises 1e30, not the largest f32: its difference may overflow.
                        let beyond = op.spec.name == "mix" && inputs.iter().any(|v| v.abs() > 1e30);
                        assert!(beyond || v.is_finite(), "{} {a} {b} {c}: {v}", op.spec.name);
                    }
                }
            }
        }
    }

    #[test]
    fn commutative_formulas_commute() {
        for name in ["add", "multiply", "min", "max", "smooth_min", "smooth_max", "screen", "difference"] {
            let node = (crate::node::find(name).expect("it is registered").default)();
            for (a, b) in [(0.2, 0.7), (0.9, 0.1), (0.5, 0.5)] {
                assert_eq!(texel(node.as_ref(), &[a, b]), texel(node.as_ref(), &[b, a]), "{name}");
            }
        }
    }
}
