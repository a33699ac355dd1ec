// The albedo on a matt surface, without any layer.

fn base_view(s: ptr<function, Skin>, albedo: vec3f) {
    (*s).base = albedo / PI;
    (*s).entering = vec3f(1.0);
}

fn base_shine(s: Skin, nl: f32) -> vec3f {
    return s.base * max(nl, 0.0);
}
