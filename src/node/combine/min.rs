//! Minimum.

use super::blend::blend;

blend! {
    /// The smaller of `a` and `b`, channel by channel: darken, or the intersection of masks.
    Min = "min": "Keeps the smaller of two images.";
    a: "First image.", b: "Second image.", result: "The smaller.";
    |a, b| a.min(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_is_the_smaller() {
        assert_eq!(texel(&Min::default(), &[0.3, 0.7]), 0.3);
        assert_eq!(texel(&Min::default(), &[0.7, -0.3]), -0.3);
    }
}
