// An equirectangular picture: `scene::EnvironmentImage`.

@group(1) @binding(1) var picture: texture_2d<f32>;
@group(1) @binding(2) var picture_sampler: sampler;

const PI = 3.14159265;

fn surroundings(direction: vec3f) -> vec3f {
    let around = atan2(direction.x, -direction.z) / (2.0 * PI);
    let down = acos(clamp(direction.y, -1.0, 1.0)) / PI;
    return textureSampleLevel(picture, picture_sampler, vec2f(0.5 + around, down), 0.0).rgb;
}
