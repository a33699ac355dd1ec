// What the film reflects where ridges diffract: `optics::grating`, see orders.rs. Colours are another light's as soon as
// it is elsewhere, so that they are all in the lobe.

// For each wavelength a column (nm, weights in red, green, blue), (lambda/P, first row of its shares, step of lambda/P, 0); the
// last one has the direction across the ridges, and how many patches shares have along a side.
@group(1) @binding(6) var order_nodes: texture_2d<f32>;
// Shares that directions exchange: a row for each pair, in it patches of four corners.
@group(1) @binding(7) var order_shares: texture_2d<f32>;

alias Lobe = vec3f;

// What is less is left out, 1/sr, before the film's reflectance: tails of many orders.
const LEAST_LOBE = 1e-3;

fn gloss_tint(s: Skin, wi: vec3f) -> vec3f {
    return vec3f(1.0);
}

fn gloss_lobe(s: Skin, wi: vec3f, spread: f32) -> Lobe {
    if wi.z <= 0.0 || s.wo.z <= 0.0 {
        return vec3f(0.0);
    }
    let last = textureDimensions(order_nodes).x - 1u;
    let ridges = textureLoad(order_nodes, vec2u(last, 0u), 0);
    let a2 = min(s.alpha_2 + spread, 1.0);
    let scale = 4.0 / PI * a2 * ggx_visibility(a2, max(wi.z, 1e-7), max(s.wo.z, 1e-7)) * wi.z;
    let least = LEAST_LOBE / max(scale, 1e-30);
    let pair = Pair(along_ridges(wi, ridges.xy), along_ridges(s.wo, ridges.xy), a2, least);
    let x = material.indices.x * usable_cosine(dot(s.wo, half_way(s, wi)));
    var rgb = vec3f(0.0);
    for (var k = 0u; k < last; k++) {
        let node = textureLoad(order_nodes, vec2u(k, 0u), 0);
        let lobe = order_lobes(pair, textureLoad(order_nodes, vec2u(k, 1u), 0).xyz, ridges.z);
        if lobe > 0.0 {
            rgb += node.yzw * (lobe * film_power(s.film, x, node.x));
        }
    }
    return max(rgb, vec3f(0.0)) * scale;
}

// In axes across the ridges, along them, and up. Smaller cosines overflow.
fn along_ridges(w: vec3f, across: vec2f) -> vec3f {
    return vec3f(dot(w.xy, across), across.x * w.y - across.y * w.x, max(w.z, 1e-7));
}

struct Pair {
    wi: vec3f,
    wo: vec3f,
    alpha_2: f32,
    // Least part that matters.
    least: f32,
}

// All orders of a wavelength: sum_m min(e_m(wi), e_m(wo)) (v_m.wi) (v_m.wo)/(u^2 + c^2)^2, where u is `v_m` across the ridges,
// and c^2 all that is not. `place` is (lambda/P, first row of shares, step of lambda/P).
fn order_lobes(pair: Pair, place: vec3f, patches: f32) -> f32 {
    let shift = place.x;
    let q = pair.wi + pair.wo;
    // All in this length, and so not too great or small for f32.
    let over = inverseSqrt(q.y * q.y + q.z * q.z);
    let near_2 = (q.y * q.y + pair.alpha_2 * q.z * q.z) * over * over;
    let here = chain_of(pair.wi, shift, patches);
    let there = chain_of(pair.wo, shift, patches);
    var sum = 0.0;
    for (var m = -min(here.above, there.above); m <= min(here.below, there.below); m++) {
        let by = f32(m) * shift;
        // v.wi of unit vectors, where that of order 0 is half of its square.
        let cosines = 0.5 * dot(q, q) - by * vec2f(pair.wi.x, pair.wo.x);
        if all(cosines > vec2f(0.0)) {
            let facets = mean_facets((q.x - by) * over, near_2, abs(f32(m)) * place.z * over);
            let part = facets * (cosines.x * over * over) * (cosines.y * over * over);
            if part > pair.least {
                sum += part * min(order_share(here, m, place.y, patches), order_share(there, m, place.y, patches));
            }
        }
    }
    return sum;
}

// A direction among those that it exchanges light with: how many are below and above it along g, and for the first and the
// last of these the root of its steps to the horizon, in patches.
struct Chain {
    below: i32,
    above: i32,
    at: vec2f,
}

fn chain_of(w: vec3f, shift: f32, patches: f32) -> Chain {
    let radius = length(w.xz);
    let room = max(vec2f(radius - w.x, radius + w.x), vec2f(0.0)) / shift;
    let whole = floor(room);
    return Chain(i32(whole.y), i32(whole.x), sqrt(room - whole) * patches);
}

// e_m of it: order m leads m directions down.
fn order_share(c: Chain, m: i32, first: f32, patches: f32) -> f32 {
    let low = min(c.below, c.below - m);
    let high = max(c.below, c.below - m);
    let longest = c.below + c.above;
    // Of shorter chains, then pairs of the same one.
    let row = i32(first) + longest * (longest + 1) * (longest + 2) / 6 + high * (high + 1) / 2 + low;
    let cell = min(floor(c.at), vec2f(patches - 1.0));
    let t = c.at - cell;
    let corners = textureLoad(order_shares, vec2i(i32(cell.x + patches * cell.y), row), 0);
    let across = mix(corners.xz, corners.yw, t.x);
    return mix(across.x, across.y, t.y);
}

// Mean of 1/(u^2 + c^2)^2 under a tent of half width w, which is the way that `v_m` goes between two wavelengths.
fn mean_facets(u: f32, near_2: f32, w: f32) -> f32 {
    let over = 1.0 / (u * u + near_2);
    let part = w * w * over;
    if part < 0.02 {
        // So far away the second difference has no digits: Taylor's terms.
        return over * over * (1.0 + part * (2.0 * u * u * over - 1.0 / 3.0));
    }
    // |u| atan(u/c) is |u| pi/2 - c (1 - rest), of which the first part matters only under the tent's own tip.
    let c = sqrt(near_2);
    let r = atan_rest(abs(vec3f(u - w, u, u + w)) / c);
    let tip = PI * max(w - abs(u), 0.0);
    return max(tip + c * (r.x - 2.0 * r.y + r.z), 0.0) / (2.0 * near_2 * c * w * w);
}

// 1 - y atan(1/y), y >= 0, with as many digits where it is small: Gauss's continued fraction, right to 1e-5.
fn atan_rest(y: vec3f) -> vec3f {
    let far = y > vec3f(1.0);
    let t = select(y, 1.0 / max(y, vec3f(1.0)), far);
    let z = t * t;
    let b = 3.0 + 4.0 * z / (5.0 + 9.0 * z / (7.0 + 16.0 * z / (9.0 + 25.0 * z / (11.0 + 36.0 * z / 13.0))));
    return select(1.0 - y * (0.5 * PI - t * b / (b + z)), z / (b + z), far);
}
