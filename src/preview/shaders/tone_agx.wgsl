// AgX as fitted by Benjamin Wrensch: `scene::tone`.

fn tone(c: vec3f) -> vec3f {
    // Columns.
    let inset = mat3x3f(
        0.84247906, 0.042328242, 0.042375655, 0.0784336, 0.87846864, 0.0784336, 0.079223745, 0.07916613, 0.87914297,
    );
    let outset = mat3x3f(
        1.196879, -0.052896757, -0.052971636, -0.09802088, 1.1519031, -0.09804345, -0.09902974, -0.09896118, 1.1510737,
    );
    let low = -12.47393;
    let high = 4.026069;
    let x = saturate((log2(max(inset * c, vec3f(1e-30))) - low) / (high - low));
    let p = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x) - 0.00232;
    // The curve gives what a display of exponent 2.2 takes.
    return pow(max(outset * p, vec3f(0.0)), vec3f(2.2));
}
