// What of the sky a grating mirrors to the eye: each order of each wavelength what is in its own direction. Colours of sky and
// grating are multiplied with the film's afterwards, as if none had fringes finer than red, green and blue.

// Orders with less are taken as if they were straight.
const LEAST_SHARE = 0.002;

fn sky_mirrored(skin: Skin, a: Axes, mirrored: vec3f, layer: f32) -> vec3f {
    let last = textureDimensions(order_nodes).x - 1u;
    let ridges = textureLoad(order_nodes, vec2u(last, 0u), 0);
    let wo = along_ridges(skin.wo, ridges.xy);
    // Of a bare mirror, and what the orders have of it in red, green and blue.
    var straight = vec3f(0.0);
    var sum = vec3f(0.0);
    for (var k = 0u; k < last; k++) {
        let weights = textureLoad(order_nodes, vec2u(k, 0u), 0).yzw;
        let place = textureLoad(order_nodes, vec2u(k, 1u), 0);
        let chain = chain_of(wo, place.x, ridges.z);
        for (var m = -chain.above; m <= chain.below; m++) {
            let share = order_share(chain, m, place.y, ridges.z);
            if m == 0 {
                straight += weights * share;
            } else if share > LEAST_SHARE {
                let x = f32(m) * place.x - wo.x;
                let z = sqrt(max(1.0 - x * x - wo.y * wo.y, 0.0));
                let w = vec3f(x * ridges.xy + vec2f(ridges.y, -ridges.x) * wo.y, z);
                sum += weights * share * sky_rough(a * w, layer);
            } else {
                straight += weights * share;
            }
        }
    }
    return max(straight * sky_rough(mirrored, layer) + sum, vec3f(0.0));
}
