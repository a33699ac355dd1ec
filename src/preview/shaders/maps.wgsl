// The maps of a skin: albedo and roughness; slope of the normal, thickness of the film, and what the mean normal lacks.

// Of a film, nm: from the thinnest to the thickest, the thickest, the thinnest; and one of nothing.
@group(2) @binding(0) var<uniform> map_scale: vec4f;
@group(2) @binding(1) var color_map: texture_2d<f32>;
@group(2) @binding(2) var form_map: texture_2d<f32>;
@group(2) @binding(3) var map_sampler: sampler;

struct Found {
    point: SurfacePoint,
    bump: vec3f,
}

// `level` is that of the maps which a pixel covers, where `map_at` asks for it.
fn look_up(uv: vec2f, level: f32) -> Found {
    let color = color_of(map_at(color_map, map_sampler, uv, level));
    let form = form_of(map_at(form_map, map_sampler, uv, level));
    let bump = vec3f(form.xy, sqrt(max(1.0 - dot(form.xy, form.xy), 0.0)));
    let point = SurfacePoint(color.rgb, color.a, map_scale.z + form.z * map_scale.x, film_width(uv, level) * map_scale.x, form.w);
    return Found(point, bump);
}

// Axes around the normal that a map has there.
fn bumped(a: Axes, bump: vec3f, sign: f32) -> Axes {
    return axes(normalize(a * bump), a[0], sign);
}
