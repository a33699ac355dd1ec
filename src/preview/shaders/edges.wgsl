// Edges of a picture whose pixels were shaded once, in their middles: each sample of a pixel takes its colour from the pixel
// around whose middle shows the same surface.

@group(0) @binding(0) var shaded: texture_2d<f32>;
// Of the middles, and of the samples.
@group(0) @binding(1) var depths: texture_depth_2d;
@group(0) @binding(2) var samples: texture_depth_multisampled_2d;

// Distances apart by less, as a share of them, are of one surface.
const SAME = 0.01;

@vertex
fn whole(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn smoothed(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let here = vec2i(clip.xy);
    let middle = textureLoad(depths, here, 0);
    let seen = vec4f(
        textureLoad(samples, here, 0),
        textureLoad(samples, here, 1),
        textureLoad(samples, here, 2),
        textureLoad(samples, here, 3),
    );
    if all(abs(seen - middle) <= SAME * vec4f(middle)) {
        return textureLoad(shaded, here, 0);
    }
    return 0.25 * (color(here, seen.x) + color(here, seen.y) + color(here, seen.z) + color(here, seen.w));
}

// The colour of the pixel around whose depth is nearest.
fn color(here: vec2i, depth: f32) -> vec4f {
    var best = here;
    var least = abs(textureLoad(depths, here, 0) - depth);
    let last = vec2i(textureDimensions(depths)) - 1;
    for (var i = 0; i < 9; i++) {
        let there = clamp(here + vec2i(i % 3, i / 3) - 1, vec2i(0), last);
        let apart = abs(textureLoad(depths, there, 0) - depth);
        if apart < least {
            least = apart;
            best = there;
        }
    }
    return textureLoad(shaded, best, 0);
}
