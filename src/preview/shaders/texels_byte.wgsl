// Texels of maps as bytes, which drivers on a CPU filter fast: see `Level::bytes` in textures.rs.

// Roots of colours, which tell more of dark ones.
fn color_of(texel: vec4f) -> vec4f {
    return vec4f(texel.rgb * texel.rgb, texel.a);
}

// 128 is a slope of 0.
fn form_of(texel: vec4f) -> vec4f {
    return vec4f(texel.xy * (255.0 / 127.0) - 128.0 / 127.0, texel.z, texel.w * texel.w);
}

fn width_of(texel: f32) -> f32 {
    return texel * texel;
}
