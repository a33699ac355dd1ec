// All pixels that show one material, by what gbuffer.wgsl recorded of them.

@group(3) @binding(0) var uvs: texture_2d<f32>;
@group(3) @binding(1) var normals: texture_2d<f32>;
@group(3) @binding(2) var tangents: texture_2d<f32>;
@group(3) @binding(3) var depths: texture_depth_2d;

struct Everywhere {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

// At the far end: where depth is greater, there is something.
@vertex
fn everywhere(@builtin(vertex_index) i: u32) -> Everywhere {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return Everywhere(vec4f(at, 0.0, 1.0), at);
}

// Distances apart by less, as a share of them, are of one surface.
const SAME = 0.01;
// A facet leans less than this from the normal of vertices, but where neighbours show something else.
const LEAST_FACET_COSINE = 0.8;

@fragment
fn shade(e: Everywhere) -> @location(0) vec4f {
    let here = vec2i(e.clip.xy);
    let depth = textureLoad(depths, here, 0);
    let ray = frame.forward + frame.right * e.at.x + frame.up * e.at.y;
    let to_place = ray * (frame.near / max(depth, 1e-30));
    let recorded = textureLoad(normals, here, 0);
    let normal = normalize(recorded.xyz);
    let found = facet_of(to_place, -to_place);
    let facet = select(normal, found, dot(found, normal) > LEAST_FACET_COSINE);
    let apart = vec2f(dpdxFine(depth), dpdyFine(depth));
    let pixel = Pixel(e.clip.xy, select(vec2f(0.0), vec2f(1.0), abs(apart) < vec2f(SAME * depth)));
    let maps = look_up(textureLoad(uvs, here, 0).xy, recorded.w);
    return shaded(maps, frame.eye + to_place, facet, normal, textureLoad(tangents, here, 0), pixel);
}
