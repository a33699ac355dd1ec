// The same light from everywhere above the facet.

fn sky_light(skin: Skin, open: Open, facet: vec3f, a: Axes) -> vec3f {
    let above = (0.5 + 0.5 * dot(a[2], facet) * sqrt(1.0 - skin.hidden)) * open.share;
    let mirrored = reflect(-(a * skin.wo), a[2]);
    return skin_ambient(skin, frame.even * above, gloss_ambient(skin) * frame.even * clear_of(open, mirrored, skin_alpha(skin)));
}

// What a lamp hides.
fn sky_behind(direction: vec3f) -> vec3f {
    return frame.even;
}
