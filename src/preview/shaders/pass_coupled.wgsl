// What gets through a rough film is what its microfacets do not reflect: `optics::layered::Energy::Coupled`.

fn film_pass(s: Skin, cosine: f32) -> vec3f {
    return 1.0 - lobe_reflect(s.film, s.roughness, cosine);
}
