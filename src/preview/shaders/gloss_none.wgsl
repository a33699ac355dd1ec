// The same index everywhere: nothing is reflected.

alias Lobe = f32;

fn gloss_tint(s: Skin, wi: vec3f) -> vec3f {
    return vec3f(0.0);
}

fn gloss_lobe(s: Skin, wi: vec3f, spread: f32) -> Lobe {
    return 0.0;
}

fn gloss_ambient(s: Skin) -> vec3f {
    return vec3f(0.0);
}
