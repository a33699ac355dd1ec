// Half as many columns and rows, rounded up, each the mean of the 16 texels around by a tent: `scene::bloom`.

@group(0) @binding(0) var larger: texture_2d<f32>;

const BRIGHTEST = 60000.0;

@fragment
fn halve(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let first = 2 * vec2i(clip.xy) - 1;
    let last = vec2i(textureDimensions(larger)) - 1;
    var mean = vec3f(0.0);
    for (var i = 0; i < 16; i++) {
        let step = vec2i(i & 3, i >> 2u);
        let weights = select(vec2f(0.125), vec2f(0.375), (step == vec2i(1)) | (step == vec2i(2)));
        let texel = textureLoad(larger, clamp(first + step, vec2i(0), last), 0).rgb;
        mean += weights.x * weights.y * clamp(texel, vec3f(0.0), vec3f(BRIGHTEST));
    }
    return vec4f(mean, 1.0);
}
