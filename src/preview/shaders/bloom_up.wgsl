// A picture mixed with a smaller one that is drawn as large as it: `scene::bloom`.

@group(0) @binding(0) var larger: texture_2d<f32>;
@group(0) @binding(1) var smaller: texture_2d<f32>;
// Share of the larger one, and three of nothing.
@group(0) @binding(2) var<uniform> own: vec4f;

const BRIGHTEST = 60000.0;

@fragment
fn mixed(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let at = vec2i(clip.xy);
    // Three quarters of the nearest, a quarter of the next.
    let near = at / 2;
    let next = near + 2 * (at % 2) - 1;
    let upper = 0.75 * small(near) + 0.25 * small(vec2i(next.x, near.y));
    let lower = 0.75 * small(vec2i(near.x, next.y)) + 0.25 * small(next);
    let below = 0.75 * upper + 0.25 * lower;
    let texel = clamp(textureLoad(larger, at, 0).rgb, vec3f(0.0), vec3f(BRIGHTEST));
    return vec4f(mix(below, texel, own.x), 1.0);
}

fn small(at: vec2i) -> vec3f {
    return textureLoad(smaller, clamp(at, vec2i(0), vec2i(textureDimensions(smaller)) - 1), 0).rgb;
}
