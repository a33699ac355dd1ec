//! Exact values against the independent furnace, and tables against exact values.

use super::table::fast_exponential_integral_3;
use super::*;
use crate::optics::film_color;

/// Greatest errors over the rows of the furnace table: specular, internal reflection, relative diffuse.
fn errors(thicker: f64) -> (f64, f64, f64) {
    let (mut specular, mut internal, mut diffuse) = (0.0f64, 0.0f64, 0.0f64);
    for line in include_str!("../../../tests/reference/furnace_dev.csv").lines().skip(1) {
        let n: Vec<f64> = line.split(',').map(|w| w.parse().expect("a number")).collect();
        let film = Film::new(n[0], n[1], n[2], n[3] * thicker).expect("a film");
        let found = furnace(&film, n[4], n[5], n[6], n[7], n[8]);
        specular = specular.max((found.specular - n[9]).abs());
        for (found, expected) in [(found.diffuse_flat, n[10]), (found.diffuse_coupled, n[11])] {
            diffuse = diffuse.max((found - expected).abs() / expected.max(1e-6));
        }
        for (found, expected) in [(found.internal_flat, n[12]), (found.internal_coupled, n[13])] {
            internal = internal.max((found - expected).abs());
        }
    }
    println!("specular {specular:.2e}, internal {internal:.2e}, relative diffuse {diffuse:.2e}");
    (specular, internal, diffuse)
}

#[test]
fn the_furnace_is_met() {
    let (specular, internal, diffuse) = errors(1.0);
    assert!(specular <= 2e-6 && internal <= 2e-6 && diffuse <= 1e-5);
}

#[test]
fn films_5_percent_thicker_fail_the_furnace() {
    let (specular, internal, diffuse) = errors(1.05);
    assert!(specular > 1e-3 && internal > 1e-4 && diffuse > 1e-3);
}

#[test]
fn nothing_is_lost_when_coupled_and_little_when_flat() {
    for roughness in [0.0, 0.05, 0.1, 0.3, 0.5, 1.0] {
        for cosine in [1.0, 0.7, 0.4, 0.1, 0.03] {
            let film = Film::new(1.0, 1.55, 2.0, 400.0).expect("a film");
            let f = furnace(&film, 550.0, roughness, 1.0, 0.0, cosine);
            assert!((f.specular + f.diffuse_coupled - 1.0).abs() < 1e-9, "{roughness} {cosine}");
            assert!(f.specular + f.diffuse_flat < 1.01, "{roughness} {cosine}");
        }
    }
    // The published totals of the flat one (rows 0.3 and 1 of the specification).
    for (roughness, totals) in
        [(0.3, [1.0032, 0.9969, 0.9910, 0.9147]), (1.0, [0.9657, 0.9137, 0.8767, 0.7178])]
    {
        for (cosine, total) in [1.0, 0.7, 0.4, 0.2].into_iter().zip(totals) {
            let film = Film::new(1.0, 1.55, 2.0, 400.0).expect("a film");
            let f = furnace(&film, 550.0, roughness, 1.0, 0.0, cosine);
            assert!((f.specular + f.diffuse_flat - total).abs() < 1e-4, "{roughness} {cosine}");
        }
    }
}

#[test]
fn internal_reflection_has_its_known_values() {
    let known = [
        (1.0, 0.0, 0.89137174, 0.10862826),
        (1.33, 0.0, 0.91667851, 0.48178048),
        (1.5, 0.0, 0.90514155, 0.59771487),
        (2.0, 0.0, 0.85523595, 0.78619101),
        (2.0, 0.6, 0.45070744, 0.10844925),
        (2.0, 3.0, 0.03499500, 0.00020539),
    ];
    for (n2, tau, _, rho) in known {
        let film = Film::new(1.0, 1.55, n2, 400.0).expect("a film");
        let found = furnace(&film, 550.0, 0.0, 1.0, tau, 1.0).internal_flat;
        assert!((found - rho).abs() < 2e-6, "{n2} {tau}: {found}");
    }
}

#[test]
fn the_exponential_integral_is_its_definition() {
    for y in [0.0, 1e-6, 0.01, 0.3, 0.999, 1.0, 1.7, 2.0, 5.0, 20.0] {
        // int_0^1 e^(-y/s) s ds, in s = t^3 so that nodes crowd at 0.
        let integral: f64 = gauss_legendre(64)
            .iter()
            .map(|(t, w)| w * 3.0 * t * t * libm::exp(-y / t.powi(3)) * t.powi(3))
            .sum();
        assert!((exponential_integral_3(y) - integral).abs() < 1e-8, "{y}: {integral}");
        let fast = fast_exponential_integral_3(y);
        assert!((fast - exponential_integral_3(y)).abs() < 2e-7, "{y}: {fast}");
        let single = fast_exponential_integral_3(y as f32);
        assert!((f64::from(single) - exponential_integral_3(y)).abs() < 5e-7, "{y}: {single}");
    }
    for y in [86.0f32, 87.0, 100.0, 1e9, f32::INFINITY] {
        assert!(fast_exponential_integral_3(y).abs() < 1e-37);
    }
}

