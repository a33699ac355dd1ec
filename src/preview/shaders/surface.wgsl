// From vertices to what shading needs at a pixel: place, facet and shading frame, as the reference has them.

// Texels of shadow maps that a place is lifted off its surface for the test, along the facet; 0 for what is in no map, as
// its shadows would be that much too small.
override SHADOW_LIFT: f32 = 1.5;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
}

struct Varying {
    @invariant @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec2f,
}

@vertex
fn place(v: Vertex) -> Varying {
    return Varying(frame.clip * vec4f(v.position, 1.0), v.position, v.normal, v.tangent, v.uv);
}

// Columns are x along growing u, y, and z the shading normal.
alias Axes = mat3x3f;

// With this z, and x as near to `tangent` as can be.
fn axes(z: vec3f, tangent: vec3f, sign: f32) -> Axes {
    let along = tangent - z * dot(z, tangent);
    let length_2 = dot(along, along);
    // A tangent along the normal says nothing: any other will do.
    let other = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(z.x) > 0.5);
    let x = select(normalize(cross(other, z)), along * inverseSqrt(max(length_2, 1e-20)), length_2 > 1e-12);
    return Axes(x, cross(z, x) * sign, z);
}

// What of the environment a place sees: a direction in its middle, and the share of light that arrives, by the cosine.
struct Open {
    towards: vec3f,
    share: f32,
}

// The normal of the triangle that neighbouring pixels show, on the eye's side.
fn facet_of(position: vec3f, to_eye: vec3f) -> vec3f {
    let across = cross(dpdx(position), dpdy(position));
    let length_2 = dot(across, across);
    let facing = select(-across, across, dot(across, to_eye) > 0.0) * inverseSqrt(max(length_2, 1e-30));
    return select(normalize(to_eye), facing, length_2 > 1e-30);
}

// The normal of vertices: inside of a closed body, and the back of a sheet, look like the front.
fn outward(v: Varying, facet: vec3f, front: bool) -> vec3f {
    let length_2 = dot(v.normal, v.normal);
    let side = select(-1.0, 1.0, front);
    return select(facet, v.normal * (side * inverseSqrt(max(length_2, 1e-20))), length_2 > 1e-12);
}

// Their tangent, and the sign of the other axis on this side.
fn tangent_of(v: Varying, front: bool) -> vec4f {
    return vec4f(v.tangent.xyz, v.tangent.w * select(-1.0, 1.0, front));
}

// A pixel: its place in the picture, and 1 where its neighbour along x, along y shows the same surface.
struct Pixel {
    at: vec2f,
    same: vec2f,
}
