// Facets of a rough surface as a view sees them: `optics::ggx::sample_visible`. What they mirror to the eye comes from directions
// of the gloss's lobe.

// One for each point of the unit square.
fn visible_facet(alpha: f32, wo: vec3f, point: vec2f) -> vec3f {
    let v = normalize(vec3f(wo.xy * alpha, wo.z));
    // A place on the cap above -v.z, added to v.
    let z = (1.0 - point.x) * (1.0 + v.z) - v.z;
    let radius = sqrt(max((1.0 - z) * (1.0 + z), 0.0));
    let angle = 2.0 * PI * (point.y - 0.5);
    let h = vec3f(radius * cos(angle), radius * sin(angle), z) + v;
    return normalize(vec3f(h.xy * alpha, max(h.z, 1e-7)));
}

// Density of the directions that such facets mirror, 1/sr, at that of a half vector: `optics::ggx::visible_density` over 4 v.h.
fn mirrored_density(a2: f32, facet: vec3f, nv: f32) -> f32 {
    return ggx_density(a2, facet) / (2.0 * (nv + sqrt(a2 + (1.0 - a2) * nv * nv)));
}

// Part of their light that others do not keep from them: G2/G1 of the view.
fn facet_lit(a2: f32, nl: f32, nv: f32) -> f32 {
    return 2.0 * nl * (nv + sqrt(a2 + (1.0 - a2) * nv * nv)) * ggx_visibility(a2, nl, nv);
}

// Point `n` of a sequence that is even over the unit square at any length (Roberts 2018), in whole numbers, which keep all digits.
fn even_point(n: u32) -> vec2f {
    let at = vec2u(n) * vec2u(3242174889u, 2447445414u) + 0x80000000u;
    return vec2f(at >> vec2u(8u)) / 16777216.0;
}
