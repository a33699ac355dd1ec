//! The room against independent tables, and against anything at all.

use super::*;
use crate::base::hash;

/// A table of numbers, with the first word of each row.
fn table(text: &str) -> Vec<(String, Vec<f64>)> {
    text.lines()
        .skip(1)
        .map(|line| {
            let (first, rest) = line.split_once(',').expect("columns");
            (first.to_owned(), rest.split(',').map(|w| w.parse().expect("a number")).collect())
        })
        .collect()
}

/// Greatest error of reflectance and transmittance for each case, films `scale` times as thick.
fn oracle<F: Real>(scale: f64) -> Vec<(String, f64)> {
    let mut worst: Vec<(String, f64)> = Vec::new();
    for (case, n) in table(include_str!("../../tests/reference/oracle_dev.csv")) {
        let f = F::from_f64;
        let film = Film::new(f(n[0]), f(n[1]), f(n[2]), f(n[3] * scale)).expect("a film");
        let power = film.power(f(n[5]), f(n[4]));
        let error = (power.reflected.to_f64() - n[6]).abs().max((power.transmitted.to_f64() - n[7]).abs());
        match worst.iter_mut().find(|(name, _)| *name == case) {
            Some((_, worst)) => *worst = worst.max(error),
            None => worst.push((case, error)),
        }
    }
    worst
}

#[test]
fn the_oracle_is_met_in_f64() {
    let worst = oracle::<f64>(1.0);
    println!("{worst:?}");
    assert_eq!(worst.len(), 12);
    for (case, error) in worst {
        let limit = if case == "graze" { 1e-9 } else { 1e-12 };
        assert!(error <= limit, "{case}: {error:e}");
    }
}

#[test]
fn the_oracle_is_met_in_f32() {
    let worst = oracle::<f32>(1.0);
    println!("{worst:?}");
    for (case, error) in worst {
        let limit = if case == "thick" { 1e-3 } else { 2e-5 };
        assert!(error <= limit, "{case}: {error:e}");
    }
}

#[test]
fn films_5_percent_thicker_fail_the_oracle() {
    // The control: the test above can fail.
    let failed = oracle::<f64>(1.05).iter().filter(|(_, error)| *error > 1e-4).count();
    // All but thickness 0, equal indices and total reflection.
    assert_eq!(failed, 8);
}

struct ColorError {
    rms: f64,
    max: f64,
    delta_e: f64,
    /// Greatest of the rows of the default film.
    snake: f64,
}

fn colors<F: Real>(method: Method, scale: f64) -> ColorError {
    let evaluator = FilmColor::<F>::new(method);
    let mut error = ColorError { rms: 0.0, max: 0.0, delta_e: 0.0, snake: 0.0 };
    let mut count = 0.0;
    for line in include_str!("../../tests/reference/colour_dev.csv").lines().skip(1) {
        let n: Vec<f64> = line.split(',').map(|w| w.parse().expect("a number")).collect();
        let f = F::from_f64;
        let film = Film::new(f(n[0]), f(n[1]), f(n[2]), f(n[3] * scale)).expect("a film");
        let rgb = evaluator.color(&film, f(n[4])).map(F::to_f64);
        let expected = [n[5], n[6], n[7]];
        for c in 0..3 {
            let e = (rgb[c] - expected[c]).abs();
            error.max = error.max.max(e);
            error.rms += e * e;
            count += 1.0;
            if n[..3] == [1.0, 1.55, 2.0] {
                error.snake = error.snake.max(e);
            }
        }
        error.delta_e = error.delta_e.max(cie::delta_e_2000(cie::lab(rgb), cie::lab(expected)));
    }
    error.rms = (error.rms / count).sqrt();
    println!(
        "{method}: RMS {:.2e} max {:.2e} dE {:.2e} default film {:.2e}",
        error.rms, error.max, error.delta_e, error.snake
    );
    error
}

#[test]
fn the_reference_colours_are_met() {
    assert!(colors::<f64>(Method::REFERENCE, 1.0).max <= 2e-5);
    assert!(colors::<f32>(Method::REFERENCE, 1.0).max <= 1e-4);
    // The control.
    assert!(colors::<f64>(Method::REFERENCE, 1.05).max > 1e-2);
}

#[test]
fn short_series_are_within_their_stated_errors() {
    let three = colors::<f64>(Method::Series(3), 1.0);
    assert!(three.max <= 2e-2 && three.snake <= 6e-4);
    let single = colors::<f32>(Method::Series(3), 1.0);
    assert!(single.max <= 2e-2 && single.snake <= 6e-4);
    assert!(colors::<f64>(Method::Series(6), 1.0).max <= 2e-3);
}

