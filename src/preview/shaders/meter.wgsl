// Sums over squares of 8 x 8 texels: see `Metering::LogAverage`.

@group(0) @binding(0) var source: texture_2d<f32>;

@fragment
fn sum(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let first = 8 * vec2i(clip.xy);
    let end = min(first + 8, vec2i(textureDimensions(source)));
    var all = vec2f(0.0);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            all += measured(vec2i(x, y));
        }
    }
    return vec4f(all, 0.0, 1.0);
}
