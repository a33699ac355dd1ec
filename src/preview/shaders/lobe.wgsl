// What a rough film reflects of light that is even over its lobe: the lobe as three mirrors, see lobe.rs.

// For each roughness a row; for each step of the root of the view's cosine two texels (w1, s1, w2, s2) and (w3, s3, 0, 0):
// weights, and roots of cosines to facets.
@group(1) @binding(3) var lobe_table: texture_2d<f32>;

// Part of light at a cosine that the microfacets reflect.
fn lobe_reflect(film: Film, roughness: f32, cosine: f32) -> vec3f {
    let nodes = lobe_nodes(roughness, cosine);
    return nodes.weights.x * film_reflect(film, nodes.cosines.x)
        + nodes.weights.y * film_reflect(film, nodes.cosines.y)
        + nodes.weights.z * film_reflect(film, nodes.cosines.z);
}

// The mirrors.
struct LobeNodes {
    weights: vec3f,
    // To facets.
    cosines: vec3f,
}

fn lobe_nodes(roughness: f32, cosine: f32) -> LobeNodes {
    let last = textureDimensions(lobe_table) / vec2u(2u, 1u) - 1u;
    let at = vec2f(sqrt(saturate(cosine)), roughness) * vec2f(last);
    let i = min(vec2u(at), last - 1u);
    let t = at - vec2f(i);
    let one_two = lobe_entry(i, 0u, t);
    let three = lobe_entry(i, 1u, t);
    let roots = vec3f(one_two.yw, three.y);
    return LobeNodes(vec3f(one_two.xz, three.x), roots * roots);
}

fn lobe_entry(i: vec2u, part: u32, t: vec2f) -> vec4f {
    let at = vec2u(2u * i.x + part, i.y);
    let a = mix(textureLoad(lobe_table, at, 0), textureLoad(lobe_table, at + vec2u(2u, 0u), 0), t.x);
    let b = mix(textureLoad(lobe_table, at + vec2u(0u, 1u), 0), textureLoad(lobe_table, at + vec2u(2u, 1u), 0), t.x);
    return mix(a, b, t.y);
}
