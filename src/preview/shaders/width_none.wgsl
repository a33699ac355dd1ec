// A film that is as thick all over a pixel.

fn film_width(uv: vec2f) -> f32 {
    return 0.0;
}
