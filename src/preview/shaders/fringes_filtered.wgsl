// The transform of the colour weights, C(x), and its mean over a range, by a table: `optics::transform`.

// For every interval of 1/FRINGES_PER_NM a column of three cubics, of red, green and blue: (c0, c1, c2, c3) in the place in
// the interval; and the integral of C from 0 to its start, nm. The last cubics are 0, as is all beyond.
@group(1) @binding(1) var fringes_table: texture_2d<f32>;

const FRINGES_PER_NM = 0.05;
const FRINGES_LAST = 1024.0;
// Path differences that are nearer are one, nm: the mean would cancel.
const LEAST_WIDTH_NM = 4.0;

// Mean of C over path differences around `path_nm`, nm: what a pixel sees whose path difference varies by `width_nm`.
fn fringes(path_nm: f32, width_nm: f32) -> vec3f {
    if width_nm < LEAST_WIDTH_NM {
        let at = min(path_nm * FRINGES_PER_NM, FRINGES_LAST);
        let t = fract(at);
        return fringes_cubics(u32(at), vec4f(1.0, t, t * t, t * t * t));
    }
    let lo = max(path_nm - 0.5 * width_nm, 0.0);
    let hi = path_nm + 0.5 * width_nm;
    return (fringes_integral(hi) - fringes_integral(lo)) / (hi - lo);
}

fn fringes_cubics(i: u32, powers: vec4f) -> vec3f {
    return vec3f(
        dot(textureLoad(fringes_table, vec2u(i, 0u), 0), powers),
        dot(textureLoad(fringes_table, vec2u(i, 1u), 0), powers),
        dot(textureLoad(fringes_table, vec2u(i, 2u), 0), powers),
    );
}

// Integral of C from 0 to a path difference, nm.
fn fringes_integral(path_nm: f32) -> vec3f {
    let at = min(path_nm * FRINGES_PER_NM, FRINGES_LAST);
    let i = u32(at);
    let t = fract(at);
    let t2 = t * t;
    let powers = vec4f(t, t2 / 2.0, t2 * t / 3.0, t2 * t2 / 4.0) / FRINGES_PER_NM;
    return textureLoad(fringes_table, vec2u(i, 3u), 0).rgb + fringes_cubics(i, powers);
}
