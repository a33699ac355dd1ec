//! Product.

use super::blend::blend;

blend! {
    /// `a * b`: scales, masks and darkens.
    Multiply = "multiply": "Multiplies two images.";
    a: "First factor.", b: "Second factor: a mask, or a number to scale by.", result: "The product.";
    |a, b| a * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_multiplies_1_changes_nothing_and_0_clears() {
        assert_eq!(texel(&Multiply::default(), &[0.5, -0.5]), -0.25);
        assert_eq!(texel(&Multiply::default(), &[0.3, 1.0]), 0.3);
        assert_eq!(texel(&Multiply::default(), &[f32::MAX, 0.0]), 0.0);
        assert_eq!(texel(&Multiply::default(), &[1e30, -1e30]), f32::MIN);
    }
}
