//! How far colours are apart, and pictures.

pub use super::flip::{FlipError, PIXELS_PER_DEGREE, flip};
use crate::optics::cie;

/// Differences of linear colours so far.
#[derive(Clone, Debug, Default)]
pub struct ColorErrors {
    squares: f64,
    max: f64,
    delta_e: Vec<f64>,
}

impl ColorErrors {
    /// Add a colour and the true one, linear sRGB.
    pub fn add(&mut self, color: [f64; 3], truth: [f64; 3]) {
        for (a, b) in color.iter().zip(truth) {
            let e = (a - b).abs();
            self.squares += e * e;
            // A NaN is the worst of all, and `max` would lose it.
            self.max = if e.is_nan() { f64::INFINITY } else { self.max.max(e) };
        }
        self.delta_e.push(cie::delta_e_2000(cie::lab(color), cie::lab(truth)));
    }

    /// Colours so far.
    pub fn count(&self) -> usize {
        self.delta_e.len()
    }

    /// Root of the mean square over all channels; 0 without colours.
    pub fn rmse(&self) -> f64 {
        (self.squares / (3 * self.count()).max(1) as f64).sqrt()
    }

    /// Greatest difference of a channel.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Mean CIEDE2000; 1 is about what an eye can tell.
    pub fn delta_e_mean(&self) -> f64 {
        self.delta_e.iter().sum::<f64>() / self.count().max(1) as f64
    }

    /// The CIEDE2000 that a share of the colours stays within: 0.99 is the 99th percentile, 1 the greatest.
    pub fn delta_e_quantile(&self, share: f64) -> f64 {
        quantile(&self.delta_e, share)
    }
}

/// The least of the values that at least `share` of all are not above; 0 without values.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_the_definitions() {
        let mut errors = ColorErrors::default();
        assert_eq!((errors.rmse(), errors.delta_e_mean(), errors.delta_e_quantile(0.99)), (0.0, 0.0, 0.0));
        errors.add([0.5; 3], [0.5; 3]);
        errors.add([0.0, 0.0, 0.3], [0.0; 3]);
        assert!((errors.rmse() - (0.09f64 / 6.0).sqrt()).abs() < 1e-15);
        assert_eq!((errors.max(), errors.count()), (0.3, 2));
        assert_eq!(errors.delta_e_quantile(0.5), 0.0);
        assert_eq!(errors.delta_e_quantile(1.0), 2.0 * errors.delta_e_mean());
        errors.add([f64::NAN; 3], [0.0; 3]);
        assert_eq!(errors.max(), f64::INFINITY);
    }

    #[test]
    fn quantiles_are_ranks() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!([0.0, 0.01, 0.5, 0.99, 1.0].map(|q| quantile(&values, q)), [1.0, 1.0, 50.0, 99.0, 100.0]);
    }
}
