//! Reciprocity, energy, sampling, and anything at all.

use super::*;
use crate::base::hash;
use crate::optics::bands::Spectral;
use crate::optics::base_layer::Tint;
use crate::optics::film_color::{FilmColor, Method};
use crate::optics::{energy, quadrature::gauss_legendre};

/// A uniform number in [0, 1) for each counter.
fn unit(counter: u32) -> f64 {
    f64::from(hash::pcg(hash::pcg(counter) ^ 0x9e37_79b9) >> 8) / f64::from(1 << 24)
}

fn direction(z: f64, phi: f64) -> [f64; 3] {
    let r = (1.0 - z * z).sqrt();
    [r * libm::cos(phi), r * libm::sin(phi), z]
}

fn materials() -> Vec<Constants> {
    let mut all = Vec::new();
    for indices in [[1.0, 1.55, 2.0], [1.0, 1.33, 1.0], [1.5, 1.0, 1.4]] {
        for energy in [Energy::Flat, Energy::Coupled] {
            for albedo in [Albedo::Apparent, Albedo::Intrinsic] {
                all.push(Constants { indices, energy, albedo, ..Constants::default() });
            }
        }
    }
    let grating = Some(Grating { period_nm: 800.0, height_nm: 60.0, direction_rad: 1.0 });
    for energy in [Energy::Flat, Energy::Coupled] {
        all.push(Constants { dispersion_nm2: [5890.0, 9000.0], energy, ..Constants::default() });
        all.push(Constants { grating, energy, ..Constants::default() });
    }
    all
}

#[test]
fn directions_may_be_swapped() {
    let bands = Spectral::new([400.0, 500.0, 600.0, 700.0]);
    for constants in materials() {
        let layers = Layers::<f64>::new(&constants).expect("a material");
        for i in 0..200 {
            let u = |k: u32| unit(i * 16 + k);
            let point = Point {
                thickness_nm: 1500.0 * u(0),
                roughness: u(1),
                albedo: [0.1, 0.5, 0.9, 1.0],
                absorption: [0.0, 0.1, 0.6, 3.0],
            };
            let (a, b) = (direction(u(2), 7.0 * u(3)), direction(u(4), 7.0 * u(5)));
            let there = eval(&layers, &bands, &point, a, b);
            let back = eval(&layers, &bands, &point, b, a);
            for (x, y) in there.into_iter().zip(back) {
                assert!((x - y).abs() <= 1e-12 * x.max(1.0), "{constants:?} {point:?}: {x} {y}");
            }
            let sum: f64 = there.iter().sum();
            // The control: another direction gives another value.
            let other = eval(&layers, &bands, &point, a, direction(u(6), 1.0)).iter().sum::<f64>();
            assert!(sum != other);
        }
    }
}

#[test]
fn what_is_evaluated_is_the_exact_furnace() {
    // E_diff and E_spec again, by integrating the BRDF itself over the hemisphere.
    let rows = [
        (Energy::Flat, 0.5, 0.5, 0.6, 0.6),
        (Energy::Flat, 0.7, 1.0, 0.0, 0.3),
        (Energy::Coupled, 0.6, 0.8, 0.0, 0.5),
        (Energy::Coupled, 1.0, 0.3, 0.6, 0.8),
    ];
    for (energy, roughness, kd, tau, cosine) in rows {
        let constants = Constants { energy, albedo: Albedo::Intrinsic, ..Constants::default() };
        let layers = Layers::<f64>::new(&constants).expect("a material");
        let bands = Spectral::new([550.0]);
        let point = Point { thickness_nm: 400.0, roughness, albedo: [kd], absorption: [tau] };
        let film = Film::new(1.0, f64::from(1.55f32), 2.0, 400.0).expect("a film");
        let exact = energy::furnace(&film, 550.0, roughness, kd, tau, cosine);
        let wo = direction(cosine, 0.0);
        let integral = |parts: Parts| {
            let view = layers.view(&bands, &point, wo, parts);
            let phis = 128;
            gauss_legendre(96)
                .iter()
                .map(|(z, w)| {
                    let ring: f64 = (0..phis)
                        .map(|k| view.eval(direction(*z, PI * (f64::from(k) + 0.5) / f64::from(phis)))[0])
                        .sum();
                    w * z * ring * 2.0 * PI / f64::from(phis)
                })
                .sum::<f64>()
        };
        let diffuse = if energy == Energy::Flat { exact.diffuse_flat } else { exact.diffuse_coupled };
        let (specular, base, all) =
            (integral(Parts::Specular), integral(Parts::Diffuse), integral(Parts::All));
        println!("{energy:?} {roughness}: {specular} {}, {base} {diffuse}", exact.specular);
        assert!((specular - exact.specular).abs() < 1e-5, "{specular} {}", exact.specular);
        assert!((base - diffuse).abs() < 2e-4 * diffuse, "{base} {diffuse}");
        assert!((all - specular - base).abs() < 1e-12);
        assert!((integral(Parts::Lambert) - kd).abs() < 1e-12);
    }
}

