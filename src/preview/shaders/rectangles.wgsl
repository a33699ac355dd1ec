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
    // What is in the middle of all shadow maps: its place at distance 1, and one over its distance.
    pivot: vec2f,
    over: f32,
    padding: f32,
    // Sixteen small lights are at the first one's place and, for each bit of the index, a step: of bits 0 and 1, of 2 and 3.
    corner: vec2f,
    // Half of its sides.
    half_sides: vec2f,
    low_steps: vec4f,
    high_steps: vec4f,
}

struct Rectangles {
    rectangles: array<Rectangle, 32>,
    // Small lights: their place on the rectangle, and the middle of the shadow map.
    places: array<vec4f, 128>,
}

@group(0) @binding(6) var<uniform> rectangles: Rectangles;
@group(0) @binding(7) var rectangle_maps: texture_depth_2d_array;

// How many there are, at least 1. The first is apart from the rest, as FIRST_RECTANGLE: drivers on a CPU take long to read a block.
override RECTANGLES: u32 = 1u;

fn rectangle_light(skin: Skin, position: vec3f, facet: vec3f, a: Axes, pixel: Pixel) -> vec3f {
    var sum = one_rectangle(FIRST_RECTANGLE, 0u, skin, position, facet, a, pixel);
    for (var i = 1u; i < RECTANGLES; i++) {
        sum += one_rectangle(rectangles.rectangles[i], rectangles.rectangles[i].first, skin, position, facet, a, pixel);
    }
    return sum;
}

// Where a small light is in this sample: elsewhere in its own part of the rectangle.
fn place_now(r: Rectangle, place: vec2f) -> vec2f {
    let at = (place + r.half_sides) / r.cell;
    return (floor(at) + fract(at + frame.place_shift)) * r.cell - r.half_sides;
}

// 1 where small light `j` is seen from what is at `at` in its shadow map, at `depth`.
fn place_reaches(j: u32, at: vec2f, depth: f32) -> f32 {
    let side = f32(textureDimensions(rectangle_maps).x);
    let nearest = textureLoad(rectangle_maps, vec2u(saturate(at) * side * 0.99999), j, 0);
    // Nothing casts a shadow to outside of the map.
    let within = all(at > vec2f(0.0)) && all(at < vec2f(1.0));
    return select(0.0, 1.0, !within || depth <= nearest);
}
