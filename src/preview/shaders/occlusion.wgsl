// Which part of the environment each pixel's surface sees, by the depths of the picture: in planes through the eye's ray (Jimenez,
// Wu, Pesce & Jarabo, Practical Real-Time Strategies for Accurate Indirect Occlusion, 2016), which sectors things of some
// thickness hide (Therrien, Levesque & Gilet, Screen Space Indirect Lighting with Visibility Bitmask, 2023). What is off the picture, or behind what it shows,
// hides nothing, but for a floor, below which there is no light.

// Planes through the eye's ray in which horizons are sought, and places that are looked at on either side.
override SLICES: u32 = 2u;
override STEPS: u32 = 8u;
// Whether everything stands on a floor without end, whose normal is y.
override FLOOR: bool = false;

const PI = 3.14159265;
// Half a sector.
const HALF = PI / 64.0;
// Of a whole one.
const COSINE = 0.99518473;
const SINE = 0.09801714;
// How far is looked, in heights of the picture.
const REACH = 1.0;
// How far things go on behind what is seen of them, in body diameters.
const THICKNESS = 1.0;

@group(1) @binding(0) var depths: texture_depth_2d;
@group(1) @binding(1) var normals: texture_2d<f32>;

// What a pixel shows: its place from the eye, and its depth, 0 where there is nothing.
fn seen(at: vec2i) -> vec4f {
    let size = vec2f(textureDimensions(depths));
    let depth = textureLoad(depths, at, 0);
    let across = (vec2f(at) + 0.5) / size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    let ray = frame.forward + frame.right * across.x + frame.up * across.y;
    return vec4f(ray * (frame.clip[3].z / max(depth, 1e-20)), depth);
}

// Of light from all around by the cosine what arrives, and after it from where on average.
@fragment
fn search(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let at = vec2i(clip.xy);
    let here = seen(at);
    let size = vec2i(textureDimensions(depths));
    let distance_2 = dot(here.xyz, here.xyz);
    let to_eye = -here.xyz * inverseSqrt(max(distance_2, 1e-30));
    let faced = textureLoad(normals, at, 0).xyz;
    // What is smoothed may look away from the eye.
    let toward = faced + to_eye * max(1e-3 - dot(faced, to_eye), 0.0);
    let normal = select(to_eye, normalize(toward), dot(faced, faced) > 0.5);
    if here.w <= 0.0 {
        return vec4f(to_eye, 1.0);
    }
    // Sixteen neighbours look into other directions, at other distances.
    let cell = at & vec2i(3);
    // Pictures that are averaged are turned apart, as evenly as can be at any number (the golden ratio).
    let turn = fract(0.618034 * f32(frame.sample));
    let around = fract(f32(((cell.x + cell.y) & 3) * 4 + cell.x) / 16.0 + turn);
    let jitter = fract(f32((cell.y - cell.x) & 3) / 4.0 + 0.125 + turn * 7.0);
    let right = normalize(frame.right);
    let up = normalize(frame.up);
    let reach = REACH * f32(size.y);
    // Of light that would arrive what does not: planes differ in what would.
    var missing = 0.0;
    var mean = vec3f(0.0);
    for (var k = 0u; k < SLICES; k++) {
        let angle = PI * (f32(k) + around) / f32(SLICES);
        let towards = vec2f(cos(angle), sin(angle));
        let lateral = right * towards.x + up * towards.y;
        let sideways = normalize(lateral - to_eye * dot(lateral, to_eye));
        // The normal within the plane, and its angle from the eye's ray.
        let flat = vec2f(dot(normal, sideways), dot(normal, to_eye));
        let n = sign(flat.x) * arc_cosine(flat.y / max(length(flat), 1e-9));
        let plane = Plane(to_eye, 0.5 * PI - n, jitter);
        var hidden = 0u;
        if FLOOR && to_eye.y > 0.0 {
            let level = sideways.y / length(vec2f(sideways.y, to_eye.y));
            hidden = sectors(plane, arc_cosine(-level), PI) | sectors(plane, -PI, -arc_cosine(level));
        }
        for (var i = 0u; i < STEPS; i++) {
            let s = (f32(i) + jitter) / f32(STEPS);
            let offset = vec2i(round(towards * vec2f(1.0, -1.0) * (1.0 + reach * s * s)));
            let after = angles(plane, here, at + offset, size);
            let before = angles(plane, here, at - offset, size);
            hidden |= sectors(plane, after.x, after.y) | sectors(plane, -before.y, -before.x);
        }
        // Cosine and sine of the middle of the first sector, from the eye's ray and from the edge of the hemisphere.
        var direction = vec2f(sin(n + HALF), -cos(n + HALF));
        var edge = vec2f(cos(HALF), sin(HALF));
        for (var i = 0u; i < 32u; i++) {
            let weight = length(flat) * edge.y * abs(direction.y);
            let is_hidden = (hidden >> i & 1u) == 1u;
            missing += select(0.0, weight, is_hidden);
            mean += select(weight, 0.0, is_hidden) * (direction.y * sideways + direction.x * to_eye);
            direction = turned(direction);
            edge = turned(edge);
        }
    }
    let length_2 = dot(mean, mean);
    let bent = select(normal, mean * inverseSqrt(max(length_2, 1e-30)), length_2 > 1e-12);
    return vec4f(bent, 1.0 - missing * 2.0 * HALF / f32(SLICES));
}

// A plane through the eye's ray, half of which is divided into 32 sectors around the surface's normal.
struct Plane {
    to_eye: vec3f,
    // From the first sector's edge to the eye's ray.
    start: f32,
    // Where between two sectors an edge counts.
    jitter: f32,
}

// Angles from the eye's ray between which what a pixel shows hides the environment; none if it shows nothing.
fn angles(plane: Plane, here: vec4f, at: vec2i, size: vec2i) -> vec2f {
    let there = seen(clamp(at, vec2i(0), size - 1));
    let front = there.xyz - here.xyz;
    let back = front + there.xyz * (THICKNESS * inverseSqrt(max(dot(there.xyz, there.xyz), 1e-30)));
    let cosines = vec2f(dot(front, plane.to_eye), dot(back, plane.to_eye))
        * inverseSqrt(max(vec2f(dot(front, front), dot(back, back)), vec2f(1e-30)));
    let found = there.w > 0.0 && all(at >= vec2i(0)) && all(at < size);
    return select(vec2f(PI), vec2f(arc_cosine(cosines.x), arc_cosine(cosines.y)), found);
}

// Those between two angles, a bit each.
fn sectors(plane: Plane, from_angle: f32, to_angle: f32) -> u32 {
    let edges = saturate((vec2f(from_angle, to_angle) + plane.start) / PI) * 32.0 + plane.jitter;
    let low = u32(edges.x);
    let count = max(u32(edges.y), low) - low;
    // 32 bits do not shift by 32.
    let bits = select((1u << min(count, 31u)) - 1u, 0xffffffffu, count > 31u);
    return select(bits << min(low, 31u), 0u, low > 31u);
}

// Cosine and sine of an angle, and of one that is a sector larger.
fn turned(direction: vec2f) -> vec2f {
    return direction * COSINE + vec2f(-direction.y, direction.x) * SINE;
}

// Off by 7e-5 at most (Abramowitz & Stegun 4.4.45), where drivers take long.
fn arc_cosine(x: f32) -> f32 {
    let a = min(abs(x), 1.0);
    let y = sqrt(1.0 - a) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - a * 0.0187293)));
    return select(y, PI - y, x < 0.0);
}
