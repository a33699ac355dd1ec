// How a base that light reaches around sends back: `optics::base_layer`, by a table over the cosine, from -1 to 1.

// A row of light that enters on this side; where light comes through from the far side, too, a row of that.
@group(1) @binding(5) var curve: texture_2d<f32>;

// At half of 1 + the cosine.
fn curve_at(half_way: f32, row: u32) -> vec3f {
    let last = textureDimensions(curve).x - 1u;
    let at = half_way * f32(last);
    let i = min(u32(at), last - 1u);
    let a = textureLoad(curve, vec2u(i, row), 0).rgb;
    let b = textureLoad(curve, vec2u(i + 1u, row), 0).rgb;
    return mix(a, b, at - f32(i));
}
