//! Extreme cases: what must come out, and what does.

use rayon::prelude::*;

use super::film::cosine;
use super::table::{Cell, Table};
use crate::base::hash;
use crate::optics::{Film, FilmColor, Method, Real, absorption, film_color, fresnel};

/// A case with a value that is known.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is.
    pub name: String,
    /// What must come out.
    pub expected: f64,
    /// What does in f64, and in f32.
    pub got: (f64, f64),
    /// Greatest difference allowed for each.
    pub tolerance: (f64, f64),
}

impl Case {
    /// Whether both are within their tolerance; a NaN is not.
    pub fn passes(&self) -> bool {
        (self.got.0 - self.expected).abs() <= self.tolerance.0
            && (self.got.1 - self.expected).abs() <= self.tolerance.1
    }
}

/// Known to six digits.
const SIX_DIGITS: (f64, f64) = (6e-7, 3e-6);
/// Known exactly.
const EXACT: (f64, f64) = (0.0, 0.0);

/// Reflectance at 550 nm.
fn reflectance<F: Real>(n: [f64; 3], d: f64, cosine: f64) -> f64 {
    let f = F::from_f64;
    match Film::new(f(n[0]), f(n[1]), f(n[2]), f(d)) {
        Ok(film) => film.power(f(cosine), f(550.0)).reflected.to_f64(),
        Err(_) => f64::NAN,
    }
}

/// Colour by a method.
fn color<F: Real>(method: Method, n: [f64; 3], d: f64, cosine: f64) -> [f64; 3] {
    let f = F::from_f64;
    match Film::new(f(n[0]), f(n[1]), f(n[2]), f(d)) {
        Ok(film) => FilmColor::<F>::new(method).color(&film, f(cosine)).map(F::to_f64),
        Err(_) => [f64::NAN; 3],
    }
}

/// Every case with a known value. Sources: closed forms; six-digit values from the `tmm` package where there is none.
pub fn cases() -> Vec<Case> {
    const SNAKE: [f64; 3] = film_color::DEFAULT_INDICES;
    let critical = (1.0 - 1.0 / 2.25f64).sqrt();
    let deg45 = 0.5f64.sqrt();
    let root = 2f64.sqrt();
    let mut cases = Vec::new();
    let mut at = |name: &str, n: [f64; 3], d: f64, c: f64, expected: f64, tolerance: (f64, f64)| {
        let got = (reflectance::<f64>(n, d, c), reflectance::<f32>(n, d, c));
        let [n0, n1, n2] = n;
        let [n1, d, c] = [n1, d, c].map(short);
        let name = format!("{name}: {n0}/{n1}/{n2}, {d} nm, cosine {c}");
        cases.push(Case { name, expected, got, tolerance });
    };
    for (c, r) in [(1.0, 1.0 / 9.0), (0.5, 0.161377), (0.1, 0.592433)] {
        at("no thickness is Fresnel", SNAKE, 0.0, c, r, SIX_DIGITS);
    }
    for n in [[1.0, 1.0, 1.5], [1.0, 1.5, 1.5]] {
        at("a film of its neighbour's index", n, 321.0, 0.6, 0.064525, SIX_DIGITS);
    }
    at("three equal indices", [1.4; 3], 300.0, 0.3, 0.0, (1e-15, 1e-15));
    at("quarter wave", [1.0, 1.5, 1.0], 550.0 / 6.0, 1.0, 0.147929, SIX_DIGITS);
    at("half wave", [1.0, 1.5, 1.0], 550.0 / 3.0, 1.0, 0.0, SIX_DIGITS);
    at("antireflection", [1.0, root, 2.0], 550.0 / 4.0 / root, 1.0, 0.0, SIX_DIGITS);
    for (c, r) in [(1e-2, 0.945640), (1e-3, 0.994404), (1e-6, 0.999994)] {
        at("grazing", SNAKE, 400.0, c, r, SIX_DIGITS);
    }
    at("along the surface", SNAKE, 400.0, 0.0, 1.0, EXACT);
    let frustrated = [
        (0.0, 0.0),
        (10.0, 0.003141),
        (50.0, 0.072970),
        (100.0, 0.240498),
        (300.0, 0.792268),
        (1000.0, 0.999205),
        (1e5, 1.0),
    ];
    for (d, r) in frustrated {
        at("frustrated total reflection, 45 degrees", [1.5, 1.0, 1.5], d, deg45, r, SIX_DIGITS);
    }
    for (d, r) in [(0.0, 0.0), (50.0, 0.056134), (300.0, 0.603097), (1000.0, 0.932822)] {
        // The cosine itself, rounded to f32, moves R by as much.
        at("at the critical angle of the film", [1.5, 1.0, 1.5], d, critical, r, (6e-7, 2e-5));
    }
    at("total reflection at the lower side", [2.0, 2.2, 1.0], 400.0, 0.3, 1.0, EXACT);

    let mut push = |name: &str, expected: f64, got: (f64, f64), tolerance: (f64, f64)| {
        cases.push(Case { name: name.to_owned(), expected, got, tolerance });
    };
    let incoherent = [
        (SNAKE, [0.061140, 0.110171, 0.579212]),
        ([1.0, 1.33, 1.0], [0.039330, 0.106586, 0.695440]),
        ([1.0, 1.55, 1.33], [0.051827, 0.102580, 0.577979]),
    ];
    for ([n0, n1, n2], values) in incoherent {
        for (c, r) in [1.0, 0.5, 0.1].into_iter().zip(values) {
            let thick =
                |c: f64| Film::new(n0, n1, n2, 1e9).map_or(f64::NAN, |f| film_color::incoherent(&f, c));
            let single = Film::new(n0 as f32, n1 as f32, n2 as f32, 1e9)
                .map_or(f64::NAN, |f| f64::from(film_color::incoherent(&f, c as f32)));
            push(
                &format!("endless thickness: {n0}/{n1}/{n2}, cosine {c}"),
                r,
                (thick(c), single),
                SIX_DIGITS,
            );
        }
    }
    let colors = [
        (200.0, [0.119220, 0.093832, 0.020589]),
        (400.0, [0.140605, 0.043906, 0.057435]),
        (600.0, [0.120172, 0.030457, 0.084985]),
        (2400.0, [0.061928, 0.061107, 0.061254]),
    ];
    for (d, rgb) in colors {
        let (double, single) =
            (color::<f64>(Method::REFERENCE, SNAKE, d, 1.0), color::<f32>(Method::REFERENCE, SNAKE, d, 1.0));
        for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let name = format!("colour of the default film, {d} nm, normal: {name}");
            push(&name, rgb[c], (double[c], single[c]), (1e-6, 4e-6));
        }
    }
    for (c, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let of = Method::Series(3);
        let got = (color::<f64>(of, SNAKE, 2.4e6, 0.7)[c], color::<f32>(of, SNAKE, 2.4e6, 0.7)[c]);
        push(&format!("colour at 2.4 mm, cosine 0.7, series-3: {name}"), 0.07228006, got, (1e-8, 1e-7));
    }
    let graze = |c: f64| (1.0 - reflectance::<f64>(SNAKE, 400.0, c)) / c;
    push("slope of 1 - R at grazing", 5.6146, (graze(1e-9), 5.6146), (1e-4, 1e-4));
    for (tau, factor) in [(0.0, 1.0), (1e6, 0.0)] {
        let got = (absorption::one_way(tau, 0.5), f64::from(absorption::one_way(tau as f32, 0.5)));
        push(&format!("pigment of optical depth {tau}: light left"), factor, got, EXACT);
    }
    cases
}

