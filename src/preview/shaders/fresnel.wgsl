// A plain interface in admittances: `optics::fresnel`.

// Square of the s-admittance n cos in a medium of index n, from that in n0; negative beyond the critical angle.
fn admittance_squared(n0: f32, n: f32, x: f32) -> f32 {
    return (n - n0) * (n + n0) + x * x;
}

// In [0, 1], and not so small that squares underflow.
fn usable_cosine(cosine: f32) -> f32 {
    let c = saturate(cosine);
    return select(0.0, max(c, 1e-9), c > 0.0);
}

// Part of unpolarised light that an interface from n0 to n1 reflects.
fn fresnel(n0: f32, n1: f32, cosine: f32) -> f32 {
    if n0 == n1 {
        return 0.0;
    }
    let x = n0 * usable_cosine(cosine);
    let yy = admittance_squared(n0, n1, x);
    if yy <= 0.0 {
        return 1.0;
    }
    // s and p.
    let a = x * vec2f(1.0, 1.0 / (n0 * n0));
    let b = sqrt(yy) * vec2f(1.0, 1.0 / (n1 * n1));
    let r = (a - b) / (a + b);
    return 0.5 * dot(r, r);
}
