// What is behind everything: a triangle over the whole picture, at the far end.

const BRIGHTEST = 60000.0;

struct Disc {
    // Unit vector to it, and the square of half its chord.
    direction: vec3f,
    chord_2: f32,
    radiance: vec3f,
    padding: f32,
}

@group(1) @binding(0) var<uniform> discs: array<Disc, 32>;

struct Behind {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn behind(@builtin(vertex_index) i: u32) -> Behind {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Behind(vec4f(at, 0.0, 1.0), at);
}

@fragment
fn look(b: Behind) -> @location(0) vec4f {
    let direction = normalize(frame.forward + frame.right * b.at.x + frame.up * b.at.y);
    var sum = surroundings(direction);
    for (var i = 0u; i < frame.discs; i++) {
        let apart = direction - discs[i].direction;
        if dot(apart, apart) <= discs[i].chord_2 {
            sum += discs[i].radiance;
        }
    }
    return vec4f(min(sum, vec3f(BRIGHTEST)), 1.0);
}
