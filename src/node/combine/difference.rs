//! Distance.

use super::blend::blend;

blend! {
    /// `|a - b|`: 0 where both agree.
    Difference = "difference": "Shows how far two images are apart.";
    a: "First image.", b: "Second image.", result: "The distance, 0 where both agree.";
    |a, b| (a - b).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_is_the_distance() {
        assert_eq!(texel(&Difference::default(), &[0.25, 0.75]), 0.5);
        assert_eq!(texel(&Difference::default(), &[0.3, 0.3]), 0.0);
    }
}