#[test]
fn apparent_albedo_is_what_the_entered_light_returns() {
    let bands = Spectral::new([550.0]);
    let layers = Layers::<f64>::new(&Constants::default()).expect("a material");
    for a in [0.05, 0.5, 1.0] {
        let point = Point { thickness_nm: 400.0, roughness: 0.0, albedo: [a], absorption: [0.0] };
        // Diffuse light that enters, pi J, returns as a: albedo over both hemispheres.
        let (mut entered, mut returned) = (0.0, 0.0);
        let film = Film::new(1.0, f64::from(1.55f32), 2.0, 400.0).expect("a film");
        for (z, w) in gauss_legendre(24) {
            let view = layers.view(&bands, &point, direction(z, 0.0), Parts::Diffuse);
            entered += 2.0 * w * z * film.power(z, 550.0).transmitted;
            returned += gauss_legendre(24)
                .iter()
                .map(|(y, v)| 2.0 * w * z * 2.0 * PI * v * y * view.eval(direction(*y, 1.0))[0])
                .sum::<f64>();
        }
        assert!((returned / entered - a).abs() < 1e-4, "{a}: {}", returned / entered);
    }
}

#[test]
fn samples_fall_as_their_density_says() {
    let bands = Spectral::new([450.0, 550.0, 650.0, 600.0]);
    let cases = [
        ([1.0, 1.55, 2.0], 0.4, 0.5, 0.9, Parts::All),
        ([1.0, 1.55, 2.0], 0.7, 0.9, 0.2, Parts::All),
        ([1.0, 1.55, 1.33], 0.9, 0.0, 0.5, Parts::All),
        ([1.0, 1.55, 2.0], 0.6, 0.5, 0.4, Parts::Specular),
        ([1.0, 1.55, 2.0], 0.0, 0.5, 0.4, Parts::Diffuse),
        ([1.0, 1.55, 2.0], 0.3, 0.5, 0.4, Parts::Lambert),
    ];
    for (case, (indices, roughness, albedo, cosine, parts)) in (0u32..).zip(cases) {
        let layers = Layers::<f64>::new(&Constants { indices, ..Constants::default() }).expect("a material");
        let point = Point { thickness_nm: 300.0, roughness, albedo: [albedo; 4], absorption: [0.2; 4] };
        let view = layers.view(&bands, &point, direction(cosine, 0.4), parts);
        let (rings, sectors, samples, fine) = (10usize, 16usize, 100_000u32, 24);
        let mut found = vec![0.0; rings * sectors];
        for i in 0..samples {
            let random = [0, 1, 2].map(|k| unit((case * samples + i) * 3 + k));
            if let Some(sample) = view.sample(random) {
                assert!((dot(sample.wi, sample.wi) - 1.0).abs() < 1e-9);
                let ring = ((sample.wi[2] * rings as f64) as usize).min(rings - 1);
                let turn = libm::atan2(sample.wi[1], sample.wi[0]) / (2.0 * PI);
                let sector = ((turn.rem_euclid(1.0) * sectors as f64) as usize).min(sectors - 1);
                found[ring * sectors + sector] += 1.0;
            }
        }
        let cell = |ring: usize, sector: usize| {
            let mut sum = 0.0;
            for i in 0..fine * fine {
                let (a, b) = ((i / fine) as f64 + 0.5, (i % fine) as f64 + 0.5);
                let z = (ring as f64 + a / fine as f64) / rings as f64;
                let phi = 2.0 * PI * (sector as f64 + b / fine as f64) / sectors as f64;
                sum += view.pdf(direction(z, phi));
            }
            sum / (fine * fine) as f64 * 2.0 * PI / (rings * sectors) as f64
        };
        let expected: Vec<f64> = (0..rings * sectors).map(|i| cell(i / sectors, i % sectors)).collect();
        let total: f64 = expected.iter().sum();
        assert!(total < 1.0 + 1e-3, "{case}: {total}");
        let chi = |expected: &dyn Fn(usize) -> f64| {
            let lost = (f64::from(samples) - found.iter().sum::<f64>(), 1.0 - total);
            let cells = (0..found.len()).map(|i| (found[i], expected(i))).chain([lost]);
            let cells: Vec<_> = cells.filter(|(_, p)| p * f64::from(samples) > 5.0).collect();
            let n = cells.len() as f64 - 1.0;
            let chi: f64 = cells
                .iter()
                .map(|(f, p)| (f - p * f64::from(samples)).powi(2) / (p * f64::from(samples)))
                .sum();
            (chi - n) / (2.0 * n).sqrt()
        };
        let sigmas = chi(&|i| expected[i]);
        println!("case {case}: {sigmas:.2} sigma, total {total:.4}");
        assert!(sigmas < 4.5, "{case}: {sigmas}");
        // The control: the wrong way round.
        let wrong = chi(&|i| expected[(i + sectors / 2) % found.len()]);
        assert!(parts == Parts::Lambert || parts == Parts::Diffuse || wrong > 50.0, "{case}: {wrong}");
    }
}

