// Maps are looked up where a ray of view meets the relief of the height map: parallax occlusion mapping (Tatarchuk 2006,
// Dynamic parallax occlusion mapping). The surface itself stays as it is, and so does its outline.

// Of the relief, in units of the scene: the lowest height over the surface, and the range above it.
@group(2) @binding(8) var<uniform> relief: vec4f;
// Height, from the lowest to the highest.
@group(2) @binding(9) var relief_map: texture_2d<f32>;
@group(2) @binding(10) var relief_sampler: sampler;

// Heights at which the ray is compared with the ground.
override RELIEF_STEPS: f32 = 16.0;
// Seen at a smaller cosine, the relief is as at this one: rays would go on along the surface without end.
const LEAST_RELIEF_COSINE = 0.15;

fn relieved(v: Varying, normal: vec3f) -> vec2f {
    let x = dpdx(v.position);
    let y = dpdy(v.position);
    let uv_x = dpdx(v.uv);
    let uv_y = dpdy(v.uv);
    let size = vec2f(textureDimensions(relief_map));
    let texels_2 = max(dot(uv_x * size, uv_x * size), dot(uv_y * size, uv_y * size));
    let level = 0.5 * log2(clamp(texels_2, 1e-6, 1e9));
    // How far the ray goes along the surface while it rises by 1, in the triangle's own axes and then in those of maps.
    let to_eye = normalize(frame.eye - v.position);
    let cosine = dot(to_eye, normal);
    let along = (to_eye - cosine * normal) / max(cosine, LEAST_RELIEF_COSINE);
    let facet = cross(x, y);
    let scale = 1.0 / max(dot(facet, facet), 1e-30);
    let drift = (uv_x * dot(cross(along, y), facet) + uv_y * dot(cross(x, along), facet)) * scale;
    // Down from the highest, until the ray is in the ground.
    let step = relief.y / RELIEF_STEPS;
    var height = relief.x + relief.y;
    var before = 0.0;
    for (var i = 0.0; i <= RELIEF_STEPS; i += 1.0) {
        let ground = relief.x + relief.y * textureSampleLevel(relief_map, relief_sampler, v.uv + drift * height, level).r;
        let above = height - ground;
        if above <= 0.0 {
            // Between this height and the one before, on a straight line.
            height += select(0.0, step * above / (above - before), before > 0.0);
            break;
        }
        before = above;
        height -= step;
    }
    return v.uv + drift * max(height, relief.x);
}
