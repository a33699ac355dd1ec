// A rectangle that shines, as the eye sees it.

struct Shining {
    @builtin(position) clip: vec4f,
    @location(0) radiance: vec3f,
}

const BRIGHTEST = 60000.0;

@vertex
fn place_lamp(@location(0) position: vec3f, @location(1) radiance: vec3f) -> Shining {
    return Shining(frame.clip * vec4f(position, 1.0), min(radiance, vec3f(BRIGHTEST)));
}

@fragment
fn glow(s: Shining) -> @location(0) vec4f {
    return vec4f(s.radiance, 1.0);
}
