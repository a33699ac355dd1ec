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

// Least cosine between shading normal and eye.
const LEAST_COSINE = 1e-3;

// The shading frame: inside of a closed body, and the back of a sheet, look like the front; a normal that looks away from
// the eye is turned until it just does not.
fn shading_axes(v: Varying, facet: vec3f, front: bool, bump: vec3f, to_eye: vec3f) -> Axes {
    let side = select(-1.0, 1.0, front);
    let length_2 = dot(v.normal, v.normal);
    let smoothed = select(facet, v.normal * (side * inverseSqrt(max(length_2, 1e-20))), length_2 > 1e-12);
    let sign = v.tangent.w * side;
    var a = axes(smoothed, v.tangent.xyz, sign);
    a = axes(normalize(a * bump), a[0], sign);
    let cosine = dot(a[2], to_eye);
    if cosine < LEAST_COSINE {
        a = axes(normalize(a[2] + to_eye * (LEAST_COSINE - cosine)), a[0], sign);
    }
    return a;
}
