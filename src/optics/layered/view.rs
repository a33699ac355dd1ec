//! A point of the skin seen from one direction: its BRDF for any light, and directions worth following.

use std::f64::consts::FRAC_1_PI;

use super::super::bands::Bands;
use super::super::energy::{Place, Table};
use super::super::ggx;
use super::super::grating::Ridges;
use super::super::real::Real;
use super::super::thin_film::Film;
use super::{Layers, dot};

/// What the base sends back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Diffuse<'a, F, const N: usize> {
    /// All that does not depend on the light.
    pub(super) scale: [F; N],
    /// Optical depth and `1/c2o`, if anything is absorbed.
    pub(super) tau: Option<([F; N], [F; N])>,
    /// Where what the rough film lets through is, if coupled.
    pub(super) rough: Option<(&'a Table<F>, Place<F, N>)>,
    /// No film at all.
    pub(super) matt: bool,
}

/// A point seen from one direction: everything is ready but for the light.
#[derive(Debug)]
pub struct View<'a, F, B, const N: usize> {
    pub(super) bands: &'a B,
    pub(super) layers: &'a Layers<F>,
    pub(super) film: Film<F>,
    pub(super) alpha: F,
    pub(super) wo: [F; 3],
    /// Reflectance of the smooth film, if it is one.
    pub(super) mirror: Option<[F; N]>,
    pub(super) specular: bool,
    pub(super) diffuse: Option<Diffuse<'a, F, N>>,
    /// Probability that the film is sampled.
    pub(super) chance: F,
}

/// A direction that light may come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<F, const N: usize> {
    /// Where the light comes from: unit, above the surface unless the [`Base`](super::Base) wraps.
    pub wi: [F; 3],
    /// BRDF without the cosine, 1/sr. For a mirror the factor of its delta function over the cosine: in both cases
    /// `f |wi.z|/pdf` is what a path is multiplied by.
    pub f: [F; N],
    /// Density, 1/sr; for a mirror the probability of this lobe.
    pub pdf: F,
    /// Whether it is a mirror's: no other way of sampling finds this direction.
    pub delta: bool,
}

