//! Bessel's functions, reciprocity, energy, and samples against their density.

use super::*;
use crate::base::hash;
use crate::optics::layered::{Constants, LEAST_ROUGHNESS, Layers, Parts, Point};
use crate::optics::{FilmColor, Method, Spectral};

fn unit(counter: u32) -> f64 {
    f64::from(hash::pcg(hash::pcg(counter) ^ 0x51ed_270b) >> 8) / f64::from(1 << 24)
}

fn direction(z: f64, phi: f64) -> [f64; 3] {
    let r = (1.0 - z * z).sqrt();
    [r * libm::cos(phi), r * libm::sin(phi), z]
}

fn ridges(period_nm: f32, height_nm: f32) -> Ridges<f64> {
    let grating = Grating { period_nm, height_nm, direction_rad: 0.3 };
    Ridges::new(&grating).expect("in range").expect("a height")
}

#[test]
fn parts_are_bessels_and_sum_to_1() {
    for i in 0..=1000u32 {
        let x = f64::from(i).powi(2) * 2e-5;
        let squares = bessel_squares(x);
        for (m, square) in (0..).zip(squares) {
            assert!((square - libm::jn(m, x).powi(2)).abs() < 1e-12, "J{m}({x})");
            assert!((bessel_square(m as usize, x) - square).abs() < 1e-6, "J{m}({x})");
        }
        // Beyond 13 orders something is left above x = 4.
        let total = squares[0] + 2.0 * squares[1..].iter().sum::<f64>();
        assert!((total - 1.0).abs() < 1e-12 || x > 4.0, "{x}: {total}");
    }
    for tiny in [0.0, 1e-300, 1e-5, 0.99e-4, 1.01e-4, f64::NAN] {
        let squares = bessel_squares(tiny);
        assert!((squares[0] - 1.0).abs() < 1e-8 && squares[1] < 1e-8, "{tiny}");
    }
}

#[test]
fn efficiencies_are_those_of_a_phase_grating() {
    // The power of the Fourier series of exp(i phi sin), summed up directly; h = 100 nm at 550 nm, along the normal.
    let phi = TAU * 100.0 * 2.0 / 550.0;
    for (m, known) in [(0, 0.004067), (1, 0.294366), (2, 0.169051)] {
        let n = 512;
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..n {
            let t = TAU * f64::from(k) / f64::from(n);
            let angle = phi * libm::sin(t) - f64::from(m) * t;
            (re, im) = (re + libm::cos(angle) / f64::from(n), im + libm::sin(angle) / f64::from(n));
        }
        let part = bessel_squares(phi)[m as usize];
        assert!((part - known).abs() < 1e-6 && (part - re * re - im * im).abs() < 1e-12, "{m}: {part}");
    }
}

#[test]
fn directions_may_be_swapped() {
    let ridges = ridges(900.0, 80.0);
    for i in 0..2000 {
        let u = |k: u32| unit(i * 8 + k);
        let (a, b) = (direction(u(0), 7.0 * u(1)), direction(u(2), 7.0 * u(3)));
        let (l, alpha) = (380.0 + 400.0 * u(4), u(5).powi(2).max(1e-4));
        let (there, back) = (ridges.lobe(l, alpha, a, b).0, ridges.lobe(l, alpha, b, a).0);
        assert!((there - back).abs() <= 1e-12 * there.max(1.0), "{there} {back}");
    }
}

/// Power that ridges on a perfect mirror send into the hemisphere, by its own samples.
fn energy(ridges: &Ridges<f64>, l: f64, alpha: f64, wo: [f64; 3], n: u32) -> f64 {
    let mut sum = 0.0;
    for i in 0..n {
        // A lattice: evenly spread over the cube.
        let random = [0.819_172_513, 0.671_043_607, 0.549_700_478]
            .map(|step: f64| (0.5 + step * f64::from(i)).fract());
        if let Some(wi) = ridges.sample(l, alpha, wo, random) {
            let (lobe, pdf) = ridges.lobe(l, alpha, wi, wo);
            sum += lobe * wi[2] / pdf;
        }
    }
    sum / f64::from(n)
}

#[test]
fn no_light_is_made() {
    let (mut most, mut least) = ((0.0f64, String::new()), 2.0f64);
    for i in 0..300u32 {
        let u = |k: u32| unit(i * 8 + k);
        let (period, height) = (250.0 + 1500.0 * u(0) as f32, 20.0 + 150.0 * u(1) as f32);
        let wo = direction(0.05 + 0.95 * u(2), 7.0 * u(3));
        let alpha = (LEAST_ROUGHNESS + 0.6 * u(4)).powi(2);
        let l = 380.0 + 400.0 * u(5);
        let found = energy(&ridges(period, height), l, alpha, wo, 1000);
        if found > most.0 {
            most = (found, format!("{period} {height} {wo:?} {alpha} {l}"));
        }
        least = if wo[2] > 0.3 && alpha < 0.002 { least.min(found) } else { least };
    }
    println!("energy {least:.4} (smooth, cosine above 0.3) to {most:?}");
    // What is above 1 is the noise of 1000 samples: shares sum to at most 1, and so does each lobe.
    assert!(most.0 < 1.005 && least > 0.8, "{least} {most:?}");
}

