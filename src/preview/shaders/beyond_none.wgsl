// No angle is beyond the critical one of the film.

fn film_beyond(film: Film, x: f32, yy: f32, zz: f32) -> vec3f {
    return vec3f(1.0);
}
