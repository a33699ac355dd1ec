// Each small light of a rectangle by its own lobe and shadow.

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
    if p.z <= 0.0 {
        return vec3f(0.0);
    }
    let leaning = facet * axes;
    let start = p + leaning * (SHADOW_LIFT * r.texel * p.z);
    let to_shading = transpose(a) * axes;
    // Behind all that casts shadows a map is 1.
    let depth = min(r.depth.x + r.depth.y / start.z, 1.0);
    let scale = vec2f(r.scale, -r.scale) / start.z;
    var g = Gathered();
    for (var j = first + frame.first_place; j < first + r.count; j += frame.place_step) {
        let place = rectangles.places[j];
        // Shadows are those of the middle of its part.
        let to = vec3f(place_now(r, place.xy) - p.xy, -p.z);
        if dot(leaning, to) > 0.0 {
            let over = inverseSqrt(dot(to, to));
            let at = (start.xy - place.xy) * scale + place.zw;
            let reached = place_reaches(j, at, depth);
            let share = p.z * over * over * over;
            gather(&g, skin, to_shading * (to * over), r.spread, share, reached);
        }
    }
    // The rectangle hides what is behind it, also where it is not seen itself: the environment shines through objects.
    let behind = sky_behind(normalize(r.center - position)) * (r.cell.x * r.cell.y);
    return gathered(g, skin, r.light, behind) * f32(frame.place_step);
}
