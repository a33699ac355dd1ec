// What gets through a film that is taken as smooth: `optics::layered::Energy::Flat`.

fn film_pass(s: Skin, cosine: f32) -> vec3f {
    return 1.0 - film_reflect(s.film, cosine);
}