impl<F: Real, B: Bands<F, N>, const N: usize> View<'_, F, B, N> {
    /// BRDF without the cosine, 1/sr, and the density of [`View::sample`]; both without a mirror's part. 0 below the
    /// horizon, but for a [`Base`](super::Base) that wraps: there, too, light is `f |wi.z|`. Never negative; no NaN for
    /// unit vectors.
    #[inline(always)]
    pub fn eval_pdf(&self, wi: [F; 3]) -> ([F; N], F) {
        let (mut f, mut pdf) = ([F::ZERO; N], F::ZERO);
        let (nl, nv) = (wi[2], self.wo[2]);
        if !(nv > F::ZERO && (nl > F::ZERO || self.wraps())) {
            return (f, pdf);
        }
        if self.specular && self.mirror.is_none() && nl > F::ZERO {
            (f, pdf) = match &self.layers.ridges {
                None => self.lobe(wi),
                Some(ridges) => self.orders(ridges, wi),
            };
            pdf = pdf * self.chance;
        }
        if let Some(diffuse) = &self.diffuse {
            let base = self.base(diffuse, nl);
            for i in 0..N {
                f[i] += base[i];
            }
            let quarter = F::from_f64(0.25 * FRAC_1_PI);
            let density = match self.wraps() {
                true if self.layers.constants.base.lets_through() => quarter,
                true => (F::ONE + nl) * quarter,
                false => nl * F::from_f64(FRAC_1_PI),
            };
            pdf += (F::ONE - self.chance) * density;
        }
        (f, pdf)
    }

    /// Part of the film, without ridges, and its density.
    #[inline(always)]
    fn lobe(&self, wi: [F; 3]) -> ([F; N], F) {
        // With less f32 would overflow, and have no half vector.
        let grazing = F::from_f64(1e-7);
        let (nl, nv) = (wi[2].max(grazing), self.wo[2].max(grazing));
        let sum = [wi[0] + self.wo[0], wi[1] + self.wo[1], nl + nv];
        let over = F::ONE / dot(sum, sum).safe_sqrt();
        let half = sum.map(|s| s * over);
        let density = ggx::density_at(self.alpha, half);
        let lobe = density * ggx::visibility(self.alpha, nl, nv);
        let r = self.layers.reflectance(self.bands, &self.film, dot(self.wo, half));
        // Visible normals: G1 D v.h/nv, over 4 v.h for the reflected direction.
        let pdf = density * F::from_f64(0.25) * ggx::masking(self.alpha, nv) / nv;
        (r.map(|r| lobe * r), pdf)
    }

    /// Part of the film with ridges, and its density: the mean over wavelengths.
    #[inline(never)]
    fn orders(&self, ridges: &Ridges<F>, wi: [F; 3]) -> ([F; N], F) {
        let grazing = F::from_f64(1e-7);
        let raised = |w: [F; 3]| [w[0], w[1], w[2].max(grazing)];
        let (wi, wo) = (raised(wi), raised(self.wo));
        let sum: [F; 3] = std::array::from_fn(|k| wi[k] + wo[k]);
        let facing = dot(wo, sum) / dot(sum, sum).safe_sqrt();
        let (mut density, mut count) = (F::ZERO, F::ZERO);
        let f = self.bands.each(|l| {
            let (lobe, part) = ridges.lobe(l, self.alpha, wi, wo);
            (density, count) = (density + part, count + F::ONE);
            let film = self.layers.dispersion_nm2.map_or(self.film, |b| self.film.dispersed(b, l));
            lobe * film.power(facing, l).reflected
        });
        (f.map(|f| f.max(F::ZERO)), density / count.max(F::ONE))
    }

    /// A direction by the ridges: a wavelength first, then an order and a microfacet.
    #[inline(never)]
    fn sample_orders(&self, ridges: &Ridges<F>, random: [F; 3]) -> Option<[F; 3]> {
        let count = (0..).take_while(|i| self.bands.node_nm(*i).is_some()).count();
        let place = (random[0] / self.chance).saturate() * F::from_f64(count as f64);
        let number = place.whole().min(count.saturating_sub(1));
        let rest = place - F::from_f64(number as f64);
        ridges.sample(self.bands.node_nm(number)?, self.alpha, self.wo, [rest, random[1], random[2]])
    }

    /// Whether light from below the horizon counts.
    #[inline(always)]
    fn wraps(&self) -> bool {
        self.layers.constants.base.wraps() && self.diffuse.as_ref().is_some_and(|d| !d.matt)
    }

    /// BRDF without the cosine, 1/sr; a mirror's part is not in it.
    #[inline(always)]
    pub fn eval(&self, wi: [F; 3]) -> [F; N] {
        self.eval_pdf(wi).0
    }

    /// Density of [`View::sample`], 1/sr; a mirror's part is not in it.
    #[inline(always)]
    pub fn pdf(&self, wi: [F; 3]) -> F {
        self.eval_pdf(wi).1
    }

    /// A direction by three uniform numbers in [0, 1); `None` where the light ends.
    #[inline(always)]
    pub fn sample(&self, random: [F; 3]) -> Option<Sample<F, N>> {
        let wo = self.wo;
        let wi = if random[0] < self.chance {
            if let Some(r) = self.mirror {
                let wi = [-wo[0], -wo[1], wo[2]];
                let over = F::ONE / wo[2];
                return Some(Sample { wi, f: r.map(|r| r * over), pdf: self.chance, delta: true });
            }
            if let Some(ridges) = &self.layers.ridges {
                self.sample_orders(ridges, random)?
            } else {
                let half = ggx::sample_visible(self.alpha, wo, [random[1], random[2]]);
                let twice = dot(wo, half) * F::from_f64(2.0);
                std::array::from_fn(|i| twice * half[i] - wo[i])
            }
        } else {
            self.diffuse.as_ref()?;
            let random = [random[1], random[2]];
            match self.wraps() {
                true if self.layers.constants.base.lets_through() => even_sphere(random),
                true => wrapped_sphere(random),
                false => cosine_hemisphere(random),
            }
        };
        let (f, pdf) = self.eval_pdf(wi);
        (pdf > F::ZERO && wi[2] != F::ZERO).then_some(Sample { wi, f, pdf, delta: false })
    }

    /// Part of the base.
    #[inline(always)]
    fn base(&self, diffuse: &Diffuse<'_, F, N>, nl: F) -> [F; N] {
        let f = diffuse.scale;
        if diffuse.matt {
            return f;
        }
        let base = &self.layers.constants.base;
        if !base.wraps() {
            return self.enter(diffuse, f, nl);
        }
        // Wrapped forms are of light times cosine; the cosine is divided out here, and comes back with the light.
        let over = F::ONE / nl.abs().max(F::from_f64(1e-7));
        let [near, far] = base.sides(nl).map(|weight| self.bands.upsample(weight));
        let weighed = |weight: [F; N]| std::array::from_fn(|i| f[i] * weight[i].max(F::ZERO) * over);
        let half = F::from_f64(0.5);
        let mut sum = self.enter(diffuse, weighed(near), (F::ONE + nl) * half);
        if base.lets_through() {
            let through = self.enter(diffuse, weighed(far), (F::ONE - nl) * half);
            (0..N).for_each(|i| sum[i] += through[i]);
        }
        sum
    }

    /// What is left of light on its way through film and layer, in at a cosine and out to the eye.
    #[inline(always)]
    fn enter(&self, diffuse: &Diffuse<'_, F, N>, mut f: [F; N], cosine: F) -> [F; N] {
        let through = match &diffuse.rough {
            Some((table, place)) => table.transmittance(place, cosine),
            None => self.layers.transmittance(self.bands, &self.film, cosine),
        };
        for i in 0..N {
            f[i] = f[i] * through[i];
        }
        if let Some((tau, out)) = &diffuse.tau {
            let way = self.layers.way(self.bands, cosine);
            for i in 0..N {
                f[i] = f[i] * (tau[i] * (way[i] + out[i])).decay();
            }
        }
        f
    }
}

