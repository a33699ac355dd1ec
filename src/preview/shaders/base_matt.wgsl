// The albedo on a matt surface, without any layer.

fn base_view(s: ptr<function, Skin>, albedo: vec3f) {
    (*s).base = albedo / PI;
    (*s).entering = vec3f(1.0);
}

fn base_tint(s: Skin, nl: f32) -> vec3f {
    return s.base;
}

fn base_lobe(s: Skin, nl: f32) -> f32 {
    return mean_cosine(s.hidden, nl);
}