#[test]
fn weights_of_samples_average_to_the_furnace() {
    // One number for every roughness, mirrors too: f cos/pdf averages to E_spec + E_diff.
    for roughness in [0.0, 0.02, 0.1, 0.3, 1.0] {
        for energy in [Energy::Flat, Energy::Coupled] {
            let constants = Constants { energy, albedo: Albedo::Intrinsic, ..Constants::default() };
            let layers = Layers::<f32>::new(&constants).expect("a material");
            let bands = Spectral::new([550.0f32]);
            let point = Point { thickness_nm: 400.0, roughness, albedo: [0.8], absorption: [0.1] };
            let wo = direction(0.7, 2.0).map(|x| x as f32);
            let view = layers.view(&bands, &point, wo, Parts::All);
            let n = 100;
            let mut sum = 0.0;
            for i in 0..n * n * 10 {
                let at = |k: u32| (k as f32 + 0.5) / n as f32;
                let random = [(0.5 + (i / (n * n)) as f32) * 0.1, at(i / n % n), at(i % n)];
                // The first number picks the lobe: from its own sequence.
                let pick = unit(i) as f32;
                if let Some(s) = view.sample([pick, random[1], random[2]]) {
                    sum += f64::from(s.f[0] * s.wi[2] / s.pdf);
                }
            }
            let film = Film::new(1.0, 1.55, 2.0, 400.0).expect("a film");
            let exact = energy::furnace(&film, 550.0, f64::from(roughness), 0.8, f64::from(0.1f32), 0.7);
            let diffuse = if energy == Energy::Flat { exact.diffuse_flat } else { exact.diffuse_coupled };
            let mean = sum / f64::from(n * n * 10);
            assert!(
                (mean - exact.specular - diffuse).abs() < 4e-3,
                "{roughness} {energy:?}: {mean} {exact:?}"
            );
        }
    }
}

