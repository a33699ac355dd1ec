// A pixel of an object: light from lamps and from all around.

// Most radiance that the target holds.
const BRIGHTEST = 60000.0;

// Least cosine between shading normal and eye: about the mean over the outermost pixel of a body. Where vertices are few, normals
// between them look away from the eye before their triangle does; with a cosine near 0 outlines were dashed with black.
const LEAST_COSINE = 0.1;

// The shading frame; a normal that looks away from the eye is turned until it just does not.
fn shading_axes(normal: vec3f, tangent: vec4f, bump: vec3f, to_eye: vec3f) -> Axes {
    var a = bumped(axes(normal, tangent.xyz, tangent.w), bump, tangent.w);
    let cosine = dot(a[2], to_eye);
    if cosine < LEAST_COSINE {
        a = axes(normalize(a[2] + to_eye * (LEAST_COSINE - cosine)), a[0], tangent.w);
    }
    return a;
}

// `normal` is that of vertices, on the eye's side; `tangent.w` is the sign of the other axis there.
fn shaded(found: Found, position: vec3f, facet: vec3f, normal: vec3f, tangent: vec4f, pixel: Pixel) -> vec4f {
    let to_eye = normalize(frame.eye - position);
    let a = shading_axes(normal, tangent, found.bump, to_eye);
    let skin = skin_view(found.point, to_eye * a);
    let lamps = sun_light(skin, position, facet, a) + rectangle_light(skin, position, facet, a, pixel);
    let light = lamps + sky_light(skin, opening(pixel.at, facet), facet, a);
    // What lamps hide of the environment may be more than is left of it, by rounding.
    return vec4f(clamp(light, vec3f(0.0), vec3f(BRIGHTEST)), 1.0);
}
