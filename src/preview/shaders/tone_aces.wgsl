// ACES as fitted by Stephen Hill: `scene::tone`.

fn tone(c: vec3f) -> vec3f {
    // Columns.
    let inside = mat3x3f(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    let outside = mat3x3f(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    // What is as bright as this is white, and squares stay exact.
    let v = min(inside * c, vec3f(1e6));
    return outside * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
}
