// Depth as a light sees it.

struct Light {
    clip: mat4x4f,
}

@group(0) @binding(0) var<uniform> light: Light;

@vertex
fn place_caster(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return light.clip * vec4f(position, 1.0);
}
