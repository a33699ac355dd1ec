// The colour that a film reflects, by a table: see film_table.rs.

@group(2) @binding(4) var film_table: texture_2d_array<f32>;
@group(2) @binding(5) var film_sampler: sampler;

// Columns and rows, the last layer, and the width of the second one, nm.
const FILM_SIZE = vec2f(64.0, 512.0);
const FILM_LAST = 11.0;
const FILM_WIDTH_NM = 16.0;

fn film_reflect(film: Film, cosine: f32) -> vec3f {
    let at = vec2f(sqrt(saturate(cosine)), saturate(film.thickness_nm / map_scale.y));
    let uv = (at * (FILM_SIZE - 1.0) + 0.5) / FILM_SIZE;
    // Widths double from layer to next but one, but for the first, which is none. The nearest will do: measured, a mean
    // CIEDE2000 of 0.02 from blending layers twice as far apart, which takes a tenth of the picture's time more.
    let width = film.spread_nm / FILM_WIDTH_NM;
    let layer = min(select(1.0 + 2.0 * log2(max(width, 1.0)), width, width < 1.0), FILM_LAST);
    return textureSampleLevel(film_table, film_sampler, uv, u32(layer + 0.5), 0.0).rgb;
}
