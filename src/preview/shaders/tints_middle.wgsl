// Small lights of a rectangle, all in one colour: that of the middle of what is seen of it.

struct Gathered {
    // Lobes of those that are seen, and of all.
    seen: Lobes,
    all: Lobes,
    middle: vec3f,
}

fn gather(g: ptr<function, Gathered>, skin: Skin, wi: vec3f, spread: f32, share: f32, seen: f32) {
    let lobes = skin_lobes(skin, wi, spread);
    (*g).seen.gloss += lobes.gloss * (share * seen);
    (*g).seen.base += lobes.base * (share * seen);
    (*g).all.gloss += lobes.gloss * share;
    (*g).all.base += lobes.base * share;
    // Where none is seen, that of all.
    (*g).middle += wi * (share * (seen + 1e-3));
}

// Radiance to the eye, where each that is seen sends `light`, and each hides `behind`.
fn gathered(g: Gathered, skin: Skin, light: vec3f, behind: vec3f) -> vec3f {
    let tints = skin_tints(skin, g.middle * inverseSqrt(max(dot(g.middle, g.middle), 1e-30)));
    return tints.gloss * (light * g.seen.gloss - behind * g.all.gloss)
        + tints.base * (light * g.seen.base - behind * g.all.base);
}
