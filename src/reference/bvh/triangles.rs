//! Triangles, four at a time.

use std::ops::{Add, Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8};
use glam::{Vec3, Vec3A};
use obvhs::triangle::Triangle;

use super::TOGETHER;
use super::tree::Ray;

/// Triangles of a leaf.
pub(super) const LANES: usize = 4;

/// Up to four triangles. Lanes that are left over have no area, and are never met.
#[derive(Clone, Debug)]
#[repr(C, align(16))]
pub(super) struct Leaf {
    /// The first corner: x, y, z.
    corner: [[f32; LANES]; 3],
    /// The first corner less the second.
    back: [[f32; LANES]; 3],
    /// The third corner less the first.
    along: [[f32; LANES]; 3],
}

impl Leaf {
    pub(super) fn new(triangles: [Option<&Triangle>; LANES]) -> Self {
        let lanes = |f: fn(&Triangle) -> Vec3A| {
            let of = triangles.map(|t| t.map_or([0.0; 3], |t| f(t).to_array()));
            std::array::from_fn(|c| of.map(|v| v[c]))
        };
        Self { corner: lanes(|t| t.v0), back: lanes(|t| t.v0 - t.v1), along: lanes(|t| t.v2 - t.v0) }
    }

    /// How far along the ray each triangle is met; infinity where it is not (Moeller & Trumbore 1997).
    #[inline(always)]
    pub(super) fn intersect<S: Simd>(&self, simd: S, ray: &Ray) -> f32x4<S> {
        let back: [f32x4<S>; 3] = load(simd, &self.back);
        let along = load(simd, &self.along);
        let [x, y, z]: [f32x4<S>; 3] = load(simd, &self.corner);
        let to = [x - ray.origin[0], y - ray.origin[1], z - ray.origin[2]];
        let [x, y, z] = ray.direction;
        let direction = [f32x4::splat(simd, x), f32x4::splat(simd, y), f32x4::splat(simd, z)];
        let normal = cross(back, along);
        let turned = cross(direction, to);
        let inverse = f32x4::splat(simd, 1.0) / dot(normal, direction);
        let u = dot(turned, along) * inverse;
        let v = dot(turned, back) * inverse;
        let w = f32x4::splat(simd, 1.0) - u - v;
        let t = dot(normal, to) * inverse;
        let zero = f32x4::splat(simd, 0.0);
        // Without an area all is NaN, and not met.
        let met = u.simd_ge(zero) & v.simd_ge(zero) & w.simd_ge(zero) & t.simd_ge(zero);
        met.select(t, f32x4::splat(simd, f32::INFINITY))
    }

    /// How far along each of several rays from one point a triangle is met, infinity where it is not, and the weights of its
    /// second and third corner: what [`Leaf::intersect`] and [`Leaf::weights`] say of each, to the bit.
    #[inline(always)]
    pub(super) fn intersect_all<S: Simd>(
        &self,
        simd: S,
        triangle: usize,
        origin: [f32; 3],
        directions: &[[f32; TOGETHER]; 3],
    ) -> [f32x8<S>; 3] {
        let lane = |v: &[[f32; LANES]; 3]| v.map(|c| c[triangle]);
        let splat = |v: [f32; 3]| {
            let [x, y, z] = v;
            [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)]
        };
        let (back, along, [x, y, z]) = (lane(&self.back), lane(&self.along), lane(&self.corner));
        let to = [x - origin[0], y - origin[1], z - origin[2]];
        let normal = cross(back, along);
        let ahead = dot(normal, to);
        let (back, along, to, normal) = (splat(back), splat(along), splat(to), splat(normal));
        let direction = load(simd, directions);
        let turned = cross(direction, to);
        let inverse = f32x8::splat(simd, 1.0) / dot(normal, direction);
        let u = dot(turned, along) * inverse;
        let v = dot(turned, back) * inverse;
        let w = f32x8::splat(simd, 1.0) - u - v;
        let t = inverse * ahead;
        let zero = f32x8::splat(simd, 0.0);
        let met = u.simd_ge(zero) & v.simd_ge(zero) & w.simd_ge(zero) & t.simd_ge(zero);
        [met.select(t, f32x8::splat(simd, f32::INFINITY)), u, v]
    }

    /// Weights of the second and third corner where the ray meets a triangle.
    #[inline(always)]
    pub(super) fn weights(&self, lane: usize, ray: &Ray) -> [f32; 2] {
        let lane = |v: &[[f32; LANES]; 3]| v.map(|c| c[lane]);
        let (back, along, corner) = (lane(&self.back), lane(&self.along), lane(&self.corner));
        let to = std::array::from_fn(|c| corner[c] - ray.origin[c]);
        let turned = cross(ray.direction, to);
        let inverse = 1.0 / dot(cross(back, along), ray.direction);
        [dot(turned, along) * inverse, dot(turned, back) * inverse]
    }

    /// Unit normal of a triangle.
    #[inline(always)]
    pub(super) fn normal(&self, lane: usize) -> Vec3 {
        let lane = |v: &[[f32; LANES]; 3]| v.map(|c| c[lane]);
        -Vec3::from_array(cross(lane(&self.back), lane(&self.along))).normalize_or_zero()
    }
}

/// A vector in each lane.
#[inline(always)]
fn load<S: Simd, V: SimdFrom<[f32; N], S>, const N: usize>(simd: S, [x, y, z]: &[[f32; N]; 3]) -> [V; 3] {
    [V::simd_from(simd, *x), V::simd_from(simd, *y), V::simd_from(simd, *z)]
}

#[inline(always)]
fn dot<T: Copy + Add<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<T: Copy + Sub<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
