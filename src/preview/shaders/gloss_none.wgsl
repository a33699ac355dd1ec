// The same index everywhere: nothing is reflected.

fn gloss_tint(s: Skin, wi: vec3f, spread: f32) -> vec3f {
    return vec3f(0.0);
}

fn gloss_lobe(s: Skin, wi: vec3f, spread: f32) -> f32 {
    return 0.0;
}

fn gloss_ambient(s: Skin) -> vec3f {
    return vec3f(0.0);
}
