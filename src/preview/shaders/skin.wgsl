// The skin at a point: gloss of the film over what comes from the base.
//
// Directions are unit vectors away from the surface in the frame of the shading normal, z along it. The formulas are those
// of `optics::layered`, with colours by the series of FILM_ORDER terms.

const PI = 3.14159265;
// Smoother is a mirror, which lights that are points are never seen in: `optics::layered::LEAST_ROUGHNESS`.
const LEAST_ROUGHNESS = 0.01;

struct SurfacePoint {
    albedo: vec3f,
    roughness: f32,
    // Thickness of the film, and how much it varies over the pixel.
    thickness_nm: f32,
    spread_nm: f32,
    // Of normals that vary over the pixel, 1 - the squared length of their mean.
    hidden: f32,
}

struct Film {
    thickness_nm: f32,
    spread_nm: f32,
}

// All that does not depend on the light.
struct Skin {
    wo: vec3f,
    roughness: f32,
    film: Film,
    hidden: f32,
    // Square of the width of the lobe, that of the normals included.
    alpha_2: f32,
    // What the base sends to the eye of light that has entered along a direction, per cosine.
    base: vec3f,
    // Part of even light that reaches the base.
    entering: vec3f,
}

// What a light's colour is multiplied with.
struct Tints {
    gloss: vec3f,
    base: vec3f,
}

// And by how much: a number, or of a grating three.
struct Lobes {
    gloss: Lobe,
    base: f32,
}

fn skin_view(p: SurfacePoint, wo: vec3f) -> Skin {
    var s: Skin;
    s.wo = wo;
    s.roughness = clamp(p.roughness, LEAST_ROUGHNESS, 1.0);
    s.film = Film(clamp(p.thickness_nm, 0.0, 1e9), max(p.spread_nm, 0.0));
    s.hidden = clamp(p.hidden, 0.0, 0.99);
    let alpha = s.roughness * s.roughness;
    // The variance of slopes, both axes together.
    s.alpha_2 = min(alpha * alpha + s.hidden / (1.0 - s.hidden), 1.0);
    if wo.z > 0.0 {
        base_view(&s, saturate(p.albedo));
    }
    return s;
}

// The BRDF without the cosine, 1/sr; 0 below the horizon, but for bases that wrap around.
fn skin_eval(s: Skin, wi: vec3f) -> vec3f {
    return skin_shine(s, wi) / max(abs(wi.z), 1e-7);
}

// The BRDF times the cosine, 1/sr: radiance to the eye per irradiance on a surface that faces the light.
fn skin_shine(s: Skin, wi: vec3f) -> vec3f {
    let tints = skin_tints(s, wi);
    let lobes = skin_lobes(s, wi, 0.0);
    return tints.gloss * lobes.gloss + tints.base * lobes.base;
}

// The same in two parts: colours, which are nearly the same over all of a light ...
fn skin_tints(s: Skin, wi: vec3f) -> Tints {
    return Tints(gloss_tint(s, wi), base_tint(s, wi.z));
}

// ... and numbers, which are not: of the gloss, whose alpha^2 grows by `spread`, and of the base.
fn skin_lobes(s: Skin, wi: vec3f, spread: f32) -> Lobes {
    if s.wo.z <= 0.0 {
        return Lobes();
    }
    return Lobes(gloss_lobe(s, wi, spread), base_lobe(s, wi.z));
}

// Radiance to the eye by light from all around: the base's by the irradiance over pi, and the gloss's.
fn skin_ambient(s: Skin, irradiance_over_pi: vec3f, gloss: vec3f) -> vec3f {
    if s.wo.z <= 0.0 {
        return vec3f(0.0);
    }
    return s.base * s.entering * PI * irradiance_over_pi + gloss;
}

// Width of the lobe: `optics::ggx::alpha`.
fn skin_alpha(s: Skin) -> f32 {
    return sqrt(s.alpha_2);
}
