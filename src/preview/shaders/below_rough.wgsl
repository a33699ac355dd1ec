// What becomes of diffuse light below a film, by a table over its thickness and its roughness.

// Rows: clear, lost, entering of the first roughness, and so on by even steps from 0 to 1. Columns: even steps of thickness,
// and at the end very thick films, which do not interfere.
@group(1) @binding(2) var below_rows: texture_2d<f32>;

fn below_film(film: Film, roughness: f32) -> Below {
    let last = textureDimensions(below_rows) / vec2u(1u, 3u) - 1u;
    let at = min(vec2f(film.thickness_nm * material.below_per_nm, roughness * f32(last.y)), vec2f(last));
    let i = min(vec2u(at), last - 1u);
    let t = at - vec2f(i);
    return Below(below_at(i, 0u, t), below_at(i, 1u, t), below_at(i, 2u, t));
}

fn below_at(i: vec2u, row: u32, t: vec2f) -> vec3f {
    let at = vec2u(i.x, 3u * i.y + row);
    let a = mix(textureLoad(below_rows, at, 0), textureLoad(below_rows, at + vec2u(1u, 0u), 0), t.x);
    let b = mix(textureLoad(below_rows, at + vec2u(0u, 3u), 0), textureLoad(below_rows, at + vec2u(1u, 3u), 0), t.x);
    return mix(a, b, t.y).rgb;
}
