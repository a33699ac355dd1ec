//! Quotient.

use super::blend::blend;

blend! {
    /// `a / b`, not clamped; 0 where `b` is 0.
    Divide = "divide": "Divides one image by another.";
    a: "What is divided.", b: "The divisor; where it is 0 the result is 0.", result: "The quotient.";
    |a, b| {
        let zero = b == 0.0;
        let quotient = a / if zero { 1.0 } else { b };
        if zero { 0.0 } else { quotient }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::combine::blend::texel;

    #[test]
    fn it_divides_and_0_is_safe() {
        assert_eq!(texel(&Divide::default(), &[0.5, -0.25]), -2.0);
        assert_eq!(texel(&Divide::default(), &[0.3, 1.0]), 0.3);
        assert_eq!(texel(&Divide::default(), &[0.3, 0.0]), 0.0);
        assert_eq!(texel(&Divide::default(), &[0.3, -0.0]), 0.0);
        assert_eq!(texel(&Divide::default(), &[-1.0, 1e-40]), f32::MIN);
    }
}
