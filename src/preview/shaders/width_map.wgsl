// How much the thickness of a film varies below a texel, as a part of all its range.

@group(2) @binding(6) var width_map: texture_2d<f32>;
@group(2) @binding(7) var width_sampler: sampler;

fn film_width(uv: vec2f, level: f32) -> f32 {
    return width_of(map_at(width_map, width_sampler, uv, level).r);
}
