//! Overlay.

use super::blend::blend;
use crate::base::num::saturate;

blend! {
    /// Multiply where `a` is dark, screen where it is light, with both clamped to [0, 1]: adds contrast and keeps
    /// black and white.
    ///
    /// Source: W3C, Compositing and Blending Level 1, "overlay" (`a` is the backdrop).
    Overlay = "overlay": "Darkens the dark and lightens the light by another image.";
    a: "The image below, in [0, 1].", b: "The image laid on: 0.5 changes nothing.", result: "In [0, 1].";
    |a, b| {
        let (a, b) = (saturate(a), saturate(b));
        let dark = 2.0 * a * b;
        let light = 1.0 - 2.0 * (1.0 - a) * (1.0 - b);
        if a <= 0.5 { dark } else { light }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn half_changes_nothing_and_black_and_white_stay() {
        for i in 0..=100 {
            let v = i as f32 / 100.0;
            assert!((texel(&Overlay::default(), &[v, 0.5]) - v).abs() < 1e-6);
            assert_eq!(texel(&Overlay::default(), &[0.0, v]), 0.0);
            assert_eq!(texel(&Overlay::default(), &[1.0, v]), 1.0);
        }
        assert!((texel(&Overlay::default(), &[0.25, 0.8]) - 0.4).abs() < 1e-6);
        assert!((texel(&Overlay::default(), &[0.75, 0.8]) - 0.9).abs() < 1e-6);
    }

    #[test]
    fn both_halves_meet() {
        for b in [0.0, 0.3, 1.0] {
            let (low, high) =
                (texel(&Overlay::default(), &[0.5, b]), texel(&Overlay::default(), &[0.500_001, b]));
            assert!((low - high).abs() < 1e-5);
        }
    }
}
