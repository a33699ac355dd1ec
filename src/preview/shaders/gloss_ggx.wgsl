// What the film reflects, by its microfacets: `optics::ggx`.

fn gloss_tint(s: Skin, wi: vec3f) -> vec3f {
    return film_reflect(s.film, dot(s.wo, half_way(s, wi)));
}

fn gloss_lobe(s: Skin, wi: vec3f, spread: f32) -> f32 {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let a2 = min(s.alpha_2 + spread, 1.0);
    return ggx_density(a2, half_way(s, wi)) * ggx_visibility(a2, max(wi.z, 1e-7), max(s.wo.z, 1e-7)) * wi.z;
}

fn gloss_ambient(s: Skin) -> vec3f {
    return lobe_reflect(s.film, sqrt(skin_alpha(s)), s.wo.z);
}

// The facet that mirrors a light to the eye. With smaller cosines f32 would overflow, and have no half vector.
fn half_way(s: Skin, wi: vec3f) -> vec3f {
    return normalize(vec3f(wi.xy + s.wo.xy, max(wi.z, 1e-7) + max(s.wo.z, 1e-7)));
}

// Density of normals at a unit half vector, 1/sr: its tangential part keeps digits that a cosine near 1 has lost.
fn ggx_density(a2: f32, facet: vec3f) -> f32 {
    let t = dot(facet.xy, facet.xy) + facet.z * facet.z * a2;
    return a2 / (PI * t * t);
}

// G2/(4 nl nv) of height-correlated Smith masking and shadowing.
fn ggx_visibility(a2: f32, nl: f32, nv: f32) -> f32 {
    let l = sqrt(a2 + (1.0 - a2) * nl * nl);
    let v = sqrt(a2 + (1.0 - a2) * nv * nv);
    return 0.5 / max(nv * l + nl * v, 1e-30);
}
