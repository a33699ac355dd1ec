//! Which triangle a ray meets first, over all objects of a scene. The tree is the crate `obvhs`'s: eight-wide, compressed.

// `traverse!` names UVec2.
use glam::{UVec2, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::Ray;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use crate::scene::{Mesh, Object};

/// The triangles of a scene, sorted for rays.
pub(super) struct Bvh {
    tree: CwBvh,
    /// In the order of the tree's leaves.
    triangles: Vec<RtTriangle>,
    /// Object and triangle of each.
    places: Vec<Place>,
}

/// A triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    /// Index of the object.
    pub(super) object: u32,
    /// Index of the triangle in its mesh.
    pub(super) triangle: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance along the ray, in lengths of its direction.
    pub(super) distance: f32,
    /// Which triangle.
    pub(super) place: Place,
    /// Weights of the corners.
    pub(super) weights: [f32; 3],
    /// Unit normal of the triangle, to the side that its corners are counter-clockwise from.
    pub(super) normal: Vec3,
}

impl Bvh {
    /// Sort the triangles of all objects.
    pub(super) fn new(objects: &[Object]) -> Self {
        let mut places = Vec::new();
        let mut corners = Vec::new();
        for (object, Object { mesh, .. }) in objects.iter().enumerate() {
            for (triangle, &indices) in mesh.triangles.iter().enumerate() {
                let [v0, v1, v2] = positions(mesh, indices);
                places.push(Place { object: object as u32, triangle: triangle as u32 });
                corners.push(Triangle { v0, v1, v2 });
            }
        }
        // An empty tree has no root to visit.
        let tree = if corners.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh_from_tris(&corners, BvhBuildParams::slow_build(), &mut Default::default())
        };
        let order = &tree.primitive_indices;
        Self {
            triangles: order.iter().map(|&i| RtTriangle::from(&corners[i as usize])).collect(),
            places: order.iter().map(|&i| places[i as usize]).collect(),
            tree,
        }
    }

    /// The first triangle on the way, no farther than `limit`. Of two at one distance it is the one listed first, so that
    /// the order of the tree does not show.
    #[inline(always)]
    pub(super) fn first_hit(&self, origin: Vec3, direction: Vec3, limit: f32) -> Option<Hit> {
        let mut ray = self.ray(origin, direction, limit)?;
        let mut state = self.tree.new_traversal(ray.direction);
        let mut best: Option<usize> = None;
        let mut node;
        // The macro rather than `ray_traverse`, so that this is compiled for the caller's instruction set.
        obvhs::traverse!(self.tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            let id = state.primitive_id as usize;
            let t = self.triangles[id].intersect(&ray);
            let nearer = |best: usize| t < ray.tmax || (t == ray.tmax && self.places[id] < self.places[best]);
            if t < f32::INFINITY && best.is_none_or(nearer) {
                best = Some(id);
                ray.tmax = t;
            }
        });
        let id = best?;
        let triangle = &self.triangles[id];
        let uv = triangle.compute_barycentric(&ray);
        Some(Hit {
            distance: ray.tmax,
            place: self.places[id],
            weights: [1.0 - uv.x - uv.y, uv.x, uv.y],
            normal: triangle.compute_normal().into(),
        })
    }

    /// Whether anything is nearer than `limit`.
    #[inline(always)]
    pub(super) fn is_blocked(&self, origin: Vec3, direction: Vec3, limit: f32) -> bool {
        let Some(ray) = self.ray(origin, direction, limit) else { return false };
        let mut state = self.tree.new_traversal(ray.direction);
        let mut blocked = false;
        let mut node;
        'search: {
            obvhs::traverse!(self.tree, node, state, node.intersect_ray(&ray, state.oct_inv4), {
                if self.triangles[state.primitive_id as usize].intersect(&ray) < f32::INFINITY {
                    blocked = true;
                    break 'search;
                }
            });
        }
        blocked
    }

    /// None where it misses everything for sure.
    #[inline(always)]
    fn ray(&self, origin: Vec3, direction: Vec3, limit: f32) -> Option<Ray> {
        if self.triangles.is_empty() {
            return None;
        }
        let ray = Ray::new(Vec3A::from(origin), Vec3A::from(direction), 0.0, limit);
        (self.tree.total_aabb.intersect_ray(&ray) < f32::INFINITY).then_some(ray)
    }
}

fn positions(mesh: &Mesh, indices: [u32; 3]) -> [Vec3A; 3] {
    indices.map(|i| Vec3A::from(mesh.positions[i as usize]))
}

#[cfg(test)]
mod tests;
