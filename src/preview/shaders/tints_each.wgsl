// Small lights of a rectangle, each in its own colour: where few of them shine in a sample.

struct Gathered {
    // By those that are seen, and by all.
    seen: vec3f,
    all: vec3f,
}

fn gather(g: ptr<function, Gathered>, skin: Skin, wi: vec3f, spread: f32, share: f32, seen: f32) {
    let tints = skin_tints(skin, wi);
    let lobes = skin_lobes(skin, wi, spread);
    let light = (tints.gloss * lobes.gloss + tints.base * lobes.base) * share;
    (*g).seen += light * seen;
    (*g).all += light;
}

// Radiance to the eye, where each that is seen sends `light`, and each hides `behind`.
fn gathered(g: Gathered, skin: Skin, light: vec3f, behind: vec3f) -> vec3f {
    return light * g.seen - behind * g.all;
}
