// Depth alone.

@vertex
fn place_depth(@location(0) position: vec3f) -> @invariant @builtin(position) vec4f {
    return frame.clip * vec4f(position, 1.0);
}

@fragment
fn no_color() -> @location(0) vec4f {
    return vec4f(0.0);
}
