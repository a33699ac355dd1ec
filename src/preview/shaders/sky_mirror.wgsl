// What of the sky a gloss mirrors to the eye: what is in the mirror direction.

fn sky_mirrored(skin: Skin, a: Axes, mirrored: vec3f, layer: f32) -> vec3f {
    return sky_rough(mirrored, layer);
}
