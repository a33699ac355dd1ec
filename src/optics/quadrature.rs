//! Gauss-Legendre rules.

use std::f64::consts::PI;

/// Nodes and weights of the Gauss-Legendre rule with `count` nodes on [0, 1], ascending; weights sum to 1.
///
/// Newton's method on the Legendre polynomial from the asymptotic places of its roots (Abramowitz & Stegun 22.16.6 and
/// 25.4.29).
pub(super) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |i: usize| {
        let mut x = -libm::cos(PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..50 {
            let (mut now, mut before) = (x, 1.0);
            for k in 2..=count {
                let k = k as f64;
                (now, before) = (((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k, now);
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            let step = now / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        ((1.0 + x) * 0.5, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_up_to_twice_the_count_are_exact() {
        for count in [1, 2, 4, 24, 64] {
            let rule = gauss_legendre(count);
            for power in [0, 1, 2 * count - 1] {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = 1.0 / (power as f64 + 1.0);
                assert!((sum - exact).abs() < 1e-14, "{count} {power}: {sum}");
            }
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(2 * count as i32)).sum();
            assert!(count > 10 || (sum - 1.0 / (2.0 * count as f64 + 1.0)).abs() > 1e-8);
        }
        // Abramowitz & Stegun, table 25.4.
        let rule = gauss_legendre(4);
        assert!((rule[0].0 - 0.069_431_844_202_973_71).abs() < 1e-15);
        assert!((rule[1].1 - 0.326_072_577_431_273_07).abs() < 1e-15);
    }
}
