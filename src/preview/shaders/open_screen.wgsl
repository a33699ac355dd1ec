// What the picture's depths leave of the environment: see occlusion.wgsl.

@group(3) @binding(0) var openings: texture_2d<f32>;

fn opening(clip: vec2f, facet: vec3f) -> Open {
    let found = textureLoad(openings, vec2i(clip), 0);
    let length_2 = dot(found.xyz, found.xyz);
    return Open(select(facet, found.xyz * inverseSqrt(max(length_2, 1e-20)), length_2 > 1e-12), saturate(found.w));
}

// Part of a lobe of this width that lies within the cone of an opening: the sine of the angle from its rim, over the width.
fn clear_of(open: Open, direction: vec3f, width: f32) -> f32 {
    let cosine = dot(direction, open.towards);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    let inside = sqrt(open.share) * cosine - sqrt(1.0 - open.share) * sine;
    return saturate(0.5 + 0.5 * inside / max(width, 0.02));
}
