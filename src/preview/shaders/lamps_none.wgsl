// No light but the environment's.

fn lamp_light(point: SurfacePoint, position: vec3f, facet: vec3f, a: Axes, wo: vec3f) -> vec3f {
    return vec3f(0.0);
}
