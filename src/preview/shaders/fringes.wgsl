// The transform of the colour weights, C(x), by a table: `optics::transform`.

// For every interval of 1/FRINGES_PER_NM a column of three cubics, of red, green and blue: (c0, c1, c2, c3) in the place in
// the interval. The last is 0, as is all beyond.
@group(1) @binding(1) var fringes_table: texture_2d<f32>;

const FRINGES_PER_NM = 0.05;
const FRINGES_LAST = 1024.0;

// C at a path difference, nm.
fn fringes(path_nm: f32, width_nm: f32) -> vec3f {
    let at = min(path_nm * FRINGES_PER_NM, FRINGES_LAST);
    let i = u32(at);
    let t = fract(at);
    let powers = vec4f(1.0, t, t * t, t * t * t);
    return vec3f(
        dot(textureLoad(fringes_table, vec2u(i, 0u), 0), powers),
        dot(textureLoad(fringes_table, vec2u(i, 1u), 0), powers),
        dot(textureLoad(fringes_table, vec2u(i, 2u), 0), powers),
    );
}
