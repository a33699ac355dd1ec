// A plain surface: the same everywhere. The layout is that of `PlainUniform` in textures.rs.

struct Plain {
    albedo: vec3f,
    roughness: f32,
    // nm, and three of nothing.
    thickness: vec4f,
}

@group(2) @binding(0) var<uniform> plain: Plain;

struct Found {
    point: SurfacePoint,
    bump: vec3f,
}

fn look_up(uv: vec2f, level: f32) -> Found {
    let point = SurfacePoint(plain.albedo, plain.roughness, plain.thickness.x, 0.0, 0.0);
    return Found(point, vec3f(0.0, 0.0, 1.0));
}

fn bumped(a: Axes, bump: vec3f, sign: f32) -> Axes {
    return a;
}
