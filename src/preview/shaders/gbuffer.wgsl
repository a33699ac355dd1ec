// What shading needs of the triangle that a pixel shows, so that pixels are shaded once all triangles are drawn: programs on a
// CPU shade squares of 16 pixels for each triangle in them.

// Texels of the sharpest level of maps.
override COLUMNS: f32 = 1.0;
override ROWS: f32 = 1.0;

struct Recorded {
    @location(0) uv: vec2f,
    // And the level of maps that a pixel covers.
    @location(1) normal: vec4f,
    @location(2) tangent: vec4f,
}

@fragment
fn record(v: Varying, @builtin(front_facing) front: bool) -> Recorded {
    let facet = facet_of(v.position, frame.eye - v.position);
    let size = vec2f(COLUMNS, ROWS);
    let x = dpdx(v.uv) * size;
    let y = dpdy(v.uv) * size;
    let level = 0.5 * log2(clamp(max(dot(x, x), dot(y, y)), 1e-6, 1e9));
    let normal = outward(v, facet, front);
    return Recorded(relieved(v, normal), vec4f(normal, level), tangent_of(v, front));
}
