// The mean of luminances, as their logarithms have it, becomes what is asked for: `Metering::LogAverage`.

// Sum of logarithms, and how many.
@group(0) @binding(2) var meter: texture_2d<f32>;

fn metered() -> f32 {
    let found = textureLoad(meter, vec2i(0), 0).rg;
    return select(0.0, clamp(exposure.y - found.x / max(found.y, 1.0), -64.0, 64.0), found.y > 0.0);
}
