// What a screen shows of linear light: exposure, a tone curve, sRGB.

@group(0) @binding(0) var light: texture_2d<f32>;
// Power of two before the curve; base-2 logarithm of what the metered mean becomes; and two of nothing.
@group(0) @binding(1) var<uniform> exposure: vec4f;

const BRIGHTEST = 1e9;

@fragment
fn developed(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let color = textureLoad(light, vec2i(clip.xy), 0).rgb * exp2(exposure.x + metered());
    let c = saturate(tone(clamp(color, vec3f(0.0), vec3f(BRIGHTEST))));
    let curved = 1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055;
    return vec4f(select(curved, 12.92 * c, c <= vec3f(0.0031308)), 1.0);
}
