// Beyond the critical angle of a film that is less dense than what is outside: the wave in it decays, and what gets through is
// a matter of its thickness. `optics::thin_film`, at few wavelengths, as nothing oscillates.

// Wavelength, nm, and its weights in red, green and blue.
@group(1) @binding(4) var wavelengths: texture_2d<f32>;

// Squares of the s-admittances in film, not above 0, and layer; x is that outside.
fn film_beyond(film: Film, x: f32, yy: f32, zz: f32) -> vec3f {
    let n = material.indices;
    let y = sqrt(-yy);
    // s and p.
    let a = x * vec2f(1.0, (n.y / n.x) * (n.y / n.x));
    let c = sqrt(zz) * vec2f(1.0, (n.y / n.z) * (n.y / n.z));
    let apart = (a - c) * (a - c);
    let sum = (a + c) * (a + c);
    let less = (a * c - yy) * (a * c - yy);
    let more = (a * c + yy) * (a * c + yy);
    var rgb = vec3f(0.0);
    for (var i = 0u; i < textureDimensions(wavelengths).x; i++) {
        let node = textureLoad(wavelengths, vec2u(i, 0u), 0);
        let k = 2.0 * PI * film.thickness_nm / node.x;
        // Above 20 it is 1, and drivers may overflow.
        let decayed = select(k, tanh(min(k * y, 20.0)) / y, y > 0.0);
        let ss = decayed * decayed;
        let r = min((apart + less * ss) / (sum + more * ss), vec2f(1.0));
        rgb += 0.5 * (r.x + r.y) * node.yzw;
    }
    return saturate(rgb);
}
