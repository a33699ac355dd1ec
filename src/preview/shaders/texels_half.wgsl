// Texels of maps as they are.

fn color_of(texel: vec4f) -> vec4f {
    return texel;
}

fn form_of(texel: vec4f) -> vec4f {
    return texel;
}

fn width_of(texel: f32) -> f32 {
    return texel;
}
