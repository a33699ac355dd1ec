// Edges of a picture whose pixels were shaded once, in their middles: each sample of a pixel takes its colour from the pixel
// around whose middle shows the same surface.

@group(0) @binding(0) var shaded: texture_2d<f32>;
// Of the middles, and of the samples.
@group(0) @binding(1) var depths: texture_depth_2d;
@group(0) @binding(2) var samples: texture_depth_multisampled_2d;
@group(0) @binding(3) var depth_sampler: sampler;

// Distances apart by less, as a share of them, are of one surface.
const SAME = 0.01;

// Software adapters take all ways at once, so there is but one, with few reads.
@fragment
fn smoothed(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let here = vec2i(clip.xy);
    let seen = vec4f(
        textureLoad(samples, here, 0),
        textureLoad(samples, here, 1),
        textureLoad(samples, here, 2),
        textureLoad(samples, here, 3),
    );
    // The pixels around but for two corners: left and above, right and below. (left, below), (right, below), ...
    let size = vec2f(textureDimensions(depths));
    let above = textureGather(depths, depth_sampler, floor(clip.xy) / size);
    let below = textureGather(depths, depth_sampler, floor(clip.xy + 1.0) / size);
    let middle = above.y;
    // The other surface: what is farthest from the middle in depth, and the neighbour that shows it.
    let apart = abs(seen - middle);
    let other = select(seen.xz, seen.yw, apart.yw > apart.xz);
    let far = select(other.x, other.y, abs(other.y - middle) > abs(other.x - middle));
    var there = Neighbour(here, abs(middle - far));
    nearer(&there, here + vec2i(-1, 0), abs(above.x - far));
    nearer(&there, here + vec2i(0, -1), abs(above.z - far));
    nearer(&there, here + vec2i(1, 0), abs(below.z - far));
    nearer(&there, here + vec2i(0, 1), abs(below.x - far));
    nearer(&there, here + vec2i(-1, -1), abs(above.w - far));
    nearer(&there, here + vec2i(1, 1), abs(below.y - far));
    let same = dot(select(vec4f(0.0), vec4f(0.25), apart <= SAME * vec4f(middle)), vec4f(1.0));
    let last = vec2i(size) - 1;
    return mix(textureLoad(shaded, clamp(there.at, vec2i(0), last), 0), textureLoad(shaded, here, 0), same);
}

// A pixel, and how far from the other surface it is.
struct Neighbour {
    at: vec2i,
    apart: f32,
}

fn nearer(best: ptr<function, Neighbour>, at: vec2i, apart: f32) {
    let is = apart < (*best).apart;
    (*best).at = select((*best).at, at, is);
    (*best).apart = min((*best).apart, apart);
}
