// A pixel of an object: light from lamps and from all around.

// Most radiance that the target holds.
const BRIGHTEST = 60000.0;

@fragment
fn shade(v: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let found = look_up(v.uv);
    let to_eye = normalize(frame.eye - v.position);
    let across = cross(dpdx(v.position), dpdy(v.position));
    let facet_2 = dot(across, across);
    let facing = select(-across, across, dot(across, to_eye) > 0.0) * inverseSqrt(max(facet_2, 1e-30));
    let facet = select(to_eye, facing, facet_2 > 1e-30);
    let a = shading_axes(v, facet, front, found.bump, to_eye);
    let skin = skin_view(found.point, to_eye * a);
    let lamps = sun_light(skin, v.position, facet, a) + rectangle_light(skin, v.position, facet, a, v.clip.xy);
    let light = lamps + sky_light(skin, opening(v.clip.xy, facet), facet, a);
    // What lamps hide of the environment may be more than is left of it, by rounding.
    return vec4f(clamp(light, vec3f(0.0), vec3f(BRIGHTEST)), 1.0);
}
