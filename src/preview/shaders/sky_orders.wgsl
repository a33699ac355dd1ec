// What a grating sends of the sky: of each order of each wavelength what the lobe sees around its own direction, times what the
// film reflects there.

// Orders with less are taken as if they were straight.
const LEAST_SHARE = 0.002;

fn sky_gloss(skin: Skin, facet: vec3f, a: Axes, clear: f32) -> vec3f {
    let last = textureDimensions(order_nodes).x - 1u;
    let ridges = textureLoad(order_nodes, vec2u(last, 0u), 0);
    let wo = along_ridges(skin.wo, ridges.xy);
    let alpha = skin_alpha(skin);
    let lobe = lobe_nodes(sqrt(alpha), skin.wo.z);
    let white = dot(lobe.weights, vec3f(1.0));
    let n0 = material.indices.x;
    // By what of the light is straight, and by the orders.
    var straight = vec3f(0.0);
    var sum = vec3f(0.0);
    for (var k = 0u; k < last; k++) {
        let node = textureLoad(order_nodes, vec2u(k, 0u), 0);
        let place = textureLoad(order_nodes, vec2u(k, 1u), 0);
        let chain = chain_of(wo, place.x, ridges.z);
        var left = 0.0;
        for (var m = -chain.above; m <= chain.below; m++) {
            let share = order_share(chain, m, place.y, ridges.z);
            if m == 0 || share <= LEAST_SHARE {
                left += share;
            } else {
                let x = f32(m) * place.x - wo.x;
                let z = sqrt(max(1.0 - x * x - wo.y * wo.y, 0.0));
                let wi = vec3f(x * ridges.xy + vec2f(ridges.y, -ridges.x) * wo.y, z);
                let cosine = usable_cosine(dot(skin.wo, half_way(skin, wi)));
                let power = white * film_power(skin.film, n0 * cosine, node.x);
                let towards = a * wi;
                let over = min(lobe_above(towards, facet, alpha), clear);
                sum += node.yzw * (share * power * over) * sky_blurred(towards, alpha);
            }
        }
        let cosines = n0 * lobe.cosines;
        let powers = vec3f(
            film_power(skin.film, cosines.x, node.x),
            film_power(skin.film, cosines.y, node.x),
            film_power(skin.film, cosines.z, node.x),
        );
        straight += node.yzw * (left * dot(lobe.weights, powers));
    }
    let mirrored = reflect(-(a * skin.wo), a[2]);
    let over = min(lobe_above(mirrored, facet, alpha), clear);
    return max(straight * sky_blurred(mirrored, alpha) * over + sum, vec3f(0.0));
}
