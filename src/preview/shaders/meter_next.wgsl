// A further step of a light meter.

fn measured(at: vec2i) -> vec2f {
    return textureLoad(source, at, 0).rg;
}
