//! Maximum.

use super::blend::blend;

blend! {
    /// The larger of `a` and `b`, channel by channel: lighten, or the union of masks.
    Max = "max": "Keeps the larger of two images.";
    a: "First image.", b: "Second image.", result: "The larger.";
    |a, b| a.max(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_is_the_larger() {
        assert_eq!(texel(&Max::default(), &[0.3, 0.7]), 0.7);
        assert_eq!(texel(&Max::default(), &[-0.7, -0.3]), -0.3);
    }
}