/// A number with at most five digits after the point, small ones by their power of ten.
fn short(v: f64) -> String {
    if v != 0.0 && v.abs() < 1e-3 {
        return format!("{v:e}");
    }
    let text = format!("{v:.5}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The cases as a table.
pub fn table(cases: &[Case]) -> Table {
    let columns = ["case", "expected", "f64", "difference", "f32", "difference f32", "result"];
    let mut table =
        Table::new("stability", "Extreme cases: power reflectance at 550 nm unless said", &columns);
    for case in cases {
        table.row([
            Cell::text(&case.name),
            Cell::Fixed(case.expected, 6),
            Cell::Fixed(case.got.0, 9),
            Cell::Scientific(case.got.0 - case.expected, 1),
            Cell::Fixed(case.got.1, 7),
            Cell::Scientific(case.got.1 - case.expected, 1),
            Cell::Pass(case.passes()),
        ]);
    }
    table
}

/// What a sweep over anything found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Films.
    pub count: u64,
    /// Results that are no numbers.
    pub not_numbers: u64,
    /// Reflectances and transmittances outside [0, 1].
    pub outside: u64,
    /// Greatest difference of R + T from 1: energy made or lost.
    pub energy: f64,
    /// Least and greatest channel of the colour by series-3.
    pub color: (f64, f64),
}

/// `count` random films, directions and wavelengths, a third of all numbers from the corners of their ranges.
pub fn sweep<F: Real>(count: u64) -> Sweep {
    let colors = FilmColor::<F>::new(Method::Series(3));
    const CHUNK: u64 = 1 << 14;
    let chunk = |chunk: u64| {
        let mut counter = (chunk as u32).wrapping_mul(0x0100_0193);
        let mut sweep = Sweep { color: (1.0, 0.0), ..Sweep::default() };
        for _ in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
            one(&mut counter, &colors, &mut sweep);
        }
        sweep
    };
    let both = |a: Sweep, b: Sweep| Sweep {
        count: a.count + b.count,
        not_numbers: a.not_numbers + b.not_numbers,
        outside: a.outside + b.outside,
        energy: a.energy.max(b.energy),
        color: (a.color.0.min(b.color.0), a.color.1.max(b.color.1)),
    };
    (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(Sweep::default, both)
}

fn one<F: Real>(counter: &mut u32, colors: &FilmColor<F>, sweep: &mut Sweep) {
    let mut draw = |corners: &[f64], low: f64, high: f64| {
        *counter = counter.wrapping_add(1);
        let bits = hash::pcg(*counter);
        let unit = f64::from(hash::pcg(bits ^ 0x9e37_79b9)) / f64::from(u32::MAX);
        let corner = corners[(bits / 3) as usize % corners.len()];
        F::from_f64(if bits.is_multiple_of(3) { corner } else { low + (high - low) * unit })
    };
    let indices = [1.0, 1.0 + 1e-7, 1.33, 1.5, 1.5 + 1e-9, 1.55, 2.0, 0.1, 10.0];
    let [n0, n1, n2] = std::array::from_fn(|_| draw(&indices, 1.0, 2.5));
    let d = draw(&[0.0, 1e-30, 1e-6, 1.0, 550.0 / 6.0, 400.0, 2.4e6, 1e9], 0.0, 3000.0);
    let cosines = [0.0, 1.0, 1e-300, 1e-38, 1e-20, 1e-6, -0.5, 2.0, f64::NAN, 0.745_355_992_5, 0.999_999_9];
    let cosine = draw(&cosines, 0.0, 1.0);
    let wavelength = draw(&[550.0, 380.0, 780.0, 0.0, -1.0, 1e30, f64::NAN], 360.0, 830.0);
    sweep.count += 1;
    let Ok(film) = Film::new(n0, n1, n2, d) else {
        sweep.outside += 1;
        return;
    };
    let power = film.power_polarised(cosine, wavelength);
    for power in [power.s, power.p] {
        let (r, t) = (power.reflected.to_f64(), power.transmitted.to_f64());
        sweep.not_numbers += u64::from(!r.is_finite() || !t.is_finite());
        sweep.outside += u64::from(!(0.0..=1.0).contains(&r) || !(0.0..=1.0).contains(&t));
        sweep.energy = sweep.energy.max((r + t - 1.0).abs());
    }
    for c in colors.color(&film, cosine).map(F::to_f64) {
        sweep.not_numbers += u64::from(!c.is_finite());
        sweep.color = (sweep.color.0.min(c), sweep.color.1.max(c));
    }
}

/// Films of no thickness whose colour is not, bit by bit, the reflectance of the plain interface; of `count` in f32.
pub fn not_fresnel(count: u32) -> u32 {
    let colors = FilmColor::<f32>::new(Method::Series(3));
    let wrong = |i: u32| {
        let [a, b, c, d] = std::array::from_fn(|j| hash::unit(hash::pcg(4 * i + j as u32)));
        let (n0, n1, n2) = (1.0 + a, 1.0 + 1.5 * b, 1.0 + 1.5 * c);
        let expected = [fresnel::reflectance(n0, n2, d); 3];
        !Film::new(n0, n1, n2, 0.0).is_ok_and(|film| colors.color(&film, d) == expected)
    };
    (0..count).filter(|i| wrong(*i)).count() as u32
}

/// How much the colour of the default film changes while its thickness grows from 2.4 mm by 10 micrometres: the moire of a
/// method. The truth is 0: no eye resolves such fringes.
pub fn moire(method: Method) -> f64 {
    let colors = FilmColor::<f32>::new(method);
    let [n0, n1, n2] = film_color::DEFAULT_INDICES.map(|n| n as f32);
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for i in 0..1000u16 {
        let Ok(film) = Film::new(n0, n1, n2, 2.4e6 + 10.0 * f32::from(i)) else { continue };
        let rgb = colors.color(&film, 0.8);
        low = std::array::from_fn(|c| low[c].min(rgb[c]));
        high = std::array::from_fn(|c| high[c].max(rgb[c]));
    }
    (0..3).map(|c| f64::from(high[c] - low[c])).fold(0.0, f64::max)
}

/// A ramp of thickness, 0 to 2400 nm over 64 pixels, seen at about 37 degrees: greatest error of a pixel's colour against
/// its true mean, with the footprint filter (series-3), and without (exact colour of the pixel's middle).
pub fn ramp() -> (f64, f64) {
    let colors = FilmColor::<f64>::new(Method::Series(3));
    let reference = FilmColor::<f64>::new(Method::REFERENCE);
    let [n0, n1, n2] = film_color::DEFAULT_INDICES;
    let film = |d: f64| Film::new(n0, n1, n2, d).ok();
    let c = 0.8;
    let pixel = |i: u32| {
        let (a, b) = (f64::from(i) * 37.5, f64::from(i + 1) * 37.5);
        let (first, middle, last) = (film(a)?, film((a + b) * 0.5)?, film(b)?);
        let paths = (first.path_difference_nm(c), last.path_difference_nm(c));
        let filtered = film_color::filtered(&colors, &middle, c, paths, 3);
        let point = reference.color(&middle, c);
        let n = 200;
        let mut mean = [0.0; 3];
        for j in 0..n {
            let part = film(a + (b - a) * (f64::from(j) + 0.5) / f64::from(n))?;
            let rgb = reference.color(&part, c);
            mean = std::array::from_fn(|k| mean[k] + rgb[k] / f64::from(n));
        }
        let apart = |rgb: [f64; 3]| (0..3).map(|k| (rgb[k] - mean[k]).abs()).fold(0.0, f64::max);
        Some((apart(filtered), apart(point)))
    };
    let pixels: Vec<Option<(f64, f64)>> = (0..64).into_par_iter().map(pixel).collect();
    pixels.into_iter().fold((0.0, 0.0), |m, p| {
        let (a, b) = p.unwrap_or((f64::INFINITY, 0.0));
        (f64::max(m.0, a), f64::max(m.1, b))
    })
}

/// The same film by Blender's Cycles 5.0 (Principled BSDF, black base of index 2.0, film 1.55, white world, 256 samples):
/// thickness in nm, angle in degrees, red, green, blue.
pub const CYCLES: [(f64, f64, [f64; 3]); 12] = [
    (0.0, 0.0, [0.1111, 0.1111, 0.1111]),
    (0.0, 45.0, [0.1227, 0.1227, 0.1227]),
    (0.0, 70.0, [0.2361, 0.2361, 0.2361]),
    (200.0, 0.0, [0.1161, 0.0944, 0.0188]),
    (200.0, 45.0, [0.1099, 0.1243, 0.0764]),
    (200.0, 70.0, [0.2056, 0.2320, 0.2293]),
    (400.0, 0.0, [0.1315, 0.0448, 0.0598]),
    (400.0, 45.0, [0.0837, 0.1214, 0.0224]),
    (400.0, 70.0, [0.1302, 0.2181, 0.2100]),
    (600.0, 0.0, [0.1143, 0.0310, 0.0817]),
    (600.0, 45.0, [0.0612, 0.1063, 0.0518]),
    (600.0, 70.0, [0.1238, 0.1913, 0.1872]),
];

/// Ours beside Cycles': the table, and the greatest difference at normal incidence.
pub fn cycles() -> (Table, f64) {
    let columns = [
        "thickness nm",
        "angle deg",
        "Cycles red",
        "Cycles green",
        "Cycles blue",
        "red",
        "green",
        "blue",
        "greatest difference",
    ];
    let mut table = Table::new("cycles", "Reflected colour of the default film, linear RGB", &columns);
    let mut worst = 0.0f64;
    for (d, angle, theirs) in CYCLES {
        let ours = color::<f64>(Method::REFERENCE, film_color::DEFAULT_INDICES, d, cosine(angle));
        let apart = (0..3).map(|c| (ours[c] - theirs[c]).abs()).fold(0.0, f64::max);
        if angle == 0.0 {
            worst = worst.max(apart);
        }
        let rgb = |rgb: [f64; 3]| rgb.map(|v| Cell::Fixed(v, 4));
        let mut row = vec![Cell::Fixed(d, 0), Cell::Fixed(angle, 0)];
        row.extend(rgb(theirs));
        row.extend(rgb(ours));
        row.push(Cell::Fixed(apart, 4));
        table.row(row);
    }
    (table, worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_passes_and_a_wrong_one_would_not() {
        for case in cases() {
            assert!(case.passes(), "{case:?}");
            let wrong = Case { expected: case.expected + 1e-3, ..case.clone() };
            assert!(!wrong.passes());
            assert!(!Case { got: (f64::NAN, f64::NAN), ..case }.passes());
        }
    }

    #[test]
    fn sweeps_find_numbers_only_and_count_every_film() {
        for sweep in [sweep::<f32>(20_001), sweep::<f64>(20_001)] {
            assert_eq!((sweep.count, sweep.not_numbers, sweep.outside), (20_001, 0, 0));
            assert!(sweep.energy > 0.0 && sweep.energy < 2e-6, "{sweep:?}");
        }
        assert_eq!(not_fresnel(1000), 0);
    }

    #[test]
    fn thick_films_have_moire_by_wavelengths_only() {
        assert!(moire(Method::Series(3)) < 1e-6);
        assert!(moire(Method::Three(film_color::BEST_NM)) > 0.05);
    }

    #[test]
    fn cycles_agrees_at_normal_incidence() {
        assert!(cycles().1 < 0.012);
    }
}
