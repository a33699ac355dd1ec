// A matt base.

fn base_shine(s: Skin, nl: f32) -> vec3f {
    if nl <= 0.0 {
        return vec3f(0.0);
    }
    return s.base * base_pass(s, nl) * nl;
}
