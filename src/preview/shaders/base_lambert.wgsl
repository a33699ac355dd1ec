// A matt base.

fn base_tint(s: Skin, nl: f32) -> vec3f {
    return s.base * base_pass(s, base_lobe(s, nl));
}

fn base_lobe(s: Skin, nl: f32) -> f32 {
    return mean_cosine(s.hidden, nl);
}
