// Depths, and the way that surfaces face: smoothed, so that triangles of a coarse mesh are not seen in what it hides.

struct Facing {
    @invariant @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
}

@vertex
fn place_facing(@location(0) position: vec3f, @location(1) normal: vec3f) -> Facing {
    return Facing(frame.clip * vec4f(position, 1.0), normal);
}

@fragment
fn face(v: Facing, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let length_2 = dot(v.normal, v.normal);
    return vec4f(v.normal * (select(-1.0, 1.0, front) * inverseSqrt(max(length_2, 1e-20))), 1.0);
}
