//! The absorbing layer below the film: pigment that light crosses on its way in and out.

use super::fresnel::{admittance_squared, usable_cosine};
use super::real::Real;

/// Least cosine in the layer: for n2 = n0 a grazing path would be endless.
const LEAST_COSINE: f64 = 1e-4;

/// Cosine of the angle in n2 of a ray that comes at `cosine` in n0, at least 1e-4; beyond the critical angle that too.
///
/// Snell: `n2 cos2 = sqrt(n2^2 - n0^2 sin0^2)`. The layer is the medium below the film, so n1 plays no part
/// (thesis 4.16 takes the angle in the film).
#[inline(always)]
pub fn cosine_in_layer<F: Real>(n0: F, n2: F, cosine: F) -> F {
    let x = n0 * usable_cosine(cosine);
    (admittance_squared(n0, n2, x).safe_sqrt() / n2).max(F::from_f64(LEAST_COSINE)).min(F::ONE)
}

/// Part of the light that survives one way through the layer: `exp(-tau/cos2)`.
///
/// `tau` >= 0 is absorption coefficient times thickness, along the normal (negative and NaN count as 0; infinity absorbs
/// all). Source: Beer-Lambert law; thesis 4.16 to 4.19 with the angle of this layer.
pub fn one_way<F: Real>(tau: F, cos2: F) -> F {
    (-(tau.max(F::ZERO) / cos2.max(F::from_f64(LEAST_COSINE)))).exp()
}

/// Part that survives both ways, per channel: `exp(-tau (1/cos2_in + 1/cos2_out))`. Reciprocal.
pub fn both_ways<F: Real>(tau: [F; 3], cos2_in: F, cos2_out: F) -> [F; 3] {
    let least = F::from_f64(LEAST_COSINE);
    let way = F::ONE / cos2_in.max(least) + F::ONE / cos2_out.max(least);
    tau.map(|tau| (-(tau.max(F::ZERO) * way)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_way_at_60_and_80_degrees_is_the_corrected_value() {
        for (degrees, expected) in [(60.0f64, 0.5139), (80.0, 0.5019)] {
            let cos2 = cosine_in_layer(1.0, 2.0, degrees.to_radians().cos());
            assert!((one_way(0.6, cos2) - expected).abs() < 5e-5);
        }
    }

    #[test]
    fn no_absorption_is_1_and_much_is_0_exactly() {
        for c in [0.0f32, 1e-6, 0.5, 1.0] {
            let cos2 = cosine_in_layer(1.0, 1.0, c);
            assert_eq!(both_ways([0.0, 1e6, f32::INFINITY], cos2, 1.0), [1.0, 0.0, 0.0]);
            assert_eq!(one_way(1e6f64, f64::from(cos2)), 0.0);
        }
    }

    #[test]
    fn both_ways_is_one_way_twice_and_reciprocal() {
        let there = both_ways([0.3, 0.6, 1.2], 0.7, 0.9f64);
        assert_eq!(there, both_ways([0.3, 0.6, 1.2], 0.9, 0.7));
        assert!((there[1] - one_way(0.6, 0.7) * one_way(0.6, 0.9)).abs() < 1e-15);
    }
}
