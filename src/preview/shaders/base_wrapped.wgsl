// A base that light reaches around.

fn base_tint(s: Skin, nl: f32) -> vec3f {
    let around = saturate(0.5 + 0.5 * nl);
    return s.base * base_pass(s, around) * curve_at(around, 0u);
}

fn base_lobe(s: Skin, nl: f32) -> f32 {
    return 1.0;
}
