// Nothing hides the environment but a surface itself.

fn opening(clip: vec2f, facet: vec3f) -> Open {
    return Open(facet, 1.0);
}

fn clear_of(open: Open, direction: vec3f, width: f32) -> f32 {
    return 1.0;
}
