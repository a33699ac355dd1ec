// Khronos PBR Neutral: `scene::tone`.

fn tone(c: vec3f) -> vec3f {
    let start = 0.8 - 0.04;
    let least = min(c.r, min(c.g, c.b));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let color = c - offset;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start {
        return color;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let gray = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3f(new_peak), gray);
}
