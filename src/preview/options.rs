//! What is chosen rather than found in a scene, and what suits an adapter.

use super::Gpu;
use super::program::SkinOptions;

/// What is chosen rather than found in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Of materials.
    pub skin: SkinOptions,
    /// Small lights that a rectangle becomes, a power of two (others are rounded down); four times as many where 16 pictures or more are averaged, as no
    /// more of them shine in one.
    pub rectangle_samples: usize,
    /// Texels of a side of a sun's shadow map.
    pub shadow_size: u32,
    /// Texels of a side of the shadow map of a small light of a rectangle; these blur each other's edges.
    pub rectangle_shadow_size: u32,
    /// Most samples of a map along a slanted view, 1 to 16.
    pub anisotropy: u16,
    /// Added to the level of maps that a pixel, or its part of one, covers: sharper ones than a box over it would need, as levels
    /// are smooth, too. Measured at one sample, the difference to supersampling is 12 % less with -0.5 than with 0. At -16
    /// there are no levels but the sharpest.
    pub map_bias: f32,
    /// Whether maps are bytes, with roots of colours, and how much a film varies below a texel is read unfiltered. Only where
    /// pixels have fewer than 4 samples.
    pub compact_maps: bool,
    /// Whether a pixel looks up the shadows of a fourth of the small lights of a rectangle, and shares the rest with its
    /// neighbours, and a quarter of a rectangle is one lobe. Only where pixels have fewer than 4 samples and rectangles 16 small
    /// lights.
    pub shared_shadows: bool,
    /// Whether colours are computed once for each pixel before edges are smoothed, not once for each triangle in it.
    pub once: bool,
    /// Whether triangles of the material that most of them wear are first recorded and then shaded pixel by pixel. Only where
    /// colours are computed once for each pixel.
    pub deferred: bool,
    /// Pictures that are averaged, each of another place within pixels, at least 1. A multiple of 4 costs least: in each of
    /// four pictures other ones of a rectangle's small lights shine.
    pub samples: u32,
    /// Whether the environment lights objects; it is seen behind them in any case.
    pub environment: bool,
    /// Directions in which a sample looks at a picture of all around for what its gloss mirrors, each with what the film
    /// reflects of it. With 0 the picture is blurred beforehand, and times what the film reflects of even light (a split sum),
    /// as it is in any case where there are ridges. `None` is what suits: 4 where pixels have 16 samples or more, else 0,
    /// as fewer directions are off by more than a split sum (measured on an even skin by day).
    pub sky_directions: Option<u32>,
    /// Whether suns and rectangles light objects.
    pub lamps: bool,
    /// Planes in which each pixel looks for what hides the environment from it (ambient occlusion in screen space), 2 are
    /// enough; with 0 the environment's light goes through everything.
    pub occlusion_slices: u32,
    /// Times the height map by which maps are looked up where a ray of view meets its relief (parallax occlusion mapping): what a
    /// displacement by as much shows, but for outlines and shadows. With 0 they are looked up on the surface.
    pub parallax: f32,
    /// Heights at which such a ray is compared with the ground, at least 1.
    pub parallax_steps: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            skin: SkinOptions::default(),
            rectangle_samples: 16,
            shadow_size: 1024,
            rectangle_shadow_size: 512,
            anisotropy: 8,
            map_bias: -0.5,
            compact_maps: false,
            shared_shadows: false,
            once: false,
            deferred: false,
            samples: 1,
            environment: true,
            sky_directions: None,
            lamps: true,
            occlusion_slices: 0,
            parallax: 0.0,
            parallax_steps: 16,
        }
    }
}

impl Options {
    /// Planes in which each pixel looks for what hides the environment: with one it errs by twice as much, four gain nothing.
    pub const SLICES: u32 = 2;

    /// What suits an adapter. One that is a program on the CPU shades pixels once (Mesa 22.3 shades all that is hidden, too,
    /// where pixels have samples: measured, four times the time of all else), and gets maps without anisotropy (some slanted
    /// samples of it read the whole map there: measured, 39 s for a picture that takes 2 without). And what takes long there for
    /// little that is seen is done by less: see `report preview`.
    ///
    /// What hides the environment is sought where the adapter is no such program: there it is as much work as half of all else.
    /// Pictures of a coil by day are off by a quarter to a half of what they are without, from direct light that is truly hidden
    /// (CIEDE2000 of 0.6 in place of 2.4 with an even skin, 1.6 in place of 3.4 with maps).
    pub fn of(gpu: &Gpu) -> Self {
        let all = Self::default();
        if gpu.is_software() {
            Self {
                anisotropy: 1,
                compact_maps: true,
                shared_shadows: true,
                once: true,
                deferred: true,
                ..all
            }
        } else {
            Self { samples: 16, occlusion_slices: Self::SLICES, ..all }
        }
    }
}

/// Most samples over which the small lights of rectangles are spread, and samples from which on few shine in each.
pub(super) const MOST_STEP: u32 = 16;
pub(super) const FEWER_STEP: u32 = 4;

impl Options {
    /// Directions in which a sample looks at a picture of all around.
    pub(super) fn directions(&self) -> u32 {
        self.sky_directions.unwrap_or(if self.samples < MOST_STEP { 0 } else { 4 })
    }

    /// What is added to the level of maps that a whole pixel covers. Where samples share it, to that of each one's own part of
    /// it, and one more, as samples do what is left of the mean. Measured at 4 and 16 samples, mean CIEDE2000: 14 and 18 %
    /// less than without, and no more with two levels more.
    pub(super) fn sharper(&self) -> f32 {
        let shared = if self.samples <= 1 { 0.0 } else { -0.5 * (self.samples as f32).log2() - 1.0 };
        self.map_bias + shared
    }
}

/// Triangles that are enough for a subject in a picture of so many pixels: with them the outline of a coiled snake is less than
/// half a pixel from a smooth one, at any size, as it is off by its width over the triangles. More cost a program on the CPU
/// time: it shades whole squares of 16 pixels. Displaced surfaces need more.
pub fn enough_triangles([width, height]: [usize; 2], displaced: bool) -> u32 {
    const MOST: usize = 40_000;
    let enough = if displaced { MOST } else { (20 * width.saturating_mul(height).isqrt()).clamp(4000, MOST) };
    enough as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_pictures_have_more_triangles_up_to_a_limit() {
        assert_eq!(enough_triangles([1280, 720], false), 19_200);
        assert_eq!(enough_triangles([2560, 1440], false), 38_400);
        assert_eq!(
            (enough_triangles([0, 5], false), enough_triangles([usize::MAX; 2], false)),
            (4000, 40_000)
        );
        assert_eq!(enough_triangles([64, 48], true), 40_000);
    }
}
