// The absorbing layer below the film, whose index is another one in red, green and blue: `optics::absorption`.

// Part of light at a cosine outside that survives one way through the layer.
fn layer_pass(cosine: f32) -> vec3f {
    let n0 = material.indices.x;
    let x = n0 * usable_cosine(cosine);
    let n = material.layer;
    // For n2 = n0 a grazing path would be endless.
    let inside = clamp(sqrt(max((n - n0) * (n + n0) + x * x, vec3f(0.0))) / n, vec3f(1e-4), vec3f(1.0));
    return exp(-material.absorption / inside);
}
