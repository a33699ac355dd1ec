// What is the same over a whole material. The layout is that of `MaterialUniform` in material.rs: a test compares them.

struct Material {
    // Refractive indices: outside, film, layer.
    indices: vec3f,
    // (n0/n2)^2.
    eta: f32,
    // Optical depth of the layer along the normal.
    absorption: vec3f,
    // 1 where albedos are the base's own, 0 where they are apparent.
    intrinsic: f32,
    // What becomes of light below the film, where its thickness is the same everywhere: see `Below`.
    clear: vec3f,
    // Columns of `below_rows` per nm of film.
    below_per_nm: f32,
    lost: vec3f,
    entering: vec3f,
}

@group(1) @binding(0) var<uniform> material: Material;
