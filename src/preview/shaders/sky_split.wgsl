// The gloss by a split sum: the sky as the lobe blurs it in the mirror direction, times what the lobe reflects of even light.

fn sky_gloss(skin: Skin, facet: vec3f, a: Axes, clear: f32) -> vec3f {
    let mirrored = reflect(-(a * skin.wo), a[2]);
    let alpha = skin_alpha(skin);
    return gloss_ambient(skin) * sky_blurred(mirrored, alpha) * min(lobe_above(mirrored, facet, alpha), clear);
}
