// Sixteen small lights of a rectangle as four quarters, each by one lobe. Four neighbouring pixels of a triangle share shadows:
// each looks up one light of a quarter, another than its neighbours'.

// What the quarters of a rectangle add up to: those that are seen, and those that face the place.
struct Quarters {
    // Directions by how much light comes from them, in the shading frame.
    seen: vec3f,
    all: vec3f,
    // Lobes of gloss.
    gloss_seen: Lobe,
    gloss_all: Lobe,
}

fn one_rectangle(
    r: Rectangle,
    first: u32,
    skin: Skin,
    position: vec3f,
    facet: vec3f,
    a: Axes,
    pixel: Pixel,
) -> vec3f {
    let axes = mat3x3f(r.x, r.y, r.z);
    // All in the rectangle's own axes: the place, the facet, and the shading frame.
    let p = (position - r.center) * axes;
    let before = p.z > 0.0;
    let q = vec3f(p.xy, max(p.z, 1e-6));
    let leaning = facet * axes;
    let start = q + leaning * (SHADOW_LIFT * r.texel * q.z);
    // Behind all that casts shadows a map is 1.
    let depth = min(r.depth.x + r.depth.y / start.z, 1.0);
    let odd = vec2u(pixel.at) & vec2u(1u);
    // Places in shadow maps, of whose middles `pivot` is one, are that of the middle of the rectangle and a share of how far
    // the small light is from it. Bits of a light's index are (right, pixel, pixel, up), see `hammersley`.
    let scale = vec2f(r.scale, -r.scale);
    let over = 1.0 / start.z;
    let share = scale * (r.over - over);
    let first_place = r.corner + r.low_steps.zw * f32(odd.x) + r.high_steps.xy * f32(odd.y);
    let low = 0.5 + (start.xy * over - r.pivot) * scale + first_place * share;
    let up = r.low_steps.xy * share;
    let right = r.high_steps.zw * share;
    let j = first + 2u * odd.x + 4u * odd.y;
    var seen = vec4f(
        place_reaches(j, low, depth),
        place_reaches(j + 1u, low + up, depth),
        place_reaches(j + 8u, low + right, depth),
        place_reaches(j + 9u, low + right + up, depth),
    );
    // The mean of four pixels: what one has and what its neighbour has over it.
    let side = (vec2f(0.5) - vec2f(odd)) * pixel.same;
    seen += dpdxFine(seen) * side.x;
    seen += dpdyFine(seen) * side.y;
    if !before {
        return vec3f(0.0);
    }

    let to_shading = transpose(a) * axes;
    var g = Quarters();
    quarter(&g, r, skin, q, leaning, to_shading, vec2f(-1.0, -1.0), seen.x);
    quarter(&g, r, skin, q, leaning, to_shading, vec2f(-1.0, 1.0), seen.y);
    quarter(&g, r, skin, q, leaning, to_shading, vec2f(1.0, -1.0), seen.z);
    quarter(&g, r, skin, q, leaning, to_shading, vec2f(1.0, 1.0), seen.w);
    // All in one colour: that of the middle of what is seen of it; where nothing is seen, of all.
    let middle = g.seen + 1e-3 * g.all;
    let wi = middle * inverseSqrt(max(dot(middle, middle), 1e-30));
    let tints = skin_tints(skin, wi);
    let lobe = base_lobe(skin, wi.z);
    // The rectangle hides what is behind it, also where it is not seen itself: the environment shines through objects.
    let behind = sky_behind(normalize(r.center - position)) * (r.cell.x * r.cell.y);
    return tints.gloss * (r.light * g.gloss_seen - behind * g.gloss_all)
        + tints.base * (lobe * (r.light * length(g.seen) - behind * length(g.all)));
}

// `toward` tells which one, and `seen` how much of it is.
fn quarter(
    g: ptr<function, Quarters>,
    r: Rectangle,
    skin: Skin,
    p: vec3f,
    leaning: vec3f,
    to_shading: mat3x3f,
    toward: vec2f,
    seen: f32,
) {
    let to = vec3f(toward * r.cell - p.xy, -p.z);
    let over = inverseSqrt(dot(to, to));
    let share = select(0.0, 4.0 * p.z * over * over * over, dot(leaning, to) > 0.0);
    let wi = to_shading * (to * over);
    let gloss = gloss_lobe(skin, wi, 4.0 * r.spread) * share;
    (*g).seen += wi * (share * seen);
    (*g).all += wi * share;
    (*g).gloss_seen += gloss * seen;
    (*g).gloss_all += gloss;
}
