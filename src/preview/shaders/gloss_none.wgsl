// The same index everywhere: nothing is reflected.

fn gloss_shine(s: Skin, wi: vec3f) -> vec3f {
    return vec3f(0.0);
}

fn gloss_ambient(s: Skin) -> vec3f {
    return vec3f(0.0);
}
