//! The arithmetic of lattice noise, apart from the nodes that show it.
//!
//! A tile holds `cells_u x cells_v` unit cells; a kernel reads wrapped coordinates (u, v) in [0, 1], scales them to
//! cells and hashes the cell's indices *modulo the counts*. So every kernel is periodic for any counts >= 1, and the
//! same at any map size. Gradient and value kernels give signed noise in [-1, 1]; nodes show it as `0.5 + 0.5 n`.
//!
//! Most kernels are plain loops, which LLVM vectorises; [`worley()`] works on explicit lanes, because LLVM leaves
//! its search loop scalar.

mod coords;
mod near;
mod perlin;
mod simplex;
mod square;
mod worley;

pub(in crate::node) use coords::{Coords, Part, columns};
pub(super) use perlin::{Perlin, PerlinRow};
pub(super) use simplex::{Shear, simplex};
pub(super) use square::{value, white};
pub use worley::Metric;
pub(super) use worley::{Bands, worley};

use crate::base::domain::MAX_SIDE;
use crate::base::hash;

/// Cells of a tile in each direction, and the seed of their hashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cells {
    /// Cells around the body, 1 to 65536.
    pub(super) u: u32,
    /// Cells along the body, 1 to 65536.
    pub(super) v: u32,
    /// Seed.
    pub(super) seed: u32,
    /// Where the tile's corner lies in its cell, in cells, each in [0, 1).
    pub(super) phase: [f32; 2],
}

impl Cells {
    /// Counts held within 1 to 65536: beyond, f32 coordinates in cells lose their fraction.
    pub(super) fn new(u: u32, v: u32, seed: u32) -> Self {
        let side = |n: u32| n.clamp(1, MAX_SIDE as u32);
        // `hash2` joins seed and row by xor: mixed first, so that small seeds are not each other's rows reordered.
        Self { u: side(u), v: side(v), seed: hash::pcg(seed), phase: [0.0; 2] }
    }

    /// The same cells with a random phase. Octaves in phase would all vanish at the same lattice points.
    pub(super) fn out_of_phase(mut self) -> Self {
        self.phase = [0, 1].map(|axis| hash::unit(hash::hash1(self.seed, axis)));
        self
    }

    /// The point (`u`, `v`) in cells, in [0, cells + 1).
    #[inline(always)]
    fn at(&self, u: f32, v: f32) -> (f32, f32) {
        (u * self.u as f32 + self.phase[0], v * self.v as f32 + self.phase[1])
    }
}

/// `floor(x)` for |x| < 2^22, without a call to the C library where the target has no rounding instruction.
#[inline(always)]
fn floor(x: f32) -> f32 {
    // Adding 1.5 * 2^23 leaves no bits below 1: x rounds to the nearest integer.
    let r = (x + 12_582_912.0) - 12_582_912.0;
    if r > x { r - 1.0 } else { r }
}

/// The integer that `x` holds, for integer-valued 0 <= x < 2^23.
#[inline(always)]
fn to_u32(x: f32) -> u32 {
    (x + 8_388_608.0).to_bits() & 0x007f_ffff
}

/// Perlin's quintic fade 6 t^5 - 15 t^4 + 10 t^3 (2002).
#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    #[test]
    fn floor_and_integer_are_those_of_std() {
        for i in -40_000..40_000 {
            let x = i as f32 * 0.37;
            assert_eq!(super::floor(x), x.floor(), "{x}");
        }
        for i in [0u32, 1, 7, 65_535, 8_388_607] {
            assert_eq!(super::to_u32(i as f32), i);
        }
    }
}
