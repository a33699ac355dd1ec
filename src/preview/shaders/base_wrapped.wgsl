// A base that light reaches around.

fn base_shine(s: Skin, nl: f32) -> vec3f {
    let half_way = saturate(0.5 + 0.5 * nl);
    return s.base * base_pass(s, half_way) * curve_at(half_way, 0u);
}
