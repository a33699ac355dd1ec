// Each triangle is shaded where it is seen.

@fragment
fn shade(v: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let facet = facet_of(v.position, frame.eye - v.position);
    let pixel = Pixel(v.clip.xy, vec2f(1.0));
    let normal = outward(v, facet, front);
    return shaded(look_up(relieved(v, normal), 0.0), v.position, facet, normal, tangent_of(v, front), pixel);
}
