//! Directions of a lobe: the shader's against `optics::ggx` in f64.

use super::*;

/// A facet for the point (albedo.x, albedo.y), its density as a mirrored direction, and what of its light is seen.
const FACETS: &str = "
@group(0) @binding(0) var<storage, read> questions: array<Question>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4f>;
struct Question {
    albedo: vec3f, roughness: f32,
    wo: vec3f, thickness_nm: f32,
    wi: vec3f, spread_nm: f32,
}
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&questions) {
        return;
    }
    let q = questions[id.x];
    let alpha = q.roughness * q.roughness;
    let facet = visible_facet(alpha, q.wo, q.albedo.xy);
    let wi = reflect(-q.wo, facet);
    answers[4u * id.x] = vec4f(facet, mirrored_density(alpha * alpha, facet, q.wo.z));
    answers[4u * id.x + 1u] = vec4f(wi, facet_lit(alpha * alpha, max(wi.z, 1e-7), q.wo.z));
    answers[4u * id.x + 2u] = vec4f(even_point(id.x), film_reflect(Film(0.0, 0.0), 1.0).xy);
}
";

#[test]
fn directions_of_a_lobe_are_those_of_optics() {
    let Some(gpu) = gpu() else { return };
    let features = SceneFeatures { interface: true, ..SceneFeatures::default() };
    let program = SkinProgram::new(&features, &SkinOptions::default());
    let data = SkinData::new(&Constants::default(), 0.0, &program).expect("a material");
    let asked: Vec<Question> = questions(None)
        .into_iter()
        .filter(|q| q.wo[2] > 1e-3)
        .enumerate()
        .map(|(i, q)| Question {
            albedo: [unit(5 * i as u32 + 1), unit(5 * i as u32 + 2), 0.0],
            roughness: q.roughness.max(LEAST_ROUGHNESS as f32),
            ..q
        })
        .collect();
    assert!(asked.len() > 5000, "{}", asked.len());
    let probe = include_str!("../shaders/visible_facets.wgsl").to_owned() + FACETS;
    let answers = ask_by(&gpu, &program, &data, &asked, &probe);
    let (mut worst, mut wrong) = (0.0_f64, 0.0_f64);
    for (i, (q, answer)) in asked.iter().zip(&answers).enumerate() {
        let [facet, mirrored, even, _] = *answer;
        let alpha = f64::from(q.roughness).powi(2);
        let wo = q.wo.map(f64::from);
        let [x, y] = [q.albedo[0], q.albedo[1]].map(f64::from);
        let right = ggx::sample_visible(alpha, wo, [x, y]);
        // As shares of how wide the lobe is.
        let apart =
            |h: [f64; 3]| (0..3).map(|c| (f64::from(facet[c]) - h[c]).abs()).fold(0.0, f64::max) / alpha;
        worst = worst.max(apart(right));
        wrong = wrong.max(apart(ggx::sample_visible(1.05 * alpha, wo, [x, y])));
        // By the facet that the shader has found.
        let h = [0, 1, 2].map(|c| f64::from(facet[c]));
        let wi = [0, 1, 2].map(|c| f64::from(mirrored[c]));
        let vh = (0..3).map(|c| wo[c] * h[c]).sum::<f64>();
        let density = ggx::masking(alpha, wo[2]) * ggx::density_at(alpha, h) / (4.0 * wo[2]);
        assert!((f64::from(facet[3]) / density - 1.0).abs() < 1e-3, "{q:?}: {facet:?} for {density}");
        if vh > 1e-3 && wi[2] > 1e-3 {
            let lit = 4.0 * ggx::visibility(alpha, wi[2], wo[2]) * wi[2] * wo[2] / ggx::masking(alpha, wo[2]);
            assert!((f64::from(mirrored[3]) - lit).abs() < 1e-4, "{q:?}: {mirrored:?} for {lit}");
        }
        // 0.7548... and 0.5698... are 1/g and 1/g^2 of g^3 = g + 1.
        let step = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        for (got, step) in even.into_iter().zip(step) {
            let at = (0.5 + step * i as f64).fract();
            assert!((f64::from(got) - at).abs() < 1e-5, "{i}: {got} for {at}");
        }
    }
    println!("facets {worst:e}, of a lobe 5 % wider {wrong:e}");
    assert!(worst < 1e-3 && wrong > 0.02, "{worst:e} {wrong:e}");
}
