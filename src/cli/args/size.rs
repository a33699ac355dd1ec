//! Sizes of maps and pictures.

use std::str::FromStr;

use crate::base::{Domain, domain::MAX_SIDE};

/// A size in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum SizeArg {
    /// The longer side; the other one follows from the tile.
    Longer(usize),
    /// Both.
    Exact(usize, usize),
}

impl SizeArg {
    /// The grid of a tile of this physical size.
    pub(in crate::cli) fn domain(self, girth_mm: f32, length_mm: f32) -> Domain {
        match self {
            Self::Longer(n) => Domain::from_longer_side(n, girth_mm, length_mm),
            Self::Exact(width, height) => Domain { width, height, girth_mm, length_mm },
        }
    }
}

impl FromStr for SizeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| match text.parse::<usize>() {
            Ok(n) if (1..=MAX_SIDE).contains(&n) => Ok(n),
            // A number that no integer holds is a number still.
            _ if !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit()) => {
                Err(format!("a side has 1 to {MAX_SIDE} texels"))
            }
            _ => Err("write the texels of the longer side, such as 2048, or WIDTHxHEIGHT".to_owned()),
        };
        match text.split_once(['x', 'X', '×']) {
            Some((w, h)) => Ok(Self::Exact(side(w)?, side(h)?)),
            None => side(text).map(Self::Longer),
        }
    }
}

/// Width and height of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct PixelsArg(pub(in crate::cli) [usize; 2]);

impl FromStr for PixelsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse()? {
            SizeArg::Exact(width, height) => Ok(Self([width, height])),
            SizeArg::Longer(_) => Err("a picture has a width and a height, such as 960x540".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_one_or_two_sides_within_bounds() {
        assert_eq!("2048".parse(), Ok(SizeArg::Longer(2048)));
        assert_eq!("64x128".parse(), Ok(SizeArg::Exact(64, 128)));
        for bad in ["0", "0x0", "64x0", "1000000000", "99999999999999999999999", "65537", "", "x", "-4", "2k"]
        {
            assert!(bad.parse::<SizeArg>().is_err(), "{bad}");
        }
    }
}
