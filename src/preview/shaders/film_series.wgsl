// The colour that a film reflects: the series of `optics::film_color`, whose terms are the mean transmittance A times powers
// of q, for s and p together, and the transform of the colour weights at multiples of the path difference.

override FILM_ORDER: u32 = 3u;

fn film_reflect(film: Film, cosine: f32) -> vec3f {
    let n = material.indices;
    if film.thickness_nm <= 0.0 {
        return vec3f(fresnel(n.x, n.z, cosine));
    }
    let c = n.x * usable_cosine(cosine);
    let zz = select(admittance_squared(n.x, n.z, c), c * c, n.x == n.z);
    if c == 0.0 || zz <= 0.0 {
        return vec3f(1.0);
    }
    let yy = admittance_squared(n.x, n.y, c);
    if yy <= 0.0 {
        return film_beyond(film, c, yy, zz);
    }
    let y = sqrt(yy);
    // s and p; those of p times n1^2, so that y serves both.
    let x = c * vec2f(1.0, (n.y / n.x) * (n.y / n.x));
    let z = sqrt(zz) * vec2f(1.0, (n.y / n.z) * (n.y / n.z));
    let xy = x - y;
    let yz = y - z;
    let over = 1.0 / ((x + z) * (x * z + yy));
    let q = -(xy * yz) / ((x + y) * (y + z));
    var term = 4.0 * x * y * z * over;
    let mean = (x * yz * yz + z * xy * xy) * over;
    var rgb = vec3f(0.5 * (mean.x + mean.y));
    let middle = 2.0 * y * film.thickness_nm;
    let width = 2.0 * y * film.spread_nm;
    for (var k = 1u; k <= FILM_ORDER; k++) {
        term *= q;
        rgb -= (term.x + term.y) * fringes(f32(k) * middle, f32(k) * width);
    }
    return saturate(rgb);
}
