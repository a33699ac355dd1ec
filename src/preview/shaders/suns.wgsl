// Light from far away: each sun has a shadow map. The layout is that of `Sun` in lamps.rs.

struct Sun {
    // Unit vector to it.
    direction: vec3f,
    // What its angle adds to alpha^2, as the lobe is spread by it.
    spread: f32,
    // On a surface that faces it.
    irradiance: vec3f,
    // Size of a texel of the shadow map, in scene units.
    texel: f32,
    // World to the shadow map.
    shadow: mat4x4f,
}

@group(0) @binding(1) var<uniform> suns: array<Sun, 32>;
@group(0) @binding(2) var sun_maps: texture_depth_2d_array;
@group(0) @binding(3) var sun_sampler: sampler_comparison;

// How many there are, at least 1. The first is apart from the rest, as FIRST_SUN: drivers on a CPU take long to read a block.
override SUNS: u32 = 1u;

fn sun_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes) -> vec3f {
    var sum = one_sun(FIRST_SUN, 0u, skin, position, facet, a);
    for (var i = 1u; i < SUNS; i++) {
        sum += one_sun(suns[i], i, skin, position, facet, a);
    }
    return sum;
}

fn one_sun(sun: Sun, i: u32, skin: Skin, position: vec3f, facet: vec3f, a: Axes) -> vec3f {
    let direction = sun.direction;
    if dot(facet, direction) > 0.0 {
        let reached = sun_reaches(sun, i, position + facet * (SHADOW_LIFT * sun.texel));
        if reached > 0.0 {
            let wi = direction * a;
            let tints = skin_tints(skin, wi);
            let lobes = skin_lobes(skin, wi, sun.spread);
            return (tints.gloss * lobes.gloss + tints.base * lobes.base) * (sun.irradiance * reached);
        }
    }
    return vec3f(0.0);
}

// The share of a sun's light that reaches a place.
fn sun_reaches(sun: Sun, i: u32, position: vec3f) -> f32 {
    let p = sun.shadow * vec4f(position, 1.0);
    let at = vec3f(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, min(p.z, 1.0));
    // Nothing casts a shadow to outside of the map.
    if any(at.xy <= vec2f(0.0)) || any(at.xy >= vec2f(1.0)) {
        return 1.0;
    }
    return textureSampleCompareLevel(sun_maps, sun_sampler, at.xy, i, at.z);
}
