// Rectangles that shine, each as so many small lights, each of which has a shadow map. Layouts are those of lamps.rs.

struct Rectangle {
    // Along its sides, and z which way it shines.
    x: vec3f,
    // Its first small light, and how many it has.
    first: u32,
    y: vec3f,
    count: u32,
    z: vec3f,
    // What the angle of a small light adds to alpha^2, as the lobe is spread by it.
    spread: f32,
    center: vec3f,
    // Size of a texel of a shadow map, in scene units at distance 1.
    texel: f32,
    // Radiance times area of each small light.
    light: vec3f,
    // Shadow maps across at distance 1.
    scale: f32,
    // Depth in shadow maps is x + y/distance.
    depth: vec2f,
    // Sides of the part of it that a small light stands for.
    cell: vec2f,
}

struct Rectangles {
    rectangles: array<Rectangle, 32>,
    // Small lights: their place on the rectangle, and the middle of the shadow map.
    places: array<vec4f, 128>,
}

@group(0) @binding(6) var<uniform> rectangles: Rectangles;
@group(0) @binding(7) var rectangle_maps: texture_depth_2d_array;

fn rectangle_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes) -> vec3f {
    var sum = vec3f(0.0);
    let side = f32(textureDimensions(rectangle_maps).x);
    for (var i = 0u; i < frame.rectangles; i++) {
        let r = rectangles.rectangles[i];
        let axes = mat3x3f(r.x, r.y, r.z);
        // All in the rectangle's own axes: the place, the facet, and the shading frame.
        let p = (position - r.center) * axes;
        if p.z <= 0.0 {
            continue;
        }
        let leaning = facet * axes;
        let start = p + leaning * (SHADOW_LIFT * r.texel * p.z);
        let to_shading = transpose(a) * axes;
        // Behind all that casts shadows a map is 1.
        let depth = min(r.depth.x + r.depth.y / start.z, 1.0);
        var g = Gathered();
        for (var j = r.first + frame.first_place; j < r.first + r.count; j += frame.place_step) {
            let place = rectangles.places[j];
            // Shadows are those of the middle of its part.
            let to = vec3f(place.xy + r.cell * frame.place_shift - p.xy, -p.z);
            if dot(leaning, to) > 0.0 {
                let at = (start.xy - place.xy) / start.z * vec2f(r.scale, -r.scale) + place.zw;
                // Nothing casts a shadow to outside of the map.
                let within = all(at > vec2f(0.0)) && all(at < vec2f(1.0));
                let nearest = textureLoad(rectangle_maps, vec2u(saturate(at) * side * 0.99999), j, 0);
                let over = inverseSqrt(dot(to, to));
                let share = p.z * over * over * over;
                gather(&g, skin, to_shading * (to * over), r.spread, share, !within || depth <= nearest);
            }
        }
        // The rectangle hides what is behind it, also where it is not seen itself: the environment shines through objects.
        let behind = sky_behind(normalize(r.center - position)) * (r.cell.x * r.cell.y);
        sum += gathered(g, skin, r.light, behind) * f32(frame.place_step);
    }
    return sum;
}
