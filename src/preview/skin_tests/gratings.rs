//! Gratings: the shader against `optics` in f64 by wavelengths without gaps.

use super::*;
use crate::optics::film_color::UNIFORM_NM;
use crate::optics::{Spectral, cie};

/// Wavelengths that stand for all: half a nanometre apart.
const ALL: usize = 800;
/// Points for each grating.
const COUNT: usize = 200;

fn features() -> SceneFeatures {
    SceneFeatures {
        film: true,
        thickness_map: true,
        interface: true,
        grating: true,
        ..SceneFeatures::default()
    }
}

/// What light does to these points by `optics`: in all wavelengths, and in the colours of its own sum over 32.
fn right(constants: &Constants, asked: &[Question]) -> [Vec<[f32; 3]>; 2] {
    let nodes = cie::uniform_nodes(ALL, UNIFORM_NM);
    let bands = Spectral::<f64, ALL>::new(std::array::from_fn(|i| nodes[i].wavelength_nm));
    let colors = FilmColor::<f64>::new(Method::Series(3));
    let layers = Layers::<f64>::new(constants).expect("a material");
    let point = |q: &Question| (f64::from(q.thickness_nm), f64::from(q.roughness));
    let all = |q: &Question| {
        let (thickness_nm, roughness) = point(q);
        let point = Point { thickness_nm, roughness, albedo: [0.0; ALL], absorption: [0.0; ALL] };
        let view = layers.view(&bands, &point, q.wo.map(f64::from), Parts::Specular);
        let f = view.eval(q.wi.map(f64::from));
        let sum = |c: usize| nodes.iter().zip(f).map(|(node, f)| node.rgb[c] * f).sum::<f64>();
        [0, 1, 2].map(|c| sum(c).max(0.0) as f32)
    };
    let few = |q: &Question| {
        let (thickness_nm, roughness) = point(q);
        let point = Point { thickness_nm, roughness, albedo: [0.0; 3], absorption: [0.0; 3] };
        let view = layers.view(&colors, &point, q.wo.map(f64::from), Parts::Specular);
        view.eval(q.wi.map(f64::from)).map(|x| x as f32)
    };
    [asked.iter().map(all).collect(), asked.iter().map(few).collect()]
}

/// Points, and lights near where an order of some wavelength leads.
fn spectra(grating: &Grating, roughnesses: [f32; 2]) -> Vec<Question> {
    let (gy, gx) = grating.direction_rad.sin_cos();
    let question = |i: u32| {
        let u = |k: u32| unit(i * 16 + k);
        let wo = direction(0.05 + 0.95 * u(0), u(1));
        let order = (u(2) * 5.0).floor() - 2.0;
        let by = order * (400.0 + 300.0 * u(3)) / grating.period_nm;
        let roughness = roughnesses[0] + (roughnesses[1] - roughnesses[0]) * u(4) * u(4);
        let off = 2.0 * roughness * roughness;
        let x = by * gx - wo[0] + off * (u(5) - 0.5);
        let y = by * gy - wo[1] + off * (u(6) - 0.5);
        let left = 1.0 - x * x - y * y;
        let (wi, thickness_nm) = ([x, y, left.max(0.0).sqrt()], 600.0 * u(7));
        (left > 1e-3).then_some(Question {
            albedo: [0.0; 3],
            roughness,
            wo,
            thickness_nm,
            wi,
            spread_nm: 0.0,
        })
    };
    (0..).filter_map(question).take(COUNT).collect()
}

/// Errors as shares of each one's greatest channel: their mean. The greatest are where an order just sets.
fn apart(got: &[[f32; 3]], right: &[[f32; 3]]) -> f32 {
    let one = |(got, right): (&[f32; 3], &[f32; 3])| {
        assert!(got.iter().all(|x| x.is_finite() && *x >= 0.0), "{got:?}");
        let scale = right.iter().fold(1e-3f32, |m, x| m.max(*x));
        (0..3).map(|c| (got[c] - right[c]).abs() / scale).sum::<f32>() / 3.0
    };
    got.iter().zip(right).map(one).sum::<f32>() / right.len() as f32
}

/// The table of orders.rs: `cargo test --lib gratings -- --nocapture` prints it.
#[test]
fn gratings_are_those_of_optics() {
    let Some(gpu) = gpu() else { return };
    for (period_nm, height_nm, roughnesses) in [
        (1000.0, 60.0, [0.1, 0.7]),
        (1000.0, 60.0, [0.05, 0.1]),
        (700.0, 120.0, [0.1, 0.7]),
        (250.0, 100.0, [0.1, 0.7]),
        (2200.0, 40.0, [0.1, 0.7]),
    ] {
        let grating = Grating { period_nm, height_nm, direction_rad: 0.4 };
        let constants = Constants { grating: Some(grating), ..Constants::default() };
        let asked = spectra(&grating, roughnesses);
        let [right, rgb] = right(&constants, &asked);
        let error = |grating: Grating, grating_wavelengths: u32| {
            let parts = Parts::Specular;
            let options = SkinOptions { grating_wavelengths, parts, ..SkinOptions::default() };
            let program = SkinProgram::new(&features(), &options);
            let constants = Constants { grating: Some(grating), ..constants };
            let data = SkinData::new(&constants, 0.0, &program).expect("a material");
            let got: Vec<_> = ask(&gpu, &program, &data, &asked).iter().map(|a| a.eval).collect();
            apart(&got, &right)
        };
        let at = [8, 16, 32].map(|count| error(grating, count));
        // The control: ridges 5 % further apart, and higher.
        let wider = Grating { period_nm: 1.05 * period_nm, height_nm: 1.05 * height_nm, ..grating };
        let wrong = error(wider, 16);
        println!(
            "{period_nm} nm, {height_nm} nm, roughness {roughnesses:?}: 8, 16, 32 wavelengths {at:.4?}, \
             ridges 5 % wider {wrong:.4}, 32 of `optics` {:.4}",
            apart(&rgb, &right)
        );
        let gaps = apart(&rgb, &right);
        assert!(at[1] < 0.06 && at[2] < 0.02 && wrong > 3.0 * at[1], "{grating:?}: {at:?} {wrong}");
        // Where the lobe is narrower than the way between wavelengths, a plain sum has gaps, and tents have none.
        assert!(roughnesses[0] >= 0.1 || gaps > 2.0 * at[1], "{gaps} {at:?}");
    }
}

#[test]
fn gratings_are_finite_at_all_extremes() {
    let Some(gpu) = gpu() else { return };
    let program = SkinProgram::new(&features(), &SkinOptions::default());
    for (period_nm, height_nm) in [(100.0, 500.0), (2400.0, 500.0), (1000.0, 500.0), (800.0, 0.01)] {
        let grating = Some(Grating { period_nm, height_nm, direction_rad: 0.3 });
        let constants = Constants { grating, ..Constants::default() };
        let data = SkinData::new(&constants, 0.0, &program).expect("a material");
        let most = data.tables.iter().map(|t| 16 * t.texels.len()).max().expect("tables");
        assert!(most <= 2 << 20 && data.tables.iter().all(|t| t.height() <= 8192), "{most}");
        let with = |roughness: f32| questions(None).into_iter().map(move |q| Question { roughness, ..q });
        let asked: Vec<_> = with(0.01).chain(with(1.0)).chain(questions(None)).collect();
        for (q, a) in asked.iter().zip(ask(&gpu, &program, &data, &asked)) {
            let all = [a.eval, a.shine, a.gloss, a.base];
            assert!(all.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{period_nm} {q:?}: {a:?}");
        }
    }
}