#[test]
fn few_wavelengths_are_much_worse_than_few_terms() {
    let series = colors::<f64>(Method::Series(3), 1.0);
    let thesis = colors::<f64>(Method::Three(film_color::THESIS_NM), 1.0);
    let best = colors::<f64>(Method::Three(film_color::BEST_NM), 1.0);
    assert!(best.rms < thesis.rms && series.rms * 10.0 < best.rms && series.snake * 100.0 < thesis.snake);
    let [few, many] = [16, 128].map(|n| colors::<f64>(Method::Uniform(n), 1.0));
    assert!(many.rms < few.rms && few.rms < thesis.rms);
}

#[test]
fn what_viewers_do_is_between_three_wavelengths_and_the_series() {
    let methods =
        [Method::Three(film_color::BEST_NM), Method::BelcourGltf, Method::Belcour, Method::BelcourWhite];
    let errors = methods.map(|method| colors::<f64>(method, 1.0));
    assert!(errors.windows(2).all(|e| e[1].rms < e[0].rms));
    let series = colors::<f64>(Method::Series(3), 1.0);
    assert!(errors.iter().all(|e| e.rms > 3.0 * series.rms && e.snake > 3.0 * series.snake));
    let [single, double] = [colors::<f32>(Method::Belcour, 1.0), colors::<f64>(Method::Belcour, 1.0)];
    assert!((single.rms - double.rms).abs() < 1e-4);
    // The table is of the default film, and so are its errors.
    let table = colors::<f32>(Method::Table(256, 256), 1.0);
    assert!(table.snake > 1e-6 && table.snake < 2e-3);
}

#[test]
fn default_film_colours_are_the_independent_ones() {
    let expected = [
        (200.0, [0.119220, 0.093832, 0.020589]),
        (400.0, [0.140605, 0.043906, 0.057435]),
        (600.0, [0.120172, 0.030457, 0.084985]),
        (2400.0, [0.061928, 0.061107, 0.061254]),
    ];
    let reference = FilmColor::<f64>::new(Method::REFERENCE);
    for (d, rgb) in expected {
        let film = Film::new(1.0, 1.55, 2.0, d).expect("a film");
        for (a, b) in reference.color(&film, 1.0).into_iter().zip(rgb) {
            assert!((a - b).abs() < 1e-6, "{d}: {a} {b}");
        }
    }
    // 2.4 mm: the incoherent colour, without moire, and in f32 too.
    let film = Film::new(1.0, 1.55, 2.0, 2.4e6).expect("a film");
    let single = Film::new(1.0f32, 1.55, 2.0, 2.4e6).expect("a film");
    for c in reference.color(&film, 0.7) {
        assert!((c - 0.07228006).abs() < 1e-8, "{c}");
    }
    for c in FilmColor::<f32>::new(Method::Series(3)).color(&single, 0.7) {
        assert!((c - 0.07228006).abs() < 1e-7, "{c}");
    }
    let incoherent = [
        ([1.0, 1.55, 2.0], [0.061140, 0.110171, 0.579212]),
        ([1.0, 1.33, 1.0], [0.039330, 0.106586, 0.695440]),
        ([1.0, 1.55, 1.33], [0.051827, 0.102580, 0.577979]),
    ];
    for (n, r) in incoherent {
        let film = Film::new(n[0], n[1], n[2], 1e9).expect("a film");
        for (c, r) in [1.0, 0.5, 0.1].into_iter().zip(r) {
            assert!((film_color::incoherent(&film, c) - r).abs() < 1e-6);
        }
    }
}

#[test]
fn thickness_0_is_gray_and_exactly_fresnel_by_every_method() {
    // But for glTF's, which has no Fresnel.
    let methods = [
        Method::REFERENCE,
        Method::Series(3),
        Method::Uniform(16),
        Method::Three(film_color::BEST_NM),
        Method::Belcour,
        Method::BelcourWhite,
        Method::Table(8, 8),
    ];
    for method in methods {
        let evaluator = FilmColor::<f32>::new(method);
        for c in [0.0, 0.01, 0.5, 1.0] {
            for (n0, n2) in [(1.0, 2.0), (1.5, 1.0)] {
                let film = Film::new(n0, 1.3, n2, 0.0).expect("a film");
                assert_eq!(evaluator.color(&film, c), [fresnel::reflectance(n0, n2, c); 3]);
            }
        }
    }
}

