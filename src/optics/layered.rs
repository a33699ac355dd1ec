//! The whole BRDF of the skin: a film over an absorbing layer over a diffuse base.
//!
//! ```text
//! f = D(h) V(nl, nv) R(wi.h) + (n0/n2)^2 T(nl) T(nv) exp(-tau (1/c2i + 1/c2o)) kd/(pi (1 - kd rho(tau)))
//! ```
//!
//! with GGX's D and height-correlated V ([`ggx`]), R and T of the film in each band ([`Bands`]), the cosines c2 in the
//! layer ([`super::absorption`]) and the internal reflection rho ([`super::energy`]). The factors `(n0/n2)^2` (radiance is
//! thinned in a denser medium) and `1/(1 - kd rho)` (light goes to and fro below the interface) are missing in the thesis
//! (4.20, 4.21), and T is taken at both directions (4.4.2 at one).
//!
//! Three steps: [`Layers`] of a material, with its tables; a [`View`] of one point from one direction, with all that does
//! not depend on the light; then as many lights and samples as one likes. Directions are unit vectors away from the
//! surface, in the frame of the shading normal, z along it.

mod view;

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use self::view::Diffuse;
pub use self::view::{Sample, View};
use super::absorption::cosine_in_layer;
use super::bands::Bands;
use super::base_layer::Base;
use super::energy::Table;
use super::ggx;
use super::grating::{Grating, Ridges};
use super::real::Real;
use super::thin_film::{Film, FilmError, MAX_DISPERSION_NM2};

/// Roughness below which the film is a mirror: the lobe would be narrower than f32 can tell.
pub const LEAST_ROUGHNESS: f64 = 0.01;
/// Optical depth of the layer from which the base is not seen.
pub const OPAQUE: f64 = 87.0;
/// Least probability of either lobe where both are there.
const LEAST_CHANCE: f64 = 0.05;

/// What is the same over a whole surface. Every index is that of a clear medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Refractive indices: outside, film, layer below the film.
    pub indices: [f32; 3],
    /// Absorption coefficient times thickness of the layer, along the normal, for red, green, blue.
    pub absorption: [f32; 3],
    /// What the albedo of the base is.
    pub albedo: Albedo,
    /// How the light that is not reflected is shared out.
    pub energy: Energy,
    /// What is below the layers.
    pub base: Base,
    /// Cauchy coefficients of film and layer, nm^2; indices are those at 589.3 nm. See [`Film::dispersed`].
    pub dispersion_nm2: [f32; 2],
    /// Ridges of the surface.
    pub grating: Option<Grating>,
}

impl Default for Constants {
    /// The thesis's: keratin of 1.55 on 2.0 in air, nothing absorbed.
    fn default() -> Self {
        Self {
            indices: [1.0, 1.55, 2.0],
            absorption: [0.0; 3],
            albedo: Albedo::Apparent,
            energy: Energy::Flat,
            base: Base::Lambert,
            dispersion_nm2: [0.0; 2],
            grating: None,
        }
    }
}

/// What the albedo of the base means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Albedo {
    /// What is seen from outside without absorption: what textures hold.
    #[default]
    Apparent,
    /// Of the base itself, below the interface.
    Intrinsic,
}

/// How the light that is not reflected is shared out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Energy {
    /// Transmittance at the angles to the normal: fast, right for smooth surfaces.
    #[default]
    Flat,
    /// What the rough surface does not reflect, by a table: conserves energy at any roughness.
    Coupled,
}

/// Which parts of the BRDF there are: the stages of the thesis's comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parts {
    /// All layers.
    #[default]
    All,
    /// The film alone: what it reflects.
    Specular,
    /// What comes from the base through layer and film, without what the film reflects.
    Diffuse,
    /// The albedo on a matt surface, `albedo/pi`, without any layer.
    Lambert,
}

/// A material made ready: its indices, and tables that are made when first needed.
#[derive(Debug)]
pub struct Layers<F> {
    constants: Constants,
    film: Film<F>,
    double: Film<f64>,
    /// `(n0/n2)^2`.
    eta: F,
    /// Cauchy coefficients, if one is not 0.
    dispersion_nm2: Option<[F; 2]>,
    /// Ridges, if they have a height.
    ridges: Option<Ridges<F>>,
    /// Of wavelengths and of colours.
    tables: [OnceLock<Table<F>>; 2],
}

