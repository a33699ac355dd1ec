// The gloss by directions of its lobe, each with what the film reflects of it: what the split sum stands for.

// In a sample.
override SKY_DIRECTIONS: u32 = 64u;
// Width of the part of the lobe that each stands for, as a share of the lobe's own: each sees the sky as that blurs it, so that
// none of it lies between them (Krivanek & Colbert, GPU Gems 3, ch. 20).
override SKY_PART: f32 = 0.125;

fn sky_gloss(skin: Skin, facet: vec3f, a: Axes, clear: f32) -> vec3f {
    let alpha = skin_alpha(skin);
    var sum = vec3f(0.0);
    for (var i = 0u; i < SKY_DIRECTIONS; i++) {
        let h = visible_facet(alpha, skin.wo, even_point(frame.sample * SKY_DIRECTIONS + i));
        let wi = reflect(-skin.wo, h);
        let towards = a * wi;
        if wi.z > 0.0 && dot(towards, facet) > 0.0 {
            let reflected = film_reflect(skin.film, dot(skin.wo, h));
            sum += sky_blurred(towards, SKY_PART * alpha) * reflected * facet_lit(skin.alpha_2, wi.z, skin.wo.z);
        }
    }
    return sum * (clear / f32(SKY_DIRECTIONS));
}
