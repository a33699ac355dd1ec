// What the base sends to the eye through layer and film. Light goes to and fro below the film: of what is to leave, `lost`
// does, so that a base of albedo kd sends kd/(1 - kd (1 - lost)).

fn base_view(s: ptr<function, Skin>, albedo: vec3f) {
    let below = below_film((*s).film, (*s).roughness);
    // kd = a/(clear + a (1 - clear)) of an apparent albedo, multiplied out.
    let own = mix(below.clear, vec3f(1.0), material.intrinsic);
    let left = own + albedo * (below.lost - own);
    let out = base_pass(*s, (*s).wo.z);
    (*s).base = material.eta / PI * albedo * out / max(left, vec3f(1e-30));
    (*s).entering = below.entering;
}

// Part of light at a cosine that film and layer let through.
fn base_pass(s: Skin, cosine: f32) -> vec3f {
    return film_pass(s, cosine) * layer_pass(cosine);
}
