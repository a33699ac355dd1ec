// A base that light reaches around, and comes through.

fn base_tint(s: Skin, nl: f32) -> vec3f {
    let around = saturate(0.5 + 0.5 * nl);
    let near = base_pass(s, around) * curve_at(around, 0u);
    let far = base_pass(s, 1.0 - around) * curve_at(around, 1u);
    return s.base * (near + far);
}

fn base_lobe(s: Skin, nl: f32) -> f32 {
    return 1.0;
}
