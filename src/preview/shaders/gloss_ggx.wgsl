// What the film reflects, by its microfacets: `optics::ggx`.

fn gloss_shine(s: Skin, wi: vec3f) -> vec3f {
    if wi.z <= 0.0 {
        return vec3f(0.0);
    }
    // With less f32 would overflow, and have no half vector.
    let nl = max(wi.z, 1e-7);
    let nv = max(s.wo.z, 1e-7);
    let facet = normalize(vec3f(wi.xy + s.wo.xy, nl + nv));
    let alpha = skin_alpha(s);
    let lobe = ggx_density(alpha, facet) * ggx_visibility(alpha, nl, nv);
    return lobe * wi.z * film_reflect(s.film, dot(s.wo, facet));
}

fn gloss_ambient(s: Skin) -> vec3f {
    return lobe_reflect(s.film, s.roughness, s.wo.z);
}

// Density of normals at a unit half vector, 1/sr: its tangential part keeps digits that a cosine near 1 has lost.
fn ggx_density(alpha: f32, facet: vec3f) -> f32 {
    let a2 = alpha * alpha;
    let t = dot(facet.xy, facet.xy) + facet.z * facet.z * a2;
    return a2 / (PI * t * t);
}

// G2/(4 nl nv) of height-correlated Smith masking and shadowing.
fn ggx_visibility(alpha: f32, nl: f32, nv: f32) -> f32 {
    let a2 = alpha * alpha;
    let l = sqrt(a2 + (1.0 - a2) * nl * nl);
    let v = sqrt(a2 + (1.0 - a2) * nv * nv);
    return 0.5 / max(nv * l + nl * v, 1e-30);
}
