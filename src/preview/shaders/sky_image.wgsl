// Light from a picture of all around, filtered beforehand: for each roughness a layer, then irradiance over pi. A layer is
// the octahedron unfolded, with texel centres on its edges, so that no texel needs another edge's.

@group(0) @binding(4) var sky: texture_2d_array<f32>;
@group(0) @binding(5) var sky_sampler: sampler;

// Its lobe is a third of a steradian wide.
const BEHIND = 3u;

fn sky_light(skin: Skin, open: Open, facet: vec3f, a: Axes) -> vec3f {
    let normal = a[2];
    // Where normals vary, light is nearer to that from everywhere.
    let one = sqrt(1.0 - skin.hidden);
    // Of a hemisphere that leans, this share is above the facet.
    let share = (0.5 + 0.5 * dot(normal, facet) * one) * open.share;
    // What bumps turn is turned towards the opening as the facet is.
    let seen = normalize(normal + (open.towards - facet));
    let irradiance = mix(frame.even, sky_layer(seen, u32(frame.sky_layers)), one) * share;
    let clear = clear_of(open, reflect(-(a * skin.wo), normal), skin_alpha(skin));
    return skin_ambient(skin, irradiance, sky_gloss(skin, facet, a, clear));
}

// Of a lobe of this width that dips below the facet, this share is above.
fn lobe_above(direction: vec3f, facet: vec3f, alpha: f32) -> f32 {
    return saturate(0.5 + 0.5 * dot(direction, facet) / max(alpha, 0.02));
}

// The sky around a direction as such a lobe blurs it, between the layers of two roughnesses.
fn sky_blurred(direction: vec3f, alpha: f32) -> vec3f {
    let layer = min(sqrt(alpha) * (frame.sky_layers - 1.0), frame.sky_layers - 1.0);
    let low = u32(layer);
    let high = min(low + 1u, u32(frame.sky_layers) - 1u);
    return mix(sky_layer(direction, low), sky_layer(direction, high), layer - f32(low));
}

// What a lamp hides: the mean over about as much as one covers.
fn sky_behind(direction: vec3f) -> vec3f {
    return sky_layer(direction, BEHIND);
}

fn sky_layer(direction: vec3f, layer: u32) -> vec3f {
    let d = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let folded = (1.0 - abs(d.zx)) * select(vec2f(-1.0), vec2f(1.0), d.xz >= vec2f(0.0));
    let p = select(d.xz, folded, d.y < 0.0);
    let size = f32(textureDimensions(sky).x);
    let uv = ((0.5 + 0.5 * p) * (size - 1.0) + 0.5) / size;
    return textureSampleLevel(sky, sky_sampler, uv, layer, 0.0).rgb;
}
