// No film: the layer's own surface.

fn film_reflect(film: Film, cosine: f32) -> vec3f {
    return vec3f(fresnel(material.indices.x, material.indices.z, cosine));
}
