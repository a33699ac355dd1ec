// A film that is as thick all over a pixel.

fn film_width(uv: vec2f, level: f32) -> f32 {
    return 0.0;
}
