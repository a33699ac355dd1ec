//! The methods by name.

use std::fmt;
use std::str::FromStr;

/// Wavelengths of red, green and blue of the thesis, nm.
pub const THESIS_NM: [f64; 3] = [650.0, 510.0, 475.0];
/// The best three wavelengths that were tried in their place, nm.
pub const BEST_NM: [f64; 3] = [612.0, 549.0, 465.0];
/// Most terms of a series, and most wavelengths.
pub const MAX_ORDER: u16 = 4096;
/// Entries along one side of a table of colours.
pub const TABLE_SIZE: (u16, u16) = (2, 1024);

/// How a colour is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The series until less than this is left, for each channel: the truth.
    Adaptive(f64),
    /// The series with so many terms; 3 is right for films on a denser base, and the default of shading.
    Series(u16),
    /// Reflectance at so many uniform wavelengths, weighted.
    Uniform(u16),
    /// Reflectance at three wavelengths, nm, taken as red, green and blue.
    Three([f64; 3]),
    /// As glTF viewers do it: Schlick, two orders, Gaussians; see [`super::belcour`].
    BelcourGltf,
    /// The Gaussians of Belcour and Barla with exact Fresnel terms and three orders.
    Belcour,
    /// The same, each channel divided by what the Gaussians make of white.
    BelcourWhite,
    /// A table of colours of one film by cosine and thickness, with so many entries each; see [`super::table`].
    Table(u16, u16),
}

impl Method {
    /// The truth: less than 1e-7 is left out.
    pub const REFERENCE: Self = Self::Adaptive(1e-7);
    /// The names that [`FromStr`] reads.
    pub const NAMES: &str = "reference, series-K, uniform-N, three, three-best, belcour-gltf, belcour, \
                             belcour-white, lut-N, lut-NxM";
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Adaptive(left) if *self == Self::REFERENCE => write!(f, "reference ({left:e})"),
            Self::Adaptive(left) => write!(f, "adaptive {left:e}"),
            Self::Series(order) => write!(f, "series-{order}"),
            Self::Uniform(count) => write!(f, "uniform-{count}"),
            Self::Three([r, g, b]) => write!(f, "three wavelengths {r}/{g}/{b} nm"),
            Self::BelcourGltf => f.write_str("belcour-gltf"),
            Self::Belcour => f.write_str("belcour"),
            Self::BelcourWhite => f.write_str("belcour-white"),
            Self::Table(cosines, thicknesses) if cosines == thicknesses => write!(f, "lut-{cosines}"),
            Self::Table(cosines, thicknesses) => write!(f, "lut-{cosines}x{thicknesses}"),
        }
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |digits: &str, range: (u16, u16)| match digits.parse::<u16>() {
            Ok(number) if (range.0..=range.1).contains(&number) => Ok(number),
            _ => Err(format!("`{text}`: the number is {} to {}", range.0, range.1)),
        };
        match text {
            "reference" => return Ok(Self::REFERENCE),
            "series" => return Ok(Self::Series(3)),
            "uniform" => return Ok(Self::Uniform(16)),
            "three" => return Ok(Self::Three(THESIS_NM)),
            "three-best" => return Ok(Self::Three(BEST_NM)),
            "belcour-gltf" => return Ok(Self::BelcourGltf),
            "belcour" => return Ok(Self::Belcour),
            "belcour-white" => return Ok(Self::BelcourWhite),
            "lut" => return Ok(Self::Table(256, 256)),
            _ => {}
        }
        match text.split_once('-') {
            Some(("series", digits)) => Ok(Self::Series(number(digits, (1, MAX_ORDER))?)),
            Some(("uniform", digits)) => Ok(Self::Uniform(number(digits, (1, MAX_ORDER))?)),
            Some(("lut", digits)) => {
                let (cosines, thicknesses) = digits.split_once('x').unwrap_or((digits, digits));
                Ok(Self::Table(number(cosines, TABLE_SIZE)?, number(thicknesses, TABLE_SIZE)?))
            }
            _ => Err(format!("there is no method `{text}`; methods: {}", Self::NAMES)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        let names =
            ["series-3", "uniform-16", "belcour-gltf", "belcour", "belcour-white", "lut-256", "lut-512x1024"];
        for name in names {
            assert_eq!(name.parse::<Method>().map(|m| m.to_string()).as_deref(), Ok(name));
        }
        for bad in ["series-0", "series-5000", "uniform-", "lut-1", "lut-8x", "lut-8x2000", "belcour-2", ""] {
            assert!(bad.parse::<Method>().is_err(), "{bad}");
        }
    }
}