#[test]
fn samples_have_the_stated_density() {
    // Means of functions over samples against their integrals; a plain sum finds the energy, too.
    let functions: [fn([f64; 3]) -> f64; 4] = [|_| 1.0, |w| w[2], |w| w[0], |w| f64::from(w[1] < 0.1)];
    for (case, (mu, alpha, period)) in
        (0u32..).zip([(0.9, 0.2, 800.0), (0.4, 0.3, 1200.0), (0.7, 0.1, 500.0)])
    {
        let (ridges, l, wo) = (ridges(period, 90.0), 520.0, direction(mu, 0.9));
        let n = 30_000u32;
        let mut means = [0.0; 4];
        for i in 0..n {
            let random = [0, 1, 2].map(|k| unit((case * n + i) * 3 + k));
            if let Some(wi) = ridges.sample(l, alpha, wo, random) {
                assert!((dot(wi, wi) - 1.0).abs() < 1e-9 && ridges.lobe(l, alpha, wi, wo).1 > 0.0);
                (0..4).for_each(|k| means[k] += functions[k](wi) / f64::from(n));
            }
        }
        let (mut exact, mut power, side) = ([0.0; 4], 0.0, 200);
        for i in 0..side * side {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(side);
            let wi = direction(at(i / side), TAU * at(i % side));
            let area = TAU / f64::from(side * side);
            let (lobe, density) = ridges.lobe(l, alpha, wi, wo);
            let p = density * area;
            (0..4).for_each(|k| exact[k] += functions[k](wi) * p);
            power += lobe * wi[2] * area;
        }
        println!("case {case}: {means:?} {exact:?} power {power}");
        for k in 0..4 {
            assert!((means[k] - exact[k]).abs() < 1.5e-2, "{case}: {means:?} {exact:?}");
        }
        let sampled = energy(&ridges, l, alpha, wo, 10_000);
        assert!((sampled - power).abs() < 4e-3, "{sampled} {power}");
    }
}

#[test]
fn the_brdf_has_the_orders_in_their_directions() {
    // Light along the normal, ridges of 1000 nm across x: 500 nm leaves at a sine of 1/2, 650 nm at 0.65.
    let grating = Some(Grating { period_nm: 1000.0, height_nm: 60.0, direction_rad: 0.0 });
    let layers = Layers::<f64>::new(&Constants { grating, ..Constants::default() }).expect("a material");
    let bands = Spectral::new([500.0, 650.0]);
    let point = Point { thickness_nm: 300.0, roughness: 0.05, albedo: [0.3; 2], absorption: [0.0; 2] };
    let up = [0.0, 0.0, 1.0];
    let view = layers.view(&bands, &point, up, Parts::All);
    let at = |sine: f64, turn: f64| {
        view.eval([sine * libm::cos(turn), sine * libm::sin(turn), (1.0 - sine * sine).sqrt()])
    };
    let (blue, red) = (at(0.5, 0.0), at(0.65, 0.0));
    assert!(blue[0] > 100.0 * blue[1] && red[1] > 100.0 * red[0], "{blue:?} {red:?}");
    assert!(at(0.5, 1.57)[0] < 0.01 * blue[0]);
    // Both bands sampled as their density says: weights average to what evaluation adds up to over all light.
    let rgb = FilmColor::<f64>::new(Method::Series(3));
    let point = Point { thickness_nm: 300.0, roughness: 0.4, albedo: [0.3; 3], absorption: [0.1; 3] };
    let view = layers.view(&rgb, &point, direction(0.8, 1.0), Parts::All);
    let (mut sampled, mut exact, n, side) = ([0.0; 3], [0.0; 3], 3000u32, 60);
    for i in 0..n {
        if let Some(s) = view.sample([0, 1, 2].map(|k| unit(i * 3 + k))) {
            (0..3).for_each(|c| sampled[c] += s.f[c] * s.wi[2] / s.pdf / f64::from(n));
        }
    }
    for i in 0..side * side {
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(side);
        let wi = direction(at(i / side), TAU * at(i % side));
        let f = view.eval(wi);
        (0..3).for_each(|c| exact[c] += f[c] * wi[2] * TAU / f64::from(side * side));
    }
    println!("sampled {sampled:?}, integrated {exact:?}");
    (0..3).for_each(|c| assert!((sampled[c] / exact[c] - 1.0).abs() < 0.04));
}

#[test]
fn no_height_is_no_grating_and_what_cannot_be_is_refused() {
    let with = |period_nm, height_nm, direction_rad| {
        let grating = Some(Grating { period_nm, height_nm, direction_rad });
        Layers::<f32>::new(&Constants { grating, ..Constants::default() })
    };
    let flat = with(800.0, 0.0, 0.0).expect("a material");
    let plain = Layers::<f32>::new(&Constants::default()).expect("a material");
    let bands = Spectral::new([550.0f32]);
    let point = Point { thickness_nm: 300.0, roughness: 0.3, albedo: [0.3], absorption: [0.0] };
    let (a, b) = ([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]);
    let eval = |layers: &Layers<f32>| layers.view(&bands, &point, a, Parts::All).eval_pdf(b);
    assert_eq!(eval(&flat), eval(&plain));
    for (name, bad) in [
        ("period_nm", with(f32::NAN, 50.0, 0.0)),
        ("period_nm", with(10.0, 50.0, 0.0)),
        ("height_nm", with(800.0, -1.0, 0.0)),
        ("direction_rad", with(800.0, 50.0, f32::INFINITY)),
    ] {
        assert!(matches!(bad, Err(FilmError::Grating { name: n, .. }) if n == name));
    }
}