#[test]
fn a_wrapped_base_returns_what_lamberts_does() {
    // Without an interface, where T = 1, over the whole sphere: f |cos| integrates to the albedo; by samples, too.
    let bases = [
        Base::HalfLambert { blood: [0.6, 0.0, 0.0], tint: Tint::FromNormal },
        Base::HalfLambert { blood: [0.6, 0.1, 0.0], tint: Tint::FromHorizon },
        Base::Curved { curvature_per_mm: 0.3, thickness_mm: f32::INFINITY },
        Base::Curved { curvature_per_mm: 0.3, thickness_mm: 0.8 },
    ];
    let bands = FilmColor::<f64>::new(Method::Series(3));
    for base in bases {
        let layers = Layers::<f64>::new(&Constants { indices: [1.3; 3], base, ..Constants::default() });
        let layers = layers.expect("a material");
        let albedo = [0.2, 0.5, 0.9];
        let point = Point { thickness_nm: 0.0, roughness: 0.3, albedo, absorption: [0.0; 3] };
        let view = layers.view(&bands, &point, direction(0.6, 0.0), Parts::All);
        let (mut sampled, n) = ([0.0; 3], 200);
        for i in 0..n * n {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
            let s = view.sample([0.5, at(i / n), at(i % n)]).expect("a direction");
            (0..3).for_each(|c| sampled[c] += s.f[c] * s.wi[2].abs() / s.pdf / f64::from(n * n));
        }
        for c in 0..3 {
            assert!((sampled[c] - albedo[c]).abs() < 3e-3 * albedo[c], "{base:?} {sampled:?}");
        }
    }
}

#[test]
fn light_of_the_far_side_enters_there_and_comes_through() {
    let bands = FilmColor::<f64>::new(Method::Series(3));
    let point = Point { thickness_nm: 400.0, roughness: 0.3, albedo: [0.5; 3], absorption: [0.2; 3] };
    let of = |thickness_mm: f32, z: f64| {
        let base = Base::Curved { curvature_per_mm: 0.1, thickness_mm };
        let layers = Layers::<f64>::new(&Constants { base, ..Constants::default() }).expect("a material");
        let f = layers.view(&bands, &point, direction(0.6, 0.0), Parts::Diffuse).eval(direction(z, 1.0));
        f.map(|f| f * z.abs())
    };
    for z in [1.0, 0.8, 0.3] {
        // Of nothing between, the far side is this side.
        let (here, there) = (of(f32::INFINITY, z), of(0.0, -z));
        assert!((0..3).all(|c| (here[c] / there[c] - 1.0).abs() < 1e-12), "{z} {here:?} {there:?}");
        // Of thin flesh it is less, most so in blue, and through a body there is next to nothing.
        let (thin, body) = (of(1.0, -z), of(f32::INFINITY, -z));
        assert!(here[0] > thin[0] && thin[0] > thin[1] && thin[1] > thin[2], "{z} {here:?} {thin:?}");
        assert!(z < 0.5 || thin[0] > 20.0 * body[0], "{z} {thin:?} {body:?}");
    }
}

