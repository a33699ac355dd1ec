// The cosine to a light, cut at the horizon, where normals vary over a pixel.

// Its mean, for normals whose slopes are spread like a bell of one width all around; `nl` is that of their mean direction.
fn mean_cosine(hidden: f32, nl: f32) -> f32 {
    if hidden <= 0.0 {
        return max(nl, 0.0);
    }
    let mean = nl * sqrt(1.0 - hidden);
    // Half of the variance lies along each axis.
    let deviation = sqrt(0.5 * hidden * max(1.0 - nl * nl, 0.01));
    let x = clamp(mean / deviation, -6.0, 6.0);
    // Of the normal distribution: its sum, by a logistic curve that is right to 2e-4, and its density.
    let above = 1.0 / (1.0 + exp(-x * (1.5976 + 0.07056 * x * x)));
    return max(mean * above + deviation * 0.398942 * exp(-0.5 * x * x), 0.0);
}
