// The cosine to a light, cut at the horizon, where normals vary over a pixel.

// Its mean, for normals whose slopes are spread like a bell of one width all around; `nl` is that of their mean direction.
fn mean_cosine(hidden: f32, nl: f32) -> f32 {
    if hidden <= 0.0 {
        return max(nl, 0.0);
    }
    let mean = nl * sqrt(1.0 - hidden);
    // Half of the variance lies along each axis.
    let deviation = sqrt(0.5 * hidden * max(1.0 - nl * nl, 0.01));
    // Of the normal distribution: the mean of what is above 0, by a curve that is right to 8e-5 of the deviation.
    let x = min(abs(mean) / deviation, 4.5);
    let root = max(0.89146356 + x * (-0.1390711 + x * (-0.02317349 + x * 0.00376612)), 0.0);
    let tail = root * root * root * root;
    return max(mean, 0.0) + deviation * tail * tail;
}
