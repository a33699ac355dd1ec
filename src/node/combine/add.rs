//! Sum.

use super::blend::blend;

blend! {
    /// `a + b`, not clamped: heights in mm add up.
    Add = "add": "Adds one image to another.";
    a: "First summand.", b: "Second summand.", result: "The sum, not clamped.";
    |a, b| a + b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_adds_and_0_changes_nothing() {
        assert_eq!(texel(&Add::default(), &[0.25, 0.5]), 0.75);
        assert_eq!(texel(&Add::default(), &[0.3, 0.0]), 0.3);
        assert_eq!(texel(&Add::default(), &[f32::MAX, f32::MAX]), f32::MAX);
    }
}
