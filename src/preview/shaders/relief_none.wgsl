// Maps are looked up on the surface.

fn relieved(v: Varying, normal: vec3f) -> vec2f {
    return v.uv;
}
