// What is the same for a whole picture. The layout is that of `FrameUniform` in frame.rs: a test compares them.

struct Frame {
    // World to clip space; depth is 1 at the near plane and 0 at infinity.
    clip: mat4x4f,
    eye: vec3f,
    // Layers of `sky` with roughness, from 0 to 1; the next one is irradiance.
    sky_layers: f32,
    // Directions of the view at the corners of the picture: middle, to the right, up.
    forward: vec3f,
    discs: u32,
    right: vec3f,
    // Small lights of each rectangle that shine in this sample, and where they are in their parts of it.
    first_place: u32,
    up: vec3f,
    place_step: u32,
    // Mean radiance of the environment.
    even: vec3f,
    // Added to the level of maps that a pixel covers.
    sharper: f32,
    place_shift: vec2f,
    // Which of the pictures that are averaged.
    sample: u32,
    // Depth times distance.
    near: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