#[test]
fn a_dispersive_skin_is_one_of_other_indices_at_each_wavelength() {
    let (wavelengths, b) = ([380.0, 470.0, 589.3, 720.0], [5890.0f32, 9000.0]);
    let bands = Spectral::new(wavelengths);
    for (energy, limit) in [(Energy::Flat, 1e-4), (Energy::Coupled, 1e-3)] {
        let constants = Constants { dispersion_nm2: b, energy, ..Constants::default() };
        let layers = Layers::<f64>::new(&constants).expect("a material");
        let still = Layers::<f64>::new(&Constants { energy, ..Constants::default() }).expect("a material");
        let (mut worst, mut control) = (0.0f64, 0.0f64);
        for i in 0..100 {
            let u = |k: u32| unit(i * 16 + k);
            let point = Point {
                thickness_nm: 600.0 * u(0),
                roughness: 0.1 + 0.7 * u(1),
                albedo: [0.6; 4],
                absorption: [0.2 * u(6); 4],
            };
            let (wo, wi) = (direction(0.2 + 0.8 * u(2), 7.0 * u(3)), direction(0.2 + 0.8 * u(4), 7.0 * u(5)));
            let found = eval(&layers, &bands, &point, wo, wi);
            let plain = eval(&still, &bands, &point, wo, wi);
            for (k, l) in wavelengths.into_iter().enumerate() {
                // Cauchy's formula again.
                let more = 1.0 / (l * l) - 1.0 / (589.3 * 589.3);
                let [n0, n1, n2] = constants.indices;
                let at = |n: f32, b: f32| (f64::from(n) + f64::from(b) * more) as f32;
                let indices = [n0, at(n1, b[0]), at(n2, b[1])];
                let one = Layers::<f64>::new(&Constants { indices, energy, ..Constants::default() });
                let one_point = Point {
                    thickness_nm: point.thickness_nm,
                    roughness: point.roughness,
                    albedo: [0.6],
                    absorption: [point.absorption[0]],
                };
                let expected = if energy == Energy::Flat {
                    eval(&one.expect("a material"), &Spectral::new([l]), &one_point, wo, wi)[0]
                } else if k == 2 {
                    // Where indices are those given.
                    plain[k]
                } else {
                    continue;
                };
                worst = worst.max((found[k] / expected - 1.0).abs());
                control = control.max((found[k] / plain[k] - 1.0).abs());
            }
        }
        println!("{energy:?}: {worst:.1e}, without dispersion {control:.1e}");
        assert!(worst < limit && (energy == Energy::Coupled || control > 0.05), "{energy:?}: {worst}");
    }
}

#[test]
fn colours_of_dispersive_films_are_those_of_their_spectra() {
    let bands = FilmColor::<f64>::new(Method::Series(3));
    let b = [5890.0, 9000.0];
    let layers =
        Layers::<f64>::new(&Constants { dispersion_nm2: b, ..Constants::default() }).expect("a material");
    let b = b.map(f64::from);
    let (mut worst, mut control) = (0.0f64, 0.0f64);
    for i in 0..60 {
        let (d, cosine) = (600.0 * unit(i * 2), 0.1 + 0.9 * unit(i * 2 + 1));
        let point = Point { thickness_nm: d, roughness: 0.0, albedo: [0.0; 3], absorption: [0.0; 3] };
        let view = layers.view(&bands, &point, direction(cosine, 0.0), Parts::Specular);
        let found = view.sample([0.5; 3]).expect("a mirror").f.map(|f| f * cosine);
        let film = Film::new(1.0, f64::from(1.55f32), 2.0, d).expect("a film");
        let exact = crate::optics::cie::integrate(|l| film.dispersed(b, l).power(cosine, l).reflected);
        let plain = crate::optics::cie::integrate(|l| film.power(cosine, l).reflected);
        for c in 0..3 {
            worst = worst.max((found[c] - exact[c].saturate()).abs());
            control = control.max((plain[c] - exact[c]).abs());
        }
    }
    println!("{worst:.1e}, without dispersion {control:.1e}");
    assert!(worst < 2e-3 && control > 1e-2);
}

#[test]
fn no_dispersion_is_none_to_the_bit_and_odd_ones_are_refused() {
    let film = Film::new(1.0f32, 1.55, 2.0, 400.0).expect("a film");
    for l in [f32::NAN, 0.0, 380.0, 550.0, 1e9] {
        assert_eq!(film.dispersed([0.0, -0.0], l), film);
    }
    let new = |b| Layers::<f32>::new(&Constants { dispersion_nm2: [0.0, b], ..Constants::default() });
    assert!(new(-0.0).expect("a material").dispersion_nm2.is_none());
    for b in [f32::NAN, f32::INFINITY, -2e5] {
        assert!(matches!(new(b), Err(FilmError::Dispersion { .. })));
    }
}

