// A layer that absorbs nothing.

fn layer_pass(cosine: f32) -> vec3f {
    return vec3f(1.0);
}
