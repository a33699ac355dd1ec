//! Where the random numbers of a path come from.

use super::sobol;
use crate::base::hash;

/// A way to choose the samples of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points, four dimensions at a time, padded by shuffling (Burley 2020, Practical Hash-based Owen
    /// Scrambling, JCGT 9(4)).
    #[default]
    Sobol,
    /// Independent uniform numbers.
    Independent,
}

impl SamplerKind {
    /// The name in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
        }
    }
}

/// The random numbers of L samples of one pixel, side by side: each a pure function of seed, pixel and index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samplers<const L: usize> {
    kind: SamplerKind,
    /// Of the pixel.
    seeds: [u32; L],
    /// Which samples.
    indices: [u32; L],
    /// How many sets of four have been given.
    set: u32,
}

impl<const L: usize> Samplers<L> {
    /// For samples of a pixel.
    #[inline(always)]
    pub(super) fn new(kind: SamplerKind, seed: u32, pixel: [u32; 2], mut indices: [u32; L]) -> Self {
        let seed = hash::hash2(seed, pixel[0], pixel[1]);
        let mut seeds = [0; L];
        for lane in 0..L {
            // The sequence has 2^16 points; further ones are those of another scrambling.
            seeds[lane] = hash::hash1(seed, indices[lane] >> 16);
            indices[lane] &= 0xffff;
        }
        Self { kind, seeds, indices, set: 0 }
    }

    /// One of them, alone from here on.
    #[inline(always)]
    pub(super) fn one(&self, lane: usize) -> Samplers<1> {
        let Self { kind, seeds, indices, set } = *self;
        Samplers { kind, seeds: [seeds[lane]], indices: [indices[lane]], set }
    }

    /// Four numbers in [0, 1) for each, stratified among the samples of the pixel.
    #[inline(always)]
    pub(super) fn next(&mut self) -> [[f32; 4]; L] {
        // Plain code: closures handed to std are not compiled for the wider instruction set.
        let mut sets = [0; L];
        for lane in 0..L {
            sets[lane] = hash::hash1(self.seeds[lane], self.set);
        }
        self.set += 1;
        match self.kind {
            SamplerKind::Sobol => sobol::fours(&self.indices, &sets),
            SamplerKind::Independent => {
                let mut numbers = [[0.0; 4]; L];
                for lane in 0..L {
                    for k in 0..4 {
                        numbers[lane][k] = hash::unit(hash::hash2(sets[lane], self.indices[lane], k as u32));
                    }
                }
                numbers
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square of the error of the mean of x y over `n` samples, averaged over pixels.
    fn squared_error(kind: SamplerKind, n: u32) -> f64 {
        let pixels = 256;
        (0..pixels)
            .map(|pixel| {
                let sum: f64 = (0..n)
                    .map(|i| {
                        let mut sampler = Samplers::new(kind, 7, [pixel, 3], [i]);
                        sampler.next();
                        let [u] = sampler.next();
                        f64::from(u[0]) * f64::from(u[1])
                    })
                    .sum();
                (sum / f64::from(n) - 0.25).powi(2)
            })
            .sum::<f64>()
            / f64::from(pixels)
    }

    #[test]
    fn independent_samples_have_the_variance_of_chance_and_sobol_points_much_less() {
        // Variance of x y is 1/9 - 1/16.
        let chance = (1.0 / 9.0 - 1.0 / 16.0) / 64.0;
        let independent = squared_error(SamplerKind::Independent, 64);
        assert!((independent / chance - 1.0).abs() < 0.35, "{independent} {chance}");
        let sobol = squared_error(SamplerKind::Sobol, 64);
        assert!(sobol < independent / 50.0, "{sobol} {independent}");
    }

    #[test]
    fn numbers_depend_on_nothing_but_their_place_and_lie_in_the_unit_interval() {
        for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
            let draw = |pixel, index| {
                let mut sampler = Samplers::new(kind, 1, pixel, [index]);
                [sampler.next(), sampler.next()].map(|[u]| u)
            };
            assert_eq!(draw([4, 5], 70_000), draw([4, 5], 70_000));
            assert_ne!(draw([4, 5], 70_000), draw([4, 5], 70_000 & 0xffff));
            assert_ne!(draw([4, 5], 1), draw([5, 4], 1));
            // Neighbours change nothing.
            let mut three = Samplers::new(kind, 1, [4, 5], [1, 70_000, 3]);
            let drawn = [three.next(), three.next()];
            for (lane, index) in [1, 70_000, 3].into_iter().enumerate() {
                assert_eq!(drawn.map(|u| u[lane]), draw([4, 5], index));
            }
            for i in 0..4096 {
                assert!(draw([0, 0], i).as_flattened().iter().all(|u| (0.0..1.0).contains(u)));
            }
        }
    }
}
