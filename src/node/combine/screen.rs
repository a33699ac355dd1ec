//! Screen.

use super::blend::blend;
use crate::base::num::saturate;

blend! {
    /// `1 - (1 - a) (1 - b)` with both clamped to [0, 1]: lightens without burning out, as two projectors on one wall.
    Screen = "screen": "Lightens by another image without burning out.";
    a: "The image below, in [0, 1].", b: "The image that lightens: 0 changes nothing, 1 is white.",
    result: "At least as light as either, in [0, 1].";
    |a, b| {
        // Multiplied out so that 0 and 1 are exact.
        let (a, b) = (saturate(a), saturate(b));
        a + b * (1.0 - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn zero_changes_nothing_and_1_is_white() {
        for i in 0..=1000 {
            let a = i as f32 / 1000.0;
            assert_eq!(texel(&Screen::default(), &[a, 0.0]), a);
            assert_eq!(texel(&Screen::default(), &[a, 1.0]), 1.0);
        }
        assert!((texel(&Screen::default(), &[0.2, 0.3]) - 0.44).abs() < 1e-6);
    }
}
