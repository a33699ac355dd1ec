// The same light from everywhere above the facet.

fn sky_light(point: SurfacePoint, facet: vec3f, a: Axes, wo: vec3f) -> vec3f {
    let open = 0.5 + 0.5 * dot(a[2], facet);
    return skin_ambient(skin_view(point, wo), frame.even * open, frame.even);
}
