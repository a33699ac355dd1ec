// No light from far away but the environment's.

fn sun_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes) -> vec3f {
    return vec3f(0.0);
}
