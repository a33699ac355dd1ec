//! How long one evaluation takes.

use std::hint::black_box;
use std::time::Instant;

use super::metric::quantile;

/// Nanoseconds of one evaluation, on one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Of the fastest round: what the code costs.
    pub best_ns: f64,
    /// Of the median round: what it took here, with whatever else ran.
    pub median_ns: f64,
}

/// Time `f` over all inputs, `rounds` times (at least once), after one round that warms caches and makes tables.
///
/// Inputs and results go through [`black_box`], so that nothing is computed beforehand or not at all; the cost of
/// reading an input and of storing a result is in it.
pub fn per_evaluation<I, O>(inputs: &[I], rounds: usize, mut f: impl FnMut(&I) -> O) -> Timing {
    let mut round = || {
        let start = Instant::now();
        for input in black_box(inputs) {
            black_box(f(input));
        }
        start.elapsed().as_secs_f64() * 1e9 / inputs.len().max(1) as f64
    };
    round();
    let times: Vec<f64> = (0..rounds.max(1)).map(|_| round()).collect();
    Timing { best_ns: quantile(&times, 0.0), median_ns: quantile(&times, 0.5) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_is_evaluated_in_every_round() {
        let mut count = 0;
        let timing = per_evaluation(&[1, 2, 3], 5, |i| count += i);
        assert_eq!(count, 6 * 6);
        assert!(timing.best_ns >= 0.0 && timing.best_ns <= timing.median_ns);
    }
}