#[test]
fn parts_that_are_not_there_are_not_sampled() {
    let bands = Spectral::new([550.0f32; 4]);
    let up = [0.6, 0.0, 0.8];
    let view = |indices, albedo: f32, tau: f32, thickness_nm, parts| {
        let layers = Layers::<f32>::new(&Constants { indices, ..Constants::default() }).expect("a material");
        let point = Point { thickness_nm, roughness: 0.3, albedo: [albedo; 4], absorption: [tau; 4] };
        let view = layers.view(&bands, &point, up, parts);
        (view.specular, view.diffuse.is_some(), view.diffuse.is_some_and(|d| d.tau.is_some()))
    };
    let snake = [1.0, 1.55, 2.0];
    assert_eq!(view(snake, 0.5, 0.0, 400.0, Parts::All), (true, true, false));
    assert_eq!(view(snake, 0.5, 0.1, 400.0, Parts::All), (true, true, true));
    assert_eq!(view(snake, 0.0, 0.1, 400.0, Parts::All), (true, false, false));
    assert_eq!(view(snake, 0.5, 87.0, 400.0, Parts::All), (true, false, false));
    assert_eq!(view([1.0, 1.5, 1.0], 0.5, 0.0, 0.0, Parts::All), (false, true, false));
    assert_eq!(view([1.0, 1.0, 1.0], 0.5, 0.0, 400.0, Parts::All), (false, true, false));
    // Without an interface the base is Lambert's.
    let layers =
        Layers::<f32>::new(&Constants { indices: [1.3; 3], ..Constants::default() }).expect("a material");
    let point = Point { thickness_nm: 400.0, roughness: 0.3, albedo: [0.5; 4], absorption: [0.0; 4] };
    for f in eval(&layers, &bands, &point, up, [0.0, 0.6, 0.8]) {
        assert!((f - 0.5 / std::f32::consts::PI).abs() < 1e-6);
    }
}

/// Anything at all: finite, not negative, and samples above the horizon.
fn sweep<B: Bands<f32, N>, const N: usize>(bands: &B, constants: &Constants, count: u32) {
    let layers = Layers::<f32>::new(constants).expect("a material");
    let cosines = [1.0, 1e-30, 1e-12, 1e-7, 1e-4, 0.0, -0.3, 0.999_999_9, 0.5];
    let corners = |list: &[f32], k: u32, lo: f32, hi: f32| {
        let bits = hash::pcg(k ^ 0x5bd1_e995);
        if bits.is_multiple_of(3) {
            list[(bits / 3) as usize % list.len()]
        } else {
            lo + (hi - lo) * unit(k) as f32
        }
    };
    let mut counter = 0;
    for _ in 0..count {
        let mut draw = |list: &[f32], lo: f32, hi: f32| {
            counter += 1;
            corners(list, counter, lo, hi)
        };
        let point = Point {
            thickness_nm: draw(&[0.0, f32::NAN, -1.0, 1e-30, 2.4e6, 1e9, f32::INFINITY], 0.0, 3000.0),
            roughness: draw(&[0.0, 1.0, 0.01, 0.0101, f32::NAN, -1.0, 2.0], 0.0, 1.0),
            albedo: [draw(&[0.0, 1.0, f32::NAN, -1.0, 2.0, 1e-30], 0.0, 1.0); N],
            absorption: [draw(&[0.0, 1e-30, 1e6, f32::INFINITY, f32::NAN, -1.0, 86.9], 0.0, 3.0); N],
        };
        let parts = [Parts::All, Parts::Specular, Parts::Diffuse, Parts::Lambert];
        let parts = parts[draw(&[0.0], 0.0, 3.99) as usize];
        let mut ray = || {
            let (z, phi) = (draw(&cosines, 0.0, 1.0), draw(&[0.0, 0.5, 1.0], 0.0, 1.0));
            let (sin, cos) = (crate::base::num::sin_turns(phi), crate::base::num::cos_turns(phi));
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            [r * cos, r * sin, z]
        };
        let (wo, wi) = (ray(), ray());
        let random = [unit(counter) as f32, unit(counter + 7) as f32, unit(counter + 9) as f32];
        let view = layers.view(bands, &point, wo, parts);
        let good = |f: [f32; N], pdf: f32| {
            let fine = |x: f32| x.is_finite() && x >= 0.0;
            assert!(
                f.into_iter().all(fine) && fine(pdf),
                "{constants:?} {point:?} {wo:?} {wi:?} {f:?} {pdf}"
            );
        };
        let (f, pdf) = view.eval_pdf(wi);
        good(f, pdf);
        if let Some(s) = view.sample(random) {
            good(s.f, s.pdf);
            assert!(
                (s.wi[2] > 0.0 || constants.base.wraps())
                    && s.pdf > 0.0
                    && (dot(s.wi, s.wi) - 1.0).abs() < 1e-5,
                "{point:?} {s:?}"
            );
            let weight = s.f[0] * s.wi[2].abs() / s.pdf;
            // Films like laser mirrors have resonances finer than the tables.
            let most = if constants.indices[1] > 5.0 { 1e6 } else { 50.0 };
            assert!(weight.is_finite() && weight < most, "{constants:?} {point:?} {wo:?} {parts:?} {s:?}");
        }
    }
}