/// Greatest and mean error of tables against quadrature: of `1 - E`, and of what leaves.
fn interpolation(n2: f64, limit: f64, least_cosine: f64) -> ([f64; 2], [f64; 2]) {
    let film = Film::new(1.0, 1.55, n2, 0.0).expect("a film");
    let table = Table::<f64>::new(&film, None, false, true);
    let (mut e, mut j, mut count) = ([0.0f64; 2], [0.0f64; 2], 0.0);
    for i in 0..150u32 {
        let unit = |k: u32| (f64::from(i * 7 + k) * 0.618_033_988_75 * f64::from(k + 1)).fract();
        let (d, roughness) = (limit * unit(1), 0.02 + 0.98 * unit(2));
        let cosine = least_cosine + (1.0 - least_cosine) * unit(3);
        let film = film.with_thickness(d);
        let fringes = [2.0 * 1.55 * d / 550.0];
        let reflect = |c: f64| film.power(c, 550.0).reflected;
        let alpha = ggx::alpha(roughness);
        let place = table.place(roughness, fringes, [550.0]);
        let error =
            (table.transmittance(&place, cosine)[0] - 1.0 + specular_albedo(alpha, cosine, reflect)).abs();
        let leaving: f64 = gauss_legendre(ANGLES)
            .iter()
            .map(|(u, w)| 2.0 * u * w * (1.0 - specular_albedo(alpha, *u, reflect)) / (n2 * n2))
            .sum();
        let found = table.leaving(&place).clear[0];
        let lost = (found - leaving).abs() / leaving;
        (e, j) = ([e[0].max(error), e[1] + error], [j[0].max(lost), j[1] + lost]);
        count += 1.0;
    }
    let (e, j) = ([e[0], e[1] / count], [j[0], j[1] / count]);
    println!("n2 {n2}, d to {limit} nm, cosine from {least_cosine}: 1 - E {e:?}, J {j:?}");
    (e, j)
}

#[test]
fn tables_are_near_the_exact_values() {
    let (e, j) = interpolation(2.0, 1000.0, 0.1);
    assert!(e[0] < 1e-3 && e[1] < 1e-4 && j[0] < 1e-3 && j[1] < 1e-4);
    let (e, j) = interpolation(1.33, 3000.0, 0.02);
    assert!(e[0] < 1e-2 && e[1] < 1e-3 && j[0] < 1e-3 && j[1] < 1e-4);
}

#[test]
fn absorption_between_the_nodes_is_near_the_exact_values() {
    for (n2, limit) in [(2.0, 1e-6), (1.33, 1e-5), (1.0, 2e-2)] {
        let film = Film::new(1.0, 1.55, n2, 400.0).expect("a film");
        let table = Table::<f64>::new(&film, None, false, false);
        let leaving = table.leaving(&table.place(0.0, [2.0 * 1.55 * 400.0 / 550.0], [550.0]));
        let mut worst = 0.0f64;
        for tau in [1e-9, 0.01, 0.1, 0.6, 1.0, 3.0, 10.0] {
            let exact = 1.0 - furnace(&film, 550.0, 0.0, 1.0, tau, 1.0).internal_flat;
            let lost = table.lost(&leaving, [tau])[0];
            worst = worst.max((lost - exact).abs());
        }
        println!("n2 {n2}: {worst:.1e}");
        assert!(worst < limit.max(2e-4), "{n2}: {worst:e}");
    }
}

#[test]
fn beyond_the_table_is_the_incoherent_limit() {
    let film = Film::new(1.0, 1.55, 2.0, 0.0).expect("a film");
    for rgb in [false, true] {
        let table = Table::<f32>::new(&film, None, rgb, true);
        let thick = table.place(0.0, [25.0f32, 1e9, f32::INFINITY], [550.0; 3]);
        for u in [1.0, 0.8, 0.3, 0.05] {
            let exact = film_color::incoherent(&film.with_thickness(1e6), u) as f32;
            for t in table.transmittance(&thick, u as f32) {
                assert!((1.0 - t - exact).abs() < 2e-5, "{u} {t} {exact}");
            }
        }
        // A NaN is thickness 0, and nothing is out of bounds.
        let odd = table.transmittance(&table.place(f32::NAN, [f32::NAN], [f32::NAN]), f32::NAN);
        assert_eq!(odd, table.transmittance(&table.place(0.0, [0.0], [550.0]), 0.0));
    }
}
