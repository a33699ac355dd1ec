//! Anything at all on the whole skin: the BRDF of all layers over random and extreme inputs, in f32.

use rayon::prelude::*;

use crate::base::{hash, num};
use crate::optics::base_layer::{Base, Tint};
use crate::optics::layered::{Albedo, Constants, Energy, Layers, Point};
use crate::optics::{Bands, Film, FilmColor, Method, Parts, Spectral};

/// What a sweep found. A point is one surface, one view, one light, and one direction that the surface itself chose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinSweep {
    /// Points.
    pub count: u64,
    /// Values and densities that are no numbers.
    pub not_numbers: u64,
    /// Values and densities below 0.
    pub negative: u64,
    /// Most by which what the film reflects and what it lets through are more than what comes.
    pub energy: f64,
}

impl SkinSweep {
    fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            not_numbers: self.not_numbers + other.not_numbers,
            negative: self.negative + other.negative,
            energy: self.energy.max(other.energy),
        }
    }

    /// Look at a value and a density.
    fn look(&mut self, values: impl IntoIterator<Item = f32>) {
        for value in values {
            self.not_numbers += u64::from(!value.is_finite());
            self.negative += u64::from(value < 0.0);
        }
    }
}

/// Every base, meaning of the albedo and share of energy, on skins of usual and of odd indices.
fn skins() -> Vec<Constants> {
    let bases = [
        Base::Lambert,
        Base::HalfLambert { blood: [0.6, 0.0, 0.0], tint: Tint::FromNormal },
        Base::HalfLambert { blood: [1.0, 0.1, 0.0], tint: Tint::FromHorizon },
        Base::Curved { curvature_per_mm: 0.5, thickness_mm: f32::INFINITY },
        Base::Curved { curvature_per_mm: 0.02, thickness_mm: 0.8 },
    ];
    let indices = [[1.0, 1.55, 2.0], [1.33, 1.55, 1.4], [2.0, 2.2, 1.0], [1.0, 1.0 + 1e-6, 1.0]];
    let mut skins = Vec::new();
    for indices in indices {
        for base in bases {
            for albedo in [Albedo::Apparent, Albedo::Intrinsic] {
                for energy in [Energy::Flat, Energy::Coupled] {
                    skins.push(Constants { indices, base, albedo, energy, ..Constants::default() });
                }
            }
        }
    }
    skins
}

/// `count` random points, a third of all numbers from the corners of their ranges and from beyond them: as many for each
/// kind of skin, half of them in red, green and blue, half in four wavelengths.
pub fn sweep(count: u64) -> SkinSweep {
    const CHUNK: u64 = 1 << 12;
    let layers: Vec<Layers<f32>> = skins().iter().filter_map(|skin| Layers::new(skin).ok()).collect();
    let colors = FilmColor::<f32>::new(Method::Series(3));
    let spectral = Spectral::new([400.0f32, 500.0, 600.0, 700.0]);
    let chunk = |chunk: u64| {
        let mut random = Random((chunk as u32).wrapping_mul(0x0100_0193));
        let layers = &layers[chunk as usize / 2 % layers.len()];
        let mut found = SkinSweep::default();
        for _ in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
            if chunk.is_multiple_of(2) {
                one(&mut random, layers, &colors, &mut found);
            } else {
                one(&mut random, layers, &spectral, &mut found);
            }
        }
        found
    };
    (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(SkinSweep::default, SkinSweep::and)
}

struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        hash::unit(hash::pcg(self.0))
    }

    /// A corner, or a number between two.
    fn draw(&mut self, corners: &[f32], low: f32, high: f32) -> f32 {
        let at = low + (high - low) * self.unit();
        let bits = hash::pcg(self.0 ^ 0x5bd1_e995);
        if bits.is_multiple_of(3) { corners[(bits / 3) as usize % corners.len()] } else { at }
    }

    /// A unit vector, seldom below the horizon.
    fn direction(&mut self) -> [f32; 3] {
        let z = self.draw(&[1.0, 1e-30, 1e-12, 1e-7, 1e-4, 0.0, -0.3, 0.999_999_9, 0.5], 0.0, 1.0);
        let turns = self.draw(&[0.0, 0.5, 1.0], 0.0, 1.0);
        let r = num::safe_sqrt((1.0 - z) * (1.0 + z));
        [r * num::cos_turns(turns), r * num::sin_turns(turns), z]
    }
}

fn one<B: Bands<f32, N>, const N: usize>(
    random: &mut Random,
    layers: &Layers<f32>,
    bands: &B,
    found: &mut SkinSweep,
) {
    let point = Point {
        thickness_nm: random.draw(&[0.0, f32::NAN, -1.0, 1e-30, 2.4e6, 1e9, f32::INFINITY], 0.0, 3000.0),
        roughness: random.draw(&[0.0, 1.0, 0.01, 0.0101, f32::NAN, -1.0, 2.0], 0.0, 1.0),
        albedo: [random.draw(&[0.0, 1.0, f32::NAN, -1.0, 2.0, 1e-30], 0.0, 1.0); N],
        absorption: [random.draw(&[0.0, 1e-30, 1e6, f32::INFINITY, f32::NAN, -1.0, 86.9], 0.0, 3.0); N],
    };
    let parts = [Parts::All, Parts::Specular, Parts::Diffuse, Parts::Lambert];
    let parts = parts[(random.unit() * 4.0) as usize];
    let (wo, wi) = (random.direction(), random.direction());
    found.count += 1;

    let view = layers.view(bands, &point, wo, parts);
    let (f, pdf) = view.eval_pdf(wi);
    found.look(f.into_iter().chain([pdf]));
    if let Some(sample) = view.sample([random.unit(), random.unit(), random.unit()]) {
        found.look(sample.f.into_iter().chain([sample.pdf]));
        found.not_numbers += sample.wi.iter().filter(|x| !x.is_finite()).count() as u64;
    }

    let [n0, n1, n2] = layers.constants().indices;
    if let Ok(film) = Film::new(n0, n1, n2, point.thickness_nm) {
        let (r, t) = (bands.reflectance(&film, wi[2]), bands.transmittance(&film, wi[2]));
        found.look(r.into_iter().chain(t));
        for (r, t) in r.into_iter().zip(t) {
            found.energy = found.energy.max(f64::from(r) + f64::from(t) - 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_finds_numbers_only_and_counts_every_point() {
        let found = sweep(400_001);
        assert_eq!((found.count, found.not_numbers, found.negative), (400_001, 0, 0));
        assert!(found.energy < 2e-6, "{found:?}");
        // All kinds had their turn.
        assert!(skins().len() == 80 && 400_001 / (1 << 12) / 2 >= 48);
    }

    #[test]
    fn what_is_wrong_is_counted() {
        let mut found = SkinSweep::default();
        found.look([1.0, f32::NAN, -1e-30, f32::INFINITY, 0.0, -0.0]);
        assert_eq!((found.not_numbers, found.negative), (2, 1));
        let both = found.and(SkinSweep { count: 3, energy: 0.5, ..SkinSweep::default() });
        assert_eq!((both.count, both.not_numbers, both.energy), (3, 2, 0.5));
    }
}