impl<F: Real> Layers<F> {
    /// Make a material ready; refused if an index, a coefficient or a size is out of range.
    pub fn new(constants: &Constants) -> Result<Self, FilmError> {
        for value in constants.dispersion_nm2.map(f64::from) {
            if !(-MAX_DISPERSION_NM2..=MAX_DISPERSION_NM2).contains(&value) {
                return Err(FilmError::Dispersion { value });
            }
        }
        let [n0, n1, n2] = constants.indices.map(f64::from);
        let f = F::from_f64;
        Ok(Self {
            constants: *constants,
            film: Film::new(f(n0), f(n1), f(n2), F::ZERO)?,
            double: Film::new(n0, n1, n2, 0.0)?,
            eta: f((n0 / n2) * (n0 / n2)),
            dispersion_nm2: (constants.dispersion_nm2 != [0.0; 2])
                .then(|| constants.dispersion_nm2.map(|b| f(f64::from(b)))),
            ridges: constants.grating.as_ref().map(Ridges::new).transpose()?.flatten(),
            tables: [OnceLock::new(), OnceLock::new()],
        })
    }

    /// What it was made of.
    pub fn constants(&self) -> &Constants {
        &self.constants
    }

    /// Make the tables for these bands now rather than at first use: some milliseconds, a tenth of a second for
    /// [`Energy::Coupled`].
    pub fn prepare<B: Bands<F, N>, const N: usize>(&self) {
        self.table(B::RGB);
    }

    #[inline(always)]
    fn table(&self, rgb: bool) -> &Table<F> {
        let rough = self.constants.energy == Energy::Coupled;
        let dispersion = self.dispersion_nm2.map(|b| b.map(F::to_f64));
        self.tables[usize::from(rgb)].get_or_init(|| Table::new(&self.double, dispersion, rgb, rough))
    }

    /// What becomes of diffuse light below a film of this thickness, nm, and roughness: what shaders keep in tables.
    pub fn below<B: Bands<F, N>, const N: usize>(
        &self,
        bands: &B,
        thickness_nm: F,
        roughness: F,
        absorption: [F; N],
    ) -> Below<F, N> {
        let (table, tau) = (self.table(B::RGB), absorption.map(|t| t.max(F::ZERO)));
        let film = self.film.with_thickness(thickness_nm);
        let place = table.place(roughness, self.fringes(bands, &film), bands.wavelengths_nm());
        let (leaving, eta) = (table.leaving(&place), self.eta(bands));
        let mut entering = table.crossing(&leaving, tau);
        (0..N).for_each(|i| entering[i] = entering[i] / eta[i]);
        Below { clear: leaving.clear, lost: table.lost(&leaving, tau), entering }
    }

    /// What the film reflects, in each band.
    #[inline(always)]
    fn reflectance<B: Bands<F, N>, const N: usize>(&self, bands: &B, film: &Film<F>, cosine: F) -> [F; N] {
        match self.dispersion_nm2 {
            None => bands.reflectance(film, cosine),
            Some(b) => dispersed::<F, B, N, true>(bands, film, b, cosine),
        }
    }

    /// What it does not reflect.
    #[inline(always)]
    fn transmittance<B: Bands<F, N>, const N: usize>(&self, bands: &B, film: &Film<F>, cosine: F) -> [F; N] {
        match self.dispersion_nm2 {
            None => bands.transmittance(film, cosine),
            Some(b) => dispersed::<F, B, N, false>(bands, film, b, cosine),
        }
    }

    /// Thickness in fringes.
    #[inline(always)]
    fn fringes<B: Bands<F, N>, const N: usize>(&self, bands: &B, film: &Film<F>) -> [F; N] {
        match self.dispersion_nm2 {
            // The tables of colours are by the index as given.
            Some(b) if !B::RGB => bands.wavelengths_nm().map(|l| {
                let path = film.dispersed(b, l).indices()[1] * film.thickness_nm();
                (path + path) / l
            }),
            _ => bands.fringes(film),
        }
    }

