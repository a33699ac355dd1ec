// The mean of what sixteen neighbours of one surface found, each in other directions.

// Depths apart by less, as a share of them, are of one surface.
const SAME = 0.03;

@group(0) @binding(0) var depths: texture_depth_2d;
@group(0) @binding(1) var found: texture_2d<f32>;

@fragment
fn average(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let at = vec2i(clip.xy);
    let last = vec2i(textureDimensions(depths)) - 1;
    let here = textureLoad(depths, at, 0);
    var sum = vec4f(0.0);
    var count = 0.0;
    for (var i = 0; i < 16; i++) {
        let there = clamp(at + vec2i(i & 3, i >> 2u) - 2, vec2i(0), last);
        let weight = select(0.0, 1.0, abs(textureLoad(depths, there, 0) - here) <= SAME * here);
        sum += weight * textureLoad(found, there, 0);
        count += weight;
    }
    return sum / max(count, 1.0);
}
