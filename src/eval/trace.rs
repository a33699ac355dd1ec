//! Time by step: the one place of the evaluator that reads a clock. It never reaches an output.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::plan::Step;

/// Time spent in each step, summed over threads.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// One row per step, in plan order.
    pub steps: Vec<StepTime>,
}

/// Time spent in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepTime {
    /// The node's name.
    pub name: String,
    /// The operation.
    pub op: &'static str,
    /// Thread time, ms.
    pub ms: f64,
}

/// Collects time from any thread.
#[derive(Debug)]
pub(super) struct Stopwatch {
    nanos: Vec<AtomicU64>,
}

impl Stopwatch {
    pub(super) fn new(steps: usize) -> Self {
        Self { nanos: (0..steps).map(|_| AtomicU64::new(0)).collect() }
    }

    pub(super) fn time<T>(&self, step: usize, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.nanos[step].fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    pub(super) fn trace(&self, steps: &[Step]) -> Trace {
        let steps = steps
            .iter()
            .zip(&self.nanos)
            .map(|(s, n)| StepTime {
                name: s.name.clone(),
                op: s.node.spec().name,
                ms: n.load(Ordering::Relaxed) as f64 * 1e-6,
            })
            .collect();
        Trace { steps }
    }
}