    /// `(n0/n2)^2`.
    #[inline(always)]
    fn eta<B: Bands<F, N>, const N: usize>(&self, bands: &B) -> [F; N] {
        self.dispersion_nm2.map_or([self.eta; N], |b| {
            bands.wavelengths_nm().map(|l| {
                let [n0, _, n2] = self.film.dispersed(b, l).indices();
                (n0 / n2).squared()
            })
        })
    }

    /// `1/c2` of the layer: how much longer than its thickness the way through it is.
    #[inline(always)]
    fn way<B: Bands<F, N>, const N: usize>(&self, bands: &B, cosine: F) -> [F; N] {
        let way = |film: &Film<F>| {
            let [n0, _, n2] = film.indices();
            F::ONE / cosine_in_layer(n0, n2, cosine)
        };
        match self.dispersion_nm2 {
            None => [way(&self.film); N],
            Some(b) => bands.wavelengths_nm().map(|l| way(&self.film.dispersed(b, l))),
        }
    }

    /// Look at a point from `wo`.
    #[inline(always)]
    pub fn view<'a, B: Bands<F, N>, const N: usize>(
        &'a self,
        bands: &'a B,
        point: &Point<F, N>,
        wo: [F; 3],
        parts: Parts,
    ) -> View<'a, F, B, N> {
        let film = self.film.with_thickness(point.thickness_nm);
        let nv = wo[2].saturate();
        // A NaN is 0; ridges are never mirrors.
        let smooth = point.roughness.max(F::ZERO) < F::from_f64(LEAST_ROUGHNESS);
        let mirror = smooth && self.ridges.is_none();
        let roughness = match (smooth, mirror) {
            (_, true) => F::ZERO,
            (true, false) => F::from_f64(LEAST_ROUGHNESS),
            (false, false) => point.roughness,
        };
        let alpha = ggx::alpha(roughness);
        let [n0, n1, n2] = film.indices();
        let interface =
            self.dispersion_nm2.is_some() || n0 != n2 || (n1 != n0 && film.thickness_nm() > F::ZERO);
        let mut view = View {
            bands,
            layers: self,
            film,
            alpha,
            wo,
            mirror: None,
            specular: interface && matches!(parts, Parts::All | Parts::Specular) && wo[2] > F::ZERO,
            diffuse: None,
            chance: F::ZERO,
        };
        let albedo = point.albedo.map(F::saturate);
        let seen = albedo.iter().any(|a| *a > F::ZERO) && wo[2] > F::ZERO;
        let mean = |values: [F; N]| {
            values.into_iter().fold(F::ZERO, |sum, v| sum + v) * F::from_f64(1.0 / N.max(1) as f64)
        };
        if parts == Parts::Lambert && seen {
            let scale = albedo.map(|a| a * F::from_f64(FRAC_1_PI));
            view.diffuse = Some(Diffuse { scale, tau: None, rough: None, matt: true });
            return view;
        }
        if mirror && view.specular {
            view.mirror = Some(self.reflectance(bands, &film, nv));
        }
        view.chance = if view.specular { F::ONE } else { F::ZERO };
        let tau = point.absorption.map(|t| t.max(F::ZERO));
        let opaque = F::from_f64(OPAQUE);
        if matches!(parts, Parts::All | Parts::Diffuse) && seen && tau.iter().any(|t| *t < opaque) {
            let absorbing = tau.iter().any(|t| *t > F::ZERO);
            let table = self.table(B::RGB);
            // Unlike the direct formula the table is for films without number: at thickness 0 all bands are one.
            let place = table.place(roughness, self.fringes(bands, &film), bands.wavelengths_nm());
            let rough = (self.constants.energy == Energy::Coupled && !mirror).then_some((table, place));
            let through = match &rough {
                Some((table, place)) => table.transmittance(place, nv),
                None => self.transmittance(bands, &film, nv),
            };
            let leaving = table.leaving(&place);
            let lost = if absorbing { table.lost(&leaving, tau) } else { leaving.clear };
            let (eta, out) = (self.eta(bands), self.way(bands, nv));
            let mut scale = [F::ZERO; N];
            for i in 0..N {
                // kd/(1 - kd rho), with kd = a/((1 - rho0) + a rho0) multiplied out, all in 1 - rho.
                let (a, clear) = (albedo[i], leaving.clear[i]);
                let below = match self.constants.albedo {
                    Albedo::Apparent => clear + a * (lost[i] - clear),
                    Albedo::Intrinsic => (F::ONE - a) + a * lost[i],
                };
                let factor = eta[i] * F::from_f64(FRAC_1_PI) * a * through[i];
                scale[i] = if below > F::ZERO { factor / below } else { F::ZERO };
            }
            if view.specular {
                // The share of energy, roughly: light comes in along the normal.
                let mut share = leaving.clear;
                (0..N).for_each(|i| share[i] = share[i] * scale[i]);
                let mut base = mean(share) * F::from_f64(PI) / self.eta;
                if absorbing {
                    // Of the mean depth: any share will do.
                    base = base * (mean(tau) * (mean(out) + F::ONE)).decay();
                }
                let top = mean(through.map(|t| F::ONE - t));
                let least = F::from_f64(LEAST_CHANCE);
                let share = top / (top + base).max(F::from_f64(1e-30));
                view.chance = share.max(least).min(F::ONE - least);
            }
            let tau = absorbing.then_some((tau, out));
            view.diffuse = Some(Diffuse { scale, tau, rough, matt: false });
        }
        view
    }
}

