// Suns and rectangles, the latter as so many small lights, each with a shadow map. Layouts are those of lamps.rs.

struct Lamp {
    first: u32,
    count: u32,
    // What the angle of each small light adds to alpha^2, as the lobe is spread by it.
    spread: f32,
    padding: f32,
}

struct Sample {
    // Unit vector to a sun (w = 0), or a place on a rectangle (w = 1).
    at: vec4f,
    // Irradiance of a sun on a surface that faces it, or radiance times area.
    light: vec3f,
    // Size of a texel of the shadow map, in scene units: per unit of distance for a rectangle.
    texel: f32,
    // Which way a rectangle shines.
    normal: vec3f,
    padding: f32,
    // World to the shadow map.
    shadow: mat4x4f,
}

struct Lamps {
    lamps: array<Lamp, 32>,
    samples: array<Sample, 128>,
}

@group(0) @binding(1) var<uniform> lamps: Lamps;
@group(0) @binding(2) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(3) var shadow_sampler: sampler_comparison;

// Texels that a place is lifted off its surface for the test, along the facet.
const LIFT = 1.5;

fn lamp_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < frame.lamps; i++) {
        let lamp = lamps.lamps[i];
        // Its lobe alone is spread: the base is what it is.
        var spread = skin;
        let alpha = skin_alpha(skin);
        spread.roughness = sqrt(sqrt(min(alpha * alpha + lamp.spread, 1.0)));
        for (var j = lamp.first; j < lamp.first + lamp.count; j++) {
            let to = lamps.samples[j].at.xyz - position * lamps.samples[j].at.w;
            let distance_2 = dot(to, to);
            let distance = sqrt(distance_2);
            let direction = to / distance;
            var light = lamps.samples[j].light;
            var texel = lamps.samples[j].texel;
            if lamps.samples[j].at.w > 0.0 {
                light *= max(-dot(lamps.samples[j].normal, direction), 0.0) / distance_2;
                texel *= distance;
            }
            if dot(facet, direction) > 0.0 {
                let start = position + facet * (LIFT * texel);
                sum += skin_shine(spread, direction * a) * light * lit(j, start);
            }
        }
    }
    return sum;
}

// The share of a small light that reaches a place.
fn lit(sample: u32, position: vec3f) -> f32 {
    let p = lamps.samples[sample].shadow * vec4f(position, 1.0);
    let at = vec3f(0.5 + 0.5 * p.x / p.w, 0.5 - 0.5 * p.y / p.w, min(p.z / p.w, 1.0));
    // Nothing casts a shadow to outside of the map.
    if p.w <= 0.0 || any(at.xy <= vec2f(0.0)) || any(at.xy >= vec2f(1.0)) {
        return 1.0;
    }
    return textureSampleCompareLevel(shadow_maps, shadow_sampler, at.xy, sample, at.z);
}
