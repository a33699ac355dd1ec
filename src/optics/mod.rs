//! OPTICS: light on snake skin, layer by layer. Imports only the ground floor.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`Real`] | f32 for shading or f64 for truth |
//! | [`fresnel`] | a plain interface: s, p, unpolarised, total reflection |
//! | [`Film`] | a thin film at one wavelength, exact |
//! | [`FilmColor`], [`Method`] | the colour of a film under D65: the exact series, and what it is compared with |
//! | [`Transform`] | the table behind the series |
//! | [`cie`] | illuminant, observer, sRGB, CIEDE2000 |
//! | [`absorption`] | the pigment layer below the film: Beer-Lambert |
//! | [`ggx`] | microfacets: GGX, height-correlated Smith masking, visible normals |
//! | [`grating`] | ridges finer than light resolves: the orders of a diffraction grating |
//! | [`Bands`], [`Spectral`] | what a BRDF is computed in: red, green, blue, or N wavelengths |
//! | [`Base`] | the base below: Lambert, and wrapped forms of the same energy |
//! | [`spectrum`], [`Wavelengths`] | spectra of RGB colours; wavelengths for a path |
//! | [`energy`] | what a rough film reflects and keeps inside: exact, and the tables of shading |
//! | [`SkinOptics`] | indices, absorption and albedo as texts give them |
//! | [`layered`], [`Layers`], [`View`] | the BRDF of all layers: evaluate, sample, density |
//!
//! Indices n0 (outside), n1 (film), n2 (below) are real; angles are given by their cosine in n0; lengths in nanometres.
//!
//! # Errata of the thesis
//!
//! The shading model is that of the thesis, chapters 3 and 4, with these corrections. Sizes are measured.
//!
//! | Equation | As printed | Right | Size |
//! | --- | --- | --- | --- |
//! | 3.4 | `Kd f_L + Ks f_CT` with F inside f_CT | then Ks = 1, and Kd is what is transmitted | Ks = F squares F |
//! | 3.8, 3.9 | Schlick, angle to the surface normal | exact Fresnel, angle to the half vector | up to 0.06 |
//! | 3.10 to 3.12 | called G, within 4 nl nv | is `V = G2/(4 nl nv)` already | factor 1/(4 nl nv) |
//! | 3.10 | V by linear interpolation | exact: see [`ggx::visibility`] | up to 26 % |
//! | 4.5 | called transmittance; ratio r01 r12 | an amplitude; the ratio is `r12 r10 = -r01 r12` | with 4.6 |
//! | 4.6, 4.7 | phases of 0 or pi besides signed r | `q = -r01 r12` has them already | R up to 1.0 off (n0 = n2) |
//! | 4.8 to 4.11 | right once q is right; without the factor `n2 cos2/(n0 cos0)` T is halved | with it, for s and p apart | T 0.444 for 0.889 |
//! | 4.12, 4.13 | R = 1 - T | right, but small R must be computed directly in f32 | 6.4194e-5 for 6.4166e-5 |
//! | 4.15 | `sin1 = sin0 n1/n0` | `sin1 = sin0 n0/n1` | R 0.16 RMS, and no value beyond 40 degrees |
//! | 4.16 to 4.19 | angle in the film, thickness of the film | angle in and thickness of the absorbing layer | 0.485 or 0.301 for 0.514 |
//! | 4.20, 4.21 | `Tin Tout e^(..) kd/pi` | times `(n0/n2)^2/(1 - kd rho)` | 0.26 to 1.17 |
//! | 4.4.2 | `I fr + (1 - I) fabs` | T at both directions | not reciprocal |

pub mod absorption;
pub mod bands;
pub mod base_layer;
pub mod cie;
pub mod energy;
pub mod film_color;
pub mod fresnel;
pub mod ggx;
pub mod grating;
pub mod layered;
mod quadrature;
mod real;
pub mod skin;
pub mod spectrum;
pub mod thin_film;
pub mod transform;

#[cfg(test)]
mod tests;

pub use bands::{Bands, Spectral};
pub use base_layer::Base;
pub use film_color::{FilmColor, Method};
pub use fresnel::Polarised;
pub use grating::Grating;
pub use layered::{Layers, Parts, Point, Sample, View};
pub use real::Real;
pub use skin::SkinOptics;
pub use spectrum::Wavelengths;
pub use thin_film::{Film, FilmError, Power};
pub use transform::Transform;
