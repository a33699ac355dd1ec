// The colour that a dispersive film reflects: Airy's sum at each of some wavelengths, with the indices that film and layer have
// there, as `optics::layered` has it.

// Wavelength, nm, and its weights in red, green and blue.
@group(1) @binding(4) var wavelengths: texture_2d<f32>;

fn film_reflect(film: Film, cosine: f32) -> vec3f {
    let x = material.indices.x * usable_cosine(cosine);
    var rgb = vec3f(0.0);
    for (var i = 0u; i < textureDimensions(wavelengths).x; i++) {
        let node = textureLoad(wavelengths, vec2u(i, 0u), 0);
        rgb += film_power(film, x, node.x) * node.yzw;
    }
    return saturate(rgb);
}
