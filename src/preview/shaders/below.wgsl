// What becomes of diffuse light below the film: `optics::layered::Below`.

struct Below {
    // Part that leaves in the end of what a white base sends up without absorption, and with it.
    clear: vec3f,
    lost: vec3f,
    // Part of even light from outside that reaches the base.
    entering: vec3f,
}