#[test]
fn nothing_but_numbers_in_f32() {
    let spectral = Spectral::new([400.0f32, 500.0, 600.0, 700.0]);
    let colors = FilmColor::new(Method::Series(3));
    for constants in materials() {
        // Where every wavelength has its own film or lobe fewer must do.
        let slow = constants.grating.is_some() || constants.dispersion_nm2 != [0.0; 2];
        let count = if slow { 1_000 } else { 10_000 };
        sweep(&spectral, &constants, count);
        sweep(&colors, &constants, count / 4);
    }
    let curved = Base::Curved { curvature_per_mm: 0.5, thickness_mm: 1.0 };
    for base in [Base::HalfLambert { blood: [0.6, 0.0, 0.0], tint: Tint::FromNormal }, curved] {
        sweep(&spectral, &Constants { base, ..Constants::default() }, 10_000);
    }
    for indices in [[1.0, 1.55, 1.55], [2.0, 2.2, 1.0], [0.1, 10.0, 0.1], [1.0, 1.0 + 1e-6, 1.0], [1.3; 3]] {
        sweep(&spectral, &Constants { indices, energy: Energy::Coupled, ..Constants::default() }, 10_000);
    }
}

#[test]
fn light_below_the_film_is_what_the_integrals_say() {
    for (indices, tau) in [([1.0, 1.55, 2.0], 0.6), ([1.0, 1.55, 2.0], 0.0), ([1.0, 1.55, 1.33], 2.0)] {
        let layers = Layers::<f64>::new(&Constants { indices, ..Constants::default() }).expect("a material");
        let bands = Spectral::new([550.0]);
        let film = layers.double.with_thickness(400.0);
        let below = layers.below(&bands, 400.0, 0.0, [tau]);
        let rho = |tau: f64| energy::furnace(&film, 550.0, 0.0, 0.5, tau, 0.5).internal_flat;
        let integral = |node: &(f64, f64)| {
            let (u, w) = *node;
            let way = tau / cosine_in_layer(1.0, film.indices()[2], u);
            2.0 * u * w * film.power(u, 550.0).transmitted * libm::exp(-way)
        };
        let entering: f64 = gauss_legendre(64).iter().map(integral).sum();
        for (what, got, expected) in [
            ("clear", below.clear[0], 1.0 - rho(0.0)),
            ("lost", below.lost[0], 1.0 - rho(tau)),
            ("entering", below.entering[0], entering),
        ] {
            assert!((got - expected).abs() < 2e-4, "{indices:?} {tau} {what}: {got} {expected}");
        }
        // The control: another thickness is another film.
        assert!((layers.below(&bands, 430.0, 0.0, [tau]).entering[0] - entering).abs() > 1e-3);
    }
}
