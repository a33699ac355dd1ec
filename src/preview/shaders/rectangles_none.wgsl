// No rectangle shines.

fn rectangle_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes, pixel: Pixel) -> vec3f {
    return vec3f(0.0);
}
