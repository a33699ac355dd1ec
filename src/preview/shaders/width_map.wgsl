// How much the thickness of a film varies below a texel, as a part of the thickest.

@group(2) @binding(6) var width_map: texture_2d<f32>;

fn film_width(uv: vec2f) -> f32 {
    return textureSampleBias(width_map, map_sampler, uv, SHARPER + frame.sharper).r;
}