/// A direction with density `(1 + z)/(4 pi)`: `(1 + z)^2/4` is even in [0, 1).
#[inline(always)]
fn wrapped_sphere<F: Real>(random: [F; 2]) -> [F; 3] {
    let root = random[0].safe_sqrt();
    at_height(root + root - F::ONE, random[1])
}

/// A direction with density `1/(4 pi)`: heights are even (Archimedes).
#[inline(always)]
fn even_sphere<F: Real>(random: [F; 2]) -> [F; 3] {
    at_height(random[0] + random[0] - F::ONE, random[1])
}

/// The point of the unit sphere at a height, so many turns around.
#[inline(always)]
fn at_height<F: Real>(z: F, turns: F) -> [F; 3] {
    let radius = ((F::ONE - z) * (F::ONE + z)).safe_sqrt();
    let (sin, cos) = (turns - F::from_f64(0.5)).sin_cos_half_turns();
    let (sin, cos) = (sin * cos * F::from_f64(2.0), (cos - sin) * (cos + sin));
    [radius * cos, radius * sin, z]
}

/// A direction with density `cos/pi`: a point of the disc, lifted (Malley's method).
#[inline(always)]
fn cosine_hemisphere<F: Real>(random: [F; 2]) -> [F; 3] {
    let radius = random[0].safe_sqrt();
    let (sin, cos) = (random[1] - F::from_f64(0.5)).sin_cos_half_turns();
    let (sin, cos) = (sin * cos * F::from_f64(2.0), (cos - sin) * (cos + sin));
    [radius * cos, radius * sin, (F::ONE - random[0]).safe_sqrt()]
}
