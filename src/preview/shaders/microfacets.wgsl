// What all rough surfaces that reflect have: `optics::ggx`.

fn gloss_ambient(s: Skin) -> vec3f {
    return lobe_reflect(s.film, sqrt(skin_alpha(s)), s.wo.z);
}

// The facet that mirrors a light to the eye. With smaller cosines f32 would overflow, and have no half vector.
fn half_way(s: Skin, wi: vec3f) -> vec3f {
    return normalize(vec3f(wi.xy + s.wo.xy, max(wi.z, 1e-7) + max(s.wo.z, 1e-7)));
}

// G2/(4 nl nv) of height-correlated Smith masking and shadowing.
fn ggx_visibility(a2: f32, nl: f32, nv: f32) -> f32 {
    let l = sqrt(a2 + (1.0 - a2) * nl * nl);
    let v = sqrt(a2 + (1.0 - a2) * nv * nv);
    return 0.5 / max(nv * l + nl * v, 1e-30);
}
