// The same light from everywhere above the facet.

fn sky_light(skin: Skin, facet: vec3f, a: Axes) -> vec3f {
    let open = 0.5 + 0.5 * dot(a[2], facet) * sqrt(1.0 - skin.hidden);
    return skin_ambient(skin, frame.even * open, frame.even);
}

// What a lamp hides.
fn sky_behind(direction: vec3f) -> vec3f {
    return frame.even;
}
