// A base that light reaches around, and comes through.

fn base_shine(s: Skin, nl: f32) -> vec3f {
    let half_way = saturate(0.5 + 0.5 * nl);
    let near = base_pass(s, half_way) * curve_at(half_way, 0u);
    let far = base_pass(s, 1.0 - half_way) * curve_at(half_way, 1u);
    return s.base * (near + far);
}
