// Reinhard et al. 2002, equation 3, each channel alone.

fn tone(c: vec3f) -> vec3f {
    return c / (1.0 + c);
}
