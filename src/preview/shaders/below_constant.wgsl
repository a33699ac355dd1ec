// What becomes of diffuse light below a film of the same thickness everywhere.

fn below_film(film: Film, roughness: f32) -> Below {
    return Below(material.clear, material.lost, material.entering);
}
