// The absorbing layer below the film: `optics::absorption`.

// Part of light at a cosine outside that survives one way through the layer.
fn layer_pass(cosine: f32) -> vec3f {
    let n = material.indices;
    let x = n.x * usable_cosine(cosine);
    // For n2 = n0 a grazing path would be endless.
    let inside = clamp(sqrt(max(admittance_squared(n.x, n.z, x), 0.0)) / n.z, 1e-4, 1.0);
    return exp(-material.absorption / inside);
}
