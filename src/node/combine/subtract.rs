//! Difference with its sign.

use super::blend::blend;

blend! {
    /// `a - b`, not clamped.
    Subtract = "subtract": "Takes one image from another.";
    a: "What is taken from.", b: "What is taken.", result: "The difference with its sign, not clamped.";
    |a, b| a - b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_subtracts_and_keeps_the_sign() {
        assert_eq!(texel(&Subtract::default(), &[0.25, 0.5]), -0.25);
        assert_eq!(texel(&Subtract::default(), &[0.3, 0.0]), 0.3);
    }
}
