// A rectangle by a few of its small lights, and by a few directions of the gloss's lobe that may meet it: in each sample others.
// Lights alone leave gaps in narrow lobes, and directions alone seldom meet a small rectangle. Each counts by how likely both
// find its direction (the balance heuristic; Veach 1997, 9.2.2).

// Directions in a sample.
const LOBE_DIRECTIONS = 4u;

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
    if p.z <= 0.0 || skin.wo.z <= 0.0 {
        return vec3f(0.0);
    }
    let leaning = facet * axes;
    let start = p + leaning * (SHADOW_LIFT * r.texel * p.z);
    let to_shading = transpose(a) * axes;
    // Behind all that casts shadows a map is 1.
    let depth = min(r.depth.x + r.depth.y / start.z, 1.0);
    let scale = vec2f(r.scale, -r.scale) / start.z;
    let begin = first + frame.first_place;
    // The rectangle hides what is behind it, also where it is not seen itself: the environment shines through objects.
    let behind = sky_behind(normalize(r.center - position));
    let light = r.light / (r.cell.x * r.cell.y);
    // Solid angle that a small light of this sample stands for, over its share.
    let per_light = r.cell.x * r.cell.y * f32(frame.place_step);
    var sum = vec3f(0.0);
    for (var j = begin; j < first + r.count; j += frame.place_step) {
        let place = rectangles.places[j];
        // Shadows are those of the middle of its part.
        let to = vec3f(place_now(r, place.xy) - p.xy, -p.z);
        if dot(leaning, to) > 0.0 {
            let over = inverseSqrt(dot(to, to));
            let wi = to_shading * (to * over);
            let angle = p.z * over * over * over * per_light;
            let tints = skin_tints(skin, wi);
            let lobes = skin_lobes(skin, wi, 0.0);
            let directions = f32(LOBE_DIRECTIONS) * mirrored_density(skin.alpha_2, half_way(skin, wi), skin.wo.z);
            let gloss = tints.gloss * (lobes.gloss / (1.0 + directions * angle));
            let seen = place_reaches(j, (start.xy - place.xy) * scale + place.zw, depth);
            sum += (gloss + tints.base * lobes.base) * (light * seen - behind) * angle;
        }
    }
    for (var i = 0u; i < LOBE_DIRECTIONS; i++) {
        let h = visible_facet(skin_alpha(skin), skin.wo, even_point(frame.sample * LOBE_DIRECTIONS + i));
        let wi = reflect(-skin.wo, h);
        let d = wi * to_shading;
        let t = p.z / max(-d.z, 1e-7);
        let at = p.xy + d.xy * t;
        let within = all(abs(at) < r.half_sides);
        if wi.z > 0.0 && d.z < 0.0 && within && dot(leaning, d) > 0.0 {
            // By the shadow of the nearest of this sample's small lights.
            var nearest = begin;
            var distance_2 = 1e30;
            for (var j = begin; j < first + r.count; j += frame.place_step) {
                let apart = rectangles.places[j].xy - at;
                if dot(apart, apart) < distance_2 {
                    distance_2 = dot(apart, apart);
                    nearest = j;
                }
            }
            let place = rectangles.places[nearest];
            let seen = place_reaches(nearest, (start.xy - place.xy) * scale + place.zw, depth);
            let directions = f32(LOBE_DIRECTIONS) * mirrored_density(skin.alpha_2, h, skin.wo.z);
            let angle = -d.z / (t * t) * per_light;
            // One over the density of both.
            let weight = angle * directions / (1.0 + directions * angle) / f32(LOBE_DIRECTIONS);
            let gloss = film_reflect(skin.film, dot(skin.wo, h)) * facet_lit(skin.alpha_2, wi.z, skin.wo.z);
            sum += gloss * weight * (light * seen - behind);
        }
    }
    return sum;
}
