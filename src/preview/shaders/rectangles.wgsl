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

// How many there are, at least 1. The first is apart from the rest: drivers on a CPU read a block fast where the index is a
// constant.
override RECTANGLES: u32 = 1u;

// `pixel` is its place in the picture.
fn rectangle_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes, pixel: vec2f) -> vec3f {
    var sum = one_rectangle(rectangles.rectangles[0], 0u, skin, position, facet, a, pixel);
    for (var i = 1u; i < RECTANGLES; i++) {
        sum += one_rectangle(rectangles.rectangles[i], rectangles.rectangles[i].first, skin, position, facet, a, pixel);
    }
    return sum;
}

// 1 where small light `j`, at `place`, is seen from `start`, whose depth in its shadow map is `depth`.
fn place_reaches(r: Rectangle, j: u32, place: vec4f, start: vec3f, depth: f32) -> f32 {
    let at = (start.xy - place.xy) / start.z * vec2f(r.scale, -r.scale) + place.zw;
    let side = f32(textureDimensions(rectangle_maps).x);
    let nearest = textureLoad(rectangle_maps, vec2u(saturate(at) * side * 0.99999), j, 0);
    // Nothing casts a shadow to outside of the map.
    let within = all(at > vec2f(0.0)) && all(at < vec2f(1.0));
    return select(0.0, 1.0, !within || depth <= nearest);
}
