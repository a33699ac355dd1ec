// Maps at the level that neighbouring pixels tell.

fn map_at(map: texture_2d<f32>, by: sampler, uv: vec2f, level: f32) -> vec4f {
    return textureSampleBias(map, by, uv, frame.sharper);
}
