// What is the same over a whole material. The layout is that of `MaterialUniform` in material.rs: a test compares them.

struct Material {
    // Refractive indices: outside, film, layer.
    indices: vec3f,
    // Columns of `below_rows` per nm of film.
    below_per_nm: f32,
    // Optical depth of the layer along the normal.
    absorption: vec3f,
    // 1 where albedos are the base's own, 0 where they are apparent.
    intrinsic: f32,
    // What becomes of light below the film, where its thickness is the same everywhere: see `Below`.
    clear: vec3f,
    // Cauchy coefficients, nm^2, where indices are those at 589.3 nm.
    film_dispersion: f32,
    lost: vec3f,
    layer_dispersion: f32,
    entering: vec3f,
    // In red, green and blue: (n0/n2)^2, and n2.
    eta: vec3f,
    layer: vec3f,
}

@group(1) @binding(0) var<uniform> material: Material;
