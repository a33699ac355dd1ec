// No curve.

fn tone(c: vec3f) -> vec3f {
    return c;
}
