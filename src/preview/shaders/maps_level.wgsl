// Maps at a level that is known.

fn map_at(map: texture_2d<f32>, by: sampler, uv: vec2f, level: f32) -> vec4f {
    return textureSampleLevel(map, by, uv, level + frame.sharper);
}
