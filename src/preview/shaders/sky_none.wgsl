// Darkness all around.

fn sky_light(point: SurfacePoint, facet: vec3f, a: Axes, wo: vec3f) -> vec3f {
    return vec3f(0.0);
}
