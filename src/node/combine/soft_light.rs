//! Soft light.

use super::blend::blend;
use crate::base::num::saturate;

blend! {
    /// Darkens by `b` below 0.5 and lightens above it, gently, with both clamped to [0, 1]; black and white stay.
    ///
    /// Source: W3C, Compositing and Blending Level 1, "soft-light" (`a` is the backdrop), the form of CSS, SVG and
    /// PDF; not Pegtop's, which differs by up to 0.11.
    SoftLight = "soft_light": "Lightens and darkens gently by another image.";
    a: "The image below, in [0, 1].", b: "The image laid on: 0.5 changes nothing.", result: "In [0, 1].";
    |a, b| {
        let (a, b) = (saturate(a), saturate(b));
        let s = 2.0 * b - 1.0;
        // The lighter curve: the square root, with a polynomial where its slope would be infinite.
        let low = ((16.0 * a - 12.0) * a + 4.0) * a;
        let lighter = if a <= 0.25 { low } else { a.sqrt() };
        let reach = if s <= 0.0 { a * (1.0 - a) } else { lighter - a };
        a + s * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn half_changes_nothing_and_the_ends_are_the_square_and_the_root() {
        for i in 0..=100 {
            let v = i as f32 / 100.0;
            assert_eq!(texel(&SoftLight::default(), &[v, 0.5]), v);
            assert!((texel(&SoftLight::default(), &[v, 0.0]) - v * v).abs() < 1e-6);
            if v > 0.25 {
                assert!((texel(&SoftLight::default(), &[v, 1.0]) - v.sqrt()).abs() < 1e-6);
            }
            assert_eq!(texel(&SoftLight::default(), &[0.0, v]), 0.0);
            assert_eq!(texel(&SoftLight::default(), &[1.0, v]), 1.0);
        }
    }

    #[test]
    fn both_curves_meet_and_it_rises_with_b() {
        let at = |a: f32, b: f32| texel(&SoftLight::default(), &[a, b]);
        assert!((at(0.25, 1.0) - 0.5).abs() < 1e-6 && (at(0.250_01, 1.0) - 0.5).abs() < 1e-4);
        for a in [0.1, 0.4, 0.8] {
            assert!((0..20).all(|i| at(a, i as f32 / 20.0) < at(a, (i + 1) as f32 / 20.0)));
        }
    }

    /// The difference that the node's page states.
    #[test]
    fn pegtops_form_differs_by_up_to_0_11() {
        let mut worst = 0.0f32;
        for i in 0..=200 {
            for j in 0..=200 {
                let (a, b) = (i as f32 / 200.0, j as f32 / 200.0);
                let pegtop = (1.0 - 2.0 * b) * a * a + 2.0 * b * a;
                worst = worst.max((formula(a, b) - pegtop).abs());
            }
        }
        assert!((0.10..0.115).contains(&worst), "{worst}");
    }
}
