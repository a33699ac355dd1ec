//! From a hit to what shading needs: place, normals, and the maps' values there.

use glam::{Vec2, Vec3, Vec4};

use super::bvh::Hit;
use super::film::Pixel;
use crate::scene::{Material, Mesh, Object, Scene, Texel};

/// What a path finds where it meets an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) position: Vec3,
    /// Unit normal of the triangle, on the side that the ray came from.
    pub(super) normal: Vec3,
    /// Index of the material.
    pub(super) material: usize,
    /// Values of the maps, or the material's constants.
    pub(super) texel: Texel,
    /// Shading frame: z is the shading normal, x the tangent of u.
    pub(super) frame: Frame,
}

/// Three unit vectors, square to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    /// With this z (a unit vector), and x as near to `tangent` as can be.
    #[inline(always)]
    fn new(z: Vec3, tangent: Vec3, sign: f32) -> Self {
        let x = tangent - z * z.dot(tangent);
        let length = x.length_squared();
        // A tangent along the normal says nothing: any other will do (Duff et al. 2017).
        let x = if length > 1e-12 { x / length.sqrt() } else { z.any_orthonormal_vector() };
        Self { x, y: z.cross(x) * sign, z }
    }

    #[inline(always)]
    pub(super) fn to_local(self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    #[inline(always)]
    pub(super) fn to_world(self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// A vertex, all in one place of memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Vertex {
    position: Vec3,
    normal: Vec3,
    tangent: Vec4,
    uv: Vec2,
}

/// The vertices of an object.
pub(super) fn vertices(mesh: &Mesh) -> Vec<Vertex> {
    let lists = mesh.positions.iter().zip(&mesh.normals).zip(mesh.tangents.iter().zip(&mesh.uvs));
    lists.map(|((&position, &normal), (&tangent, &uv))| Vertex { position, normal, tangent, uv }).collect()
}

impl Point {
    /// What a ray along `direction` finds at a hit; `bumps` is whether normal maps count.
    #[inline(always)]
    pub(super) fn new(
        scene: &Scene,
        vertices: &[Vec<Vertex>],
        hit: &Hit,
        direction: Vec3,
        bumps: bool,
    ) -> Self {
        let vertices = &vertices[hit.place.object as usize];
        let Object { mesh, material, .. } = &scene.objects[hit.place.object as usize];
        let [a, b, c] = hit.weights;
        let [p, q, r] = mesh.triangles[hit.place.triangle as usize].map(|i| vertices[i as usize]);
        let mix = |f: fn(&Vertex) -> Vec3| f(&p) * a + f(&q) * b + f(&r) * c;
        // From the corners, not along the ray: the rounding of a long ray would lift it off.
        let position = mix(|v| v.position);
        // Inside of a closed body, and the back of a sheet, look like the front.
        let side = if hit.normal.dot(direction) <= 0.0 { 1.0 } else { -1.0 };
        let normal = hit.normal * side;
        let smooth = (mix(|v| v.normal) * side).normalize_or(normal);
        let tangent = mix(|v| v.tangent.truncate());
        let sign = p.tangent.w * side;
        let texel = match &scene.materials[*material] {
            Material { maps: Some(maps), .. } => {
                let uv = p.uv * a + q.uv * b + r.uv * c;
                maps.sample(uv.x, uv.y)
            }
            Material { color, roughness, thickness_nm, .. } => {
                let (color, normal) = (color.0, [0.0, 0.0, 1.0]);
                Texel { color, roughness: *roughness, normal, thickness_nm: *thickness_nm }
            }
        };
        let mut frame = Frame::new(smooth, tangent, sign);
        let [x, y, _] = texel.normal;
        if bumps && (x != 0.0 || y != 0.0) {
            let bumped = frame.to_world(Vec3::from_array(texel.normal)).normalize_or(smooth);
            frame = Frame::new(bumped, frame.x, sign);
        }
        // A shading normal that looks away from the eye is turned until it just does not (no black rims).
        let cosine = frame.z.dot(-direction);
        if cosine < LEAST_COSINE {
            let turned = frame.z - direction * (LEAST_COSINE - cosine);
            frame = Frame::new(turned.normalize_or(normal), frame.x, sign);
        }
        Self { position, normal, material: *material, texel, frame }
    }

    /// Add it to a pixel as what was met first.
    #[inline(always)]
    pub(super) fn record(&self, pixel: &mut Pixel) {
        pixel.hits += 1;
        for c in 0..3 {
            pixel.albedo[c] += self.texel.color[c];
            pixel.normal[c] += self.frame.z[c];
        }
        pixel.thickness_nm += self.texel.thickness_nm;
    }
}

/// Least cosine between shading normal and eye.
const LEAST_COSINE: f32 = 1e-3;

/// Where a ray from a surface starts: off the surface by less than can be seen and more than rounding, on the side of
/// `direction` (Waechter & Binder 2019, Ray Tracing Gems, ch. 6).
#[inline(always)]
pub(super) fn lift(position: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    const ORIGIN: f32 = 1.0 / 32.0;
    const FLOAT_SCALE: f32 = 1.0 / 65_536.0;
    const INT_SCALE: f32 = 256.0;
    let normal = if normal.dot(direction) < 0.0 { -normal } else { normal };
    let step = |p: f32, n: f32| {
        if p.abs() < ORIGIN {
            return p + FLOAT_SCALE * n;
        }
        // So many steps of the last digit.
        let steps = (INT_SCALE * n) as i32;
        f32::from_bits((p.to_bits() as i32).wrapping_add(if p < 0.0 { -steps } else { steps }) as u32)
    };
    Vec3::new(step(position.x, normal.x), step(position.y, normal.y), step(position.z, normal.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_square_and_turns_back() {
        for (z, tangent) in
            [(Vec3::Y, Vec3::X), (Vec3::new(0.6, 0.0, 0.8), Vec3::new(1.0, 2.0, 3.0)), (Vec3::X, Vec3::X)]
        {
            let frame = Frame::new(z, tangent, -1.0);
            let v = Vec3::new(0.3, -0.5, 0.7);
            assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-6);
            assert!((frame.to_local(z) - Vec3::Z).length() < 1e-6);
            assert!((frame.x.cross(frame.y) + z).length() < 1e-6, "left-handed for a mirrored tile");
        }
    }

    #[test]
    fn rays_start_off_the_surface_on_the_side_they_go_to() {
        for position in [Vec3::ZERO, Vec3::new(1e-3, 5.0, -3e4)] {
            for side in [1.0, -1.0] {
                let start = lift(position, Vec3::Y, Vec3::new(0.5, side, 0.1));
                assert!((start.y - position.y) * side > 0.0, "{position} {side}");
                assert!((start - position).length() <= 1e-4 * position.abs().max_element().max(1.0));
            }
        }
    }
}
