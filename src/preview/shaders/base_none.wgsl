// A black base sends nothing back.

fn base_view(s: ptr<function, Skin>, albedo: vec3f) {}

fn base_tint(s: Skin, nl: f32) -> vec3f {
    return vec3f(0.0);
}

fn base_lobe(s: Skin, nl: f32) -> f32 {
    return 0.0;
}
