// Darkness all around.

fn sky_light(skin: Skin, open: Open, facet: vec3f, a: Axes) -> vec3f {
    return vec3f(0.0);
}

// What a lamp hides.
fn sky_behind(direction: vec3f) -> vec3f {
    return vec3f(0.0);
}