/// What a dispersive film reflects or transmits, in each band.
#[inline(never)]
fn dispersed<F: Real, B: Bands<F, N>, const N: usize, const REFLECTED: bool>(
    bands: &B,
    film: &Film<F>,
    dispersion_nm2: [F; 2],
    cosine: F,
) -> [F; N] {
    let at = |l: F| {
        let power = film.dispersed(dispersion_nm2, l).power(cosine, l);
        if REFLECTED { power.reflected } else { power.transmitted }
    };
    bands.each(at).map(F::saturate)
}

/// What becomes of diffuse light below the film, in each band. See [`super::energy`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Below<F, const N: usize> {
    /// `1 - rho(0)`: what does not return to the base of light that it sends up, without absorption.
    pub clear: [F; N],
    /// `1 - rho(tau)`: the same with it, where what is absorbed is lost, too.
    pub lost: [F; N],
    /// Part of even light from outside that reaches the base: `2 int_0^1 T(u) exp(-tau/c2(u)) u du`.
    pub entering: [F; N],
}

/// What a point of the surface has of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<F, const N: usize> {
    /// Thickness of the film, nm, limited to 0 to 1e9; NaN is 0.
    pub thickness_nm: F,
    /// Perceptual roughness, limited to [0, 1]; below [`LEAST_ROUGHNESS`] a mirror.
    pub roughness: F,
    /// Albedo of the base in each band, limited to [0, 1]; see [`Albedo`].
    pub albedo: [F; N],
    /// Optical depth of the layer along the normal in each band; negative is 0.
    pub absorption: [F; N],
}

/// [`View::eval`] of a view that is used once.
pub fn eval<F: Real, B: Bands<F, N>, const N: usize>(
    layers: &Layers<F>,
    bands: &B,
    point: &Point<F, N>,
    wo: [F; 3],
    wi: [F; 3],
) -> [F; N] {
    layers.view(bands, point, wo, Parts::All).eval(wi)
}

/// [`View::pdf`] of a view that is used once.
pub fn pdf<F: Real, B: Bands<F, N>, const N: usize>(
    layers: &Layers<F>,
    bands: &B,
    point: &Point<F, N>,
    wo: [F; 3],
    wi: [F; 3],
) -> F {
    layers.view(bands, point, wo, Parts::All).pdf(wi)
}

/// [`View::sample`] of a view that is used once.
pub fn sample<F: Real, B: Bands<F, N>, const N: usize>(
    layers: &Layers<F>,
    bands: &B,
    point: &Point<F, N>,
    wo: [F; 3],
    random: [F; 3],
) -> Option<Sample<F, N>> {
    layers.view(bands, point, wo, Parts::All).sample(random)
}

#[inline(always)]
pub(super) fn dot<F: Real>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;
