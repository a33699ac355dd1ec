// What a film reflects of one wavelength: Airy's sum, with the indices that film and layer have there.

// Where the indices are those given, nm.
const SODIUM_NM = 589.3;

// Part of unpolarised light of a wavelength that is reflected; x is the s-admittance outside.
fn film_power(film: Film, x: f32, nm: f32) -> f32 {
    let apart = 1.0 / (nm * nm) - 1.0 / (SODIUM_NM * SODIUM_NM);
    let dispersion = vec2f(material.film_dispersion, material.layer_dispersion);
    let n0 = material.indices.x;
    let n = clamp(material.indices.yz + dispersion * apart, vec2f(0.1), vec2f(10.0));
    let zz = select(admittance_squared(n0, n.y, x), x * x, n0 == n.y);
    if x == 0.0 || zz <= 0.0 {
        return 1.0;
    }
    let yy = select(admittance_squared(n0, n.x, x), x * x, n0 == n.x);
    let y = sqrt(abs(yy));
    // s and p; those of p times n1^2, so that y serves both.
    let a = x * vec2f(1.0, (n.x / n0) * (n.x / n0));
    let c = sqrt(zz) * vec2f(1.0, (n.x / n.y) * (n.x / n.y));
    if yy <= 0.0 {
        // Beyond the critical angle: the wave in the film decays.
        let k = 2.0 * PI * film.thickness_nm / nm;
        // Above 20 it is 1, and drivers may overflow.
        let decayed = select(k, tanh(min(k * y, 20.0)) / y, y > 0.0);
        let part = decayed * decayed;
        let less = (a - c) * (a - c) + part * (a * c - yy) * (a * c - yy);
        let more = (a + c) * (a + c) + part * (a * c + yy) * (a * c + yy);
        let r = min(less / more, vec2f(1.0));
        return 0.5 * (r.x + r.y);
    }
    let ay = a - y;
    let yc = y - c;
    let over = 1.0 / ((a + c) * (a * c + yy));
    let mean = (a * yc * yc + c * ay * ay) * over;
    // All of the series of film_series.wgsl at once; where thickness varies within a pixel each term is the power of the first
    // one's mean, which is a little too little for the others.
    let around = min(PI * 2.0 * y * film.spread_nm / nm, 1e3);
    let spread = select(sin(around) / around, 1.0, around < 1e-3);
    let q = -(ay * yc) / ((a + y) * (y + c)) * spread;
    let wave = cos(2.0 * PI * fract(2.0 * y * film.thickness_nm / nm));
    let sum = q * (wave - q) / max(1.0 + q * (q - 2.0 * wave), vec2f(1e-9));
    return saturate(0.5 * (mean.x + mean.y) - dot(4.0 * a * y * c * over, sum));
}
