// What becomes of diffuse light below a film, by a table over its thickness.

// Rows: clear, lost, entering. Columns: even steps of thickness, and at the end very thick films, which do not interfere.
@group(1) @binding(2) var below_rows: texture_2d<f32>;

fn below_film(film: Film, roughness: f32) -> Below {
    let last = textureDimensions(below_rows).x - 1u;
    let at = min(film.thickness_nm * material.below_per_nm, f32(last));
    let i = min(u32(at), last - 1u);
    let t = at - f32(i);
    return Below(below_at(i, 0u, t), below_at(i, 1u, t), below_at(i, 2u, t));
}

fn below_at(i: u32, row: u32, t: f32) -> vec3f {
    let a = textureLoad(below_rows, vec2u(i, row), 0).rgb;
    let b = textureLoad(below_rows, vec2u(i + 1u, row), 0).rgb;
    return mix(a, b, t);
}