#[test]
fn a_filtered_ramp_of_thickness_has_no_moire() {
    // 0 to 2400 nm over 64 pixels, each with its footprint, against the mean of 200 exact colours in it.
    let (reference, shading) =
        (FilmColor::<f64>::new(Method::REFERENCE), FilmColor::<f64>::new(Method::Series(3)));
    let film = |d: f64| Film::new(1.0, 1.55, 2.0, d).expect("a film");
    let (mut worst, mut unfiltered) = (0.0f64, 0.0f64);
    for pixel in 0..64 {
        let (a, b) = (f64::from(pixel) * 37.5, f64::from(pixel + 1) * 37.5);
        let (middle, c) = (film((a + b) * 0.5), 0.8);
        let paths = (film(a).path_difference_nm(c), film(b).path_difference_nm(c));
        let filtered = film_color::filtered(&shading, &middle, c, paths, 3);
        let point = reference.color(&middle, c);
        let n = 200;
        for i in 0..3 {
            let mean: f64 = (0..n)
                .map(|j| reference.color(&film(a + (b - a) * (f64::from(j) + 0.5) / f64::from(n)), c)[i])
                .sum::<f64>()
                / f64::from(n);
            worst = worst.max((filtered[i] - mean).abs());
            unfiltered = unfiltered.max((point[i] - mean).abs());
        }
    }
    println!("filtered {worst:e}, unfiltered {unfiltered:e}");
    assert!(worst <= 5e-4 && unfiltered > 2.0 * worst, "{worst:e} {unfiltered:e}");
}

/// A number that is often a corner: an end of the range, or one near it.
fn draw(counter: &mut u32, corners: &[f64], lo: f64, hi: f64) -> f64 {
    *counter = counter.wrapping_add(1);
    let bits = hash::pcg(*counter);
    let unit = f64::from(hash::pcg(bits ^ 0x9e37_79b9)) / f64::from(u32::MAX);
    if bits.is_multiple_of(3) { corners[(bits / 3) as usize % corners.len()] } else { lo + (hi - lo) * unit }
}

/// Any film, any direction, any wavelength: nothing but numbers in [0, 1] that sum to 1.
fn sweep<F: Real>(count: u32, tolerance: f64) {
    let indices = [1.0, 1.0 + 1e-7, 1.33, 1.5, 1.5 + 1e-9, 1.55, 2.0, 0.1, 10.0];
    let thicknesses = [0.0, 1e-30, 1e-6, 1.0, 550.0 / 6.0, 400.0, 2.4e6, 1e9];
    let cosines = [0.0, 1.0, 1e-300, 1e-38, 1e-20, 1e-6, -0.5, 2.0, f64::NAN, 0.745_355_992_5, 0.999_999_9];
    let wavelengths = [550.0, 380.0, 780.0, 0.0, -1.0, 1e30, f64::NAN];
    let methods = [
        Method::Series(3),
        Method::REFERENCE,
        Method::BelcourGltf,
        Method::BelcourWhite,
        Method::Table(4, 4),
    ];
    let colors = methods.map(FilmColor::<F>::new);
    let mut counter = 0;
    for i in 0..count {
        let f = F::from_f64;
        let n: [F; 3] = std::array::from_fn(|_| f(draw(&mut counter, &indices, 1.0, 2.5)));
        let d = f(draw(&mut counter, &thicknesses, 0.0, 3000.0));
        let cosine = f(draw(&mut counter, &cosines, 0.0, 1.0));
        let wavelength = f(draw(&mut counter, &wavelengths, 360.0, 830.0));
        let film = Film::new(n[0], n[1], n[2], d).expect("a film");
        let power = film.power_polarised(cosine, wavelength);
        for power in [power.s, power.p] {
            let (r, t) = (power.reflected.to_f64(), power.transmitted.to_f64());
            let good =
                (0.0..=1.0).contains(&r) && (0.0..=1.0).contains(&t) && (r + t - 1.0).abs() <= tolerance;
            assert!(good, "{n:?} {d} {cosine} {wavelength}: R {r:e} T {t:e}, sum - 1 = {:e}", r + t - 1.0);
        }
        // The reference is slow; the shading series is not.
        let method = if i % 64 == 0 { &colors[(i / 64) as usize % colors.len()] } else { &colors[0] };
        for c in method.color(&film, cosine) {
            // Out-of-gamut colours, and for few terms and Gaussians their rest.
            assert!((-0.3..=1.6).contains(&c.to_f64()), "{n:?} {d} {cosine} {}: colour {c}", method.method());
        }
    }
}

#[test]
fn a_million_films_in_f32_have_numbers_only() {
    sweep::<f32>(1_000_000, 2e-6);
}

#[test]
fn many_films_in_f64_have_numbers_only() {
    sweep::<f64>(200_000, 1e-14);
}

#[test]
#[ignore = "a minute"]
fn ten_million_films_have_numbers_only() {
    sweep::<f32>(10_000_000, 2e-6);
    sweep::<f64>(10_000_000, 1e-14);
}
