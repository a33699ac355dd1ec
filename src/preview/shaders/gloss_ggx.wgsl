// What the film reflects, by its microfacets: `optics::ggx`.

alias Lobe = f32;

fn gloss_tint(s: Skin, wi: vec3f) -> vec3f {
    return film_reflect(s.film, dot(s.wo, half_way(s, wi)));
}

fn gloss_lobe(s: Skin, wi: vec3f, spread: f32) -> Lobe {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let a2 = min(s.alpha_2 + spread, 1.0);
    return ggx_density(a2, half_way(s, wi)) * ggx_visibility(a2, max(wi.z, 1e-7), max(s.wo.z, 1e-7)) * wi.z;
}

// Density of normals at a unit half vector, 1/sr: its tangential part keeps digits that a cosine near 1 has lost.
fn ggx_density(a2: f32, facet: vec3f) -> f32 {
    let t = dot(facet.xy, facet.xy) + facet.z * facet.z * a2;
    return a2 / (PI * t * t);
}
