// The first step of a light meter: logarithms of luminances, and how many there are. Black tells nothing.

fn measured(at: vec2i) -> vec2f {
    let luminance = dot(textureLoad(source, at, 0).rgb, vec3f(0.2126, 0.7152, 0.0722));
    return select(vec2f(0.0), vec2f(log2(max(luminance, 1e-38)), 1.0), luminance > 0.0);
}
