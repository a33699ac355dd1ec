// No rectangle shines.

fn rectangle_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes, pixel: vec2f) -> vec3f {
    return vec3f(0.0);
}
