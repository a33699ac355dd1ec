//! What nodes approximate by their settings or their constants, and the same nodes with more of it.

use std::ops::Range;
use std::sync::Arc;

use super::kernels::{self, Ins, Lane};
use crate::base::Domain;
use crate::node::convert::{HeightToAmbientOcclusion, HeightToCurvature};
use crate::node::filter::{BoxBlur, GaussianBlur};
use crate::node::pattern::GrayScott;
use crate::node::{Cx, Inputs, Node, Outputs, ParamError, Prepared, Reach, Spec};

/// Another way to make a node.
pub(super) struct Finer {
    /// What the node does.
    pub(super) shortcut: String,
    /// What the other one does in its place.
    pub(super) truth: String,
    /// The other one.
    pub(super) node: Arc<dyn Node>,
}

/// The finer way to make a node, if it approximates something that can be had finer.
pub(super) fn of(node: &Arc<dyn Node>) -> Option<Finer> {
    let settings = node.settings();
    match node.spec().name {
        "box_blur" => {
            let BoxBlur { radius } = settings.try_into().ok()?;
            // A box of half width r has the variance r^2 / 3.
            let gaussian = GaussianBlur { radius: radius / 3f32.sqrt() };
            Some(Finer {
                shortcut: "box blur".into(),
                truth: "Gaussian of the same width".into(),
                node: Arc::new(gaussian),
            })
        }
        "height_to_ambient_occlusion" => {
            let coarse: HeightToAmbientOcclusion = settings.try_into().ok()?;
            let (directions, steps) = ((coarse.directions * 4).min(64), (coarse.steps * 4).min(64));
            let says = |d: u32, s: u32| format!("{d} directions of {s} steps");
            Some(Finer {
                shortcut: format!("occlusion in {}", says(coarse.directions, coarse.steps)),
                truth: says(directions, steps),
                node: Arc::new(HeightToAmbientOcclusion { directions, steps, ..coarse }),
            })
        }
        "height_to_curvature" => {
            let own: HeightToCurvature = settings.try_into().ok()?;
            Some(Finer {
                shortcut: "curvature's blur cut at 3 sigma".into(),
                truth: format!("cut at {TAIL} sigma"),
                node: Arc::new(Instead { node: node.clone(), way: Way::Curvature(own) }),
            })
        }
        "gray_scott" => {
            let own: GrayScott = settings.try_into().ok()?;
            Some(Finer {
                shortcut: format!("reaction in steps of {}", GrayScott::STEP),
                truth: format!("steps of {FINE_STEP}"),
                node: Arc::new(Instead { node: node.clone(), way: Way::Reaction(own) }),
            })
        }
        _ => None,
    }
}

/// Standard deviations at which the finer blur ends: its weight is 1e-14 there.
const TAIL: f64 = 8.0;
/// Time per step of the finer reaction.
const FINE_STEP: f32 = 0.25;

/// A node that is made in another way; all else is the node's own.
#[derive(Debug)]
struct Instead {
    node: Arc<dyn Node>,
    way: Way,
}

#[derive(Debug)]
enum Way {
    /// The curvature of a height that is blurred further out, in f64.
    Curvature(HeightToCurvature),
    /// A reaction in smaller steps.
    Reaction(GrayScott),
}

impl Node for Instead {
    fn spec(&self) -> &'static Spec {
        self.node.spec()
    }
    fn check(&self) -> Vec<ParamError> {
        self.node.check()
    }
    fn reach(&self, domain: &Domain) -> Reach {
        match self.way {
            Way::Curvature(_) => Reach::Whole,
            Way::Reaction(_) => self.node.reach(domain),
        }
    }
    fn cost_ns(&self) -> f32 {
        self.node.cost_ns()
    }
    fn own_bytes(&self, domain: &Domain, rows: usize) -> u64 {
        self.node.own_bytes(domain, rows)
    }
    fn forwards(&self) -> Option<usize> {
        self.node.forwards()
    }
    fn overwrites(&self) -> Option<usize> {
        None
    }
    fn files(&self) -> Vec<&str> {
        self.node.files()
    }
    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        match &self.way {
            Way::Curvature(_) => None,
            Way::Reaction(own) => Some(own.solved(cx, FINE_STEP)),
        }
    }
    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let Way::Curvature(HeightToCurvature { radius }) = self.way else {
            return self.node.eval(cx, rows, ins, outs);
        };
        let height = rows.clone().flat_map(|y| ins.row(0, y)).map(|v| f64::from(*v)).collect();
        let height = Lane::Each(height);
        let ins = Ins { domain: &cx.domain, offsets: &[0, 1], lanes: vec![&height] };
        if let [Lane::Each(made)] = &kernels::curvature(radius, TAIL, &ins)[..]
            && let Some(out) = outs.band(0)
        {
            for (out, v) in out.iter_mut().zip(made) {
                *out = *v as f32;
            }
        }
    }
    fn settings(&self) -> toml::Table {
        self.node.settings()
    }
}
