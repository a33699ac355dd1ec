//! Which triangle a ray meets first, over all objects of a scene.
//!
//! The crate `obvhs` sorts the triangles into a binary tree; [`tree`] widens it to eight boxes a node and [`triangles`]
//! packs four triangles a leaf, so that one node and one leaf are each one vector's work. No operation of
//! these lanes rounds otherwise than the same on numbers, so every instruction set gives the same.

mod tree;
mod triangles;

use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8, u32x8};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use self::tree::{Beam, Link, Ray, Tree};
use self::triangles::{LANES, Leaf};
use crate::scene::{Mesh, Object};

/// Rays that are followed together: the lanes of a vector.
pub(super) const TOGETHER: usize = 8;

/// The triangles of a scene, sorted for rays.
pub(super) struct Bvh {
    tree: Tree,
    leaves: Vec<Leaf>,
    /// Object and triangle of each lane of the leaves.
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

impl Place {
    /// Of lanes without a triangle.
    const NONE: Self = Self { object: u32::MAX, triangle: u32::MAX };
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

/// Room for the parts of a tree that a ray has yet to see: see [`Bvh::stack`]. One serves many rays.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// As many as there can be at once.
    entries: Box<[Entry]>,
    used: usize,
}

/// A part of the tree, and where the ray enters its box.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    near: f32,
    link: Link,
}

/// What a ray has met so far.
#[derive(Clone, Copy)]
struct Nearest {
    /// Distance, or how far the ray goes.
    limit: f32,
    /// Lane of the leaves, counted through.
    lane: Option<usize>,
}

/// What the rays of a beam have met so far.
struct Nearests<S: Simd> {
    /// Distances; infinite where nothing is met.
    limits: f32x8<S>,
    /// Lanes of the leaves, counted through; `u32::MAX` for none.
    ids: u32x8<S>,
    /// Of the second and the third corner.
    weights: [f32x8<S>; 2],
}

impl<S: Simd> Nearests<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self {
            limits: f32x8::splat(simd, f32::INFINITY),
            ids: u32x8::splat(simd, u32::MAX),
            weights: [f32x8::splat(simd, 0.0); 2],
        }
    }

    /// How far the ray sees that sees the farthest.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        let limits: [f32; TOGETHER] = self.limits.into();
        let mut most = limits[0];
        for limit in limits {
            most = most.max(limit);
        }
        most
    }
}

impl Stack {
    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        self.entries[self.used] = entry;
        self.used += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        self.used = self.used.checked_sub(1)?;
        Some(self.entries[self.used])
    }

    /// The next part that is not farther than `limit`.
    #[inline(always)]
    fn pop_within(&mut self, limit: f32) -> Option<Link> {
        loop {
            let entry = self.pop()?;
            if entry.near <= limit {
                return Some(entry.link);
            }
        }
    }
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
        if corners.is_empty() {
            return Self { tree: Tree::default(), leaves: Vec::new(), places };
        }
        let settings = BvhBuildParams { max_prims_per_leaf: LANES as u32, ..BvhBuildParams::slow_build() };
        let binary = build_bvh2_from_tris(&corners, settings, &mut Default::default());
        let (tree, order) = Tree::new(&binary);
        let leaf = |ids: &[u32; LANES]| Leaf::new(ids.map(|i| corners.get(i as usize)));
        let place = |&i: &u32| places.get(i as usize).copied().unwrap_or(Place::NONE);
        Self {
            leaves: order.iter().map(leaf).collect(),
            places: order.iter().flatten().map(place).collect(),
            tree,
        }
    }

    /// Room for its rays.
    pub(super) fn stack(&self) -> Stack {
        Stack { entries: vec![Entry::default(); self.tree.most_open()].into(), used: 0 }
    }

    /// The first triangle on the way, no farther than `limit`. Of two at one distance it is the one listed first, so that
    /// the order of the tree does not show.
    #[inline(always)]
    pub(super) fn first_hit<S: Simd>(
        &self,
        simd: S,
        stack: &mut Stack,
        origin: Vec3,
        direction: Vec3,
        limit: f32,
    ) -> Option<Hit> {
        let ray = Ray::new(origin, direction);
        let mut nearest = Nearest { limit, lane: None };
        stack.used = 0;
        let mut next = self.tree.root();
        while let Some(link) = next {
            next = match link.leaf() {
                None => self.tree.nodes[link.node()].visit(simd, &ray, nearest.limit, stack),
                Some(index) => {
                    self.meet(simd, index, &ray, &mut nearest);
                    None
                }
            };
            next = next.or_else(|| stack.pop_within(nearest.limit));
        }
        let id = nearest.lane?;
        Some(self.hit(id, nearest.limit, self.leaves[id / LANES].weights(id % LANES, &ray)))
    }

    /// [`Bvh::first_hit`] of several rays: of those from one point in the fewer steps, the less they spread.
    #[inline(always)]
    pub(super) fn first_hits<S: Simd>(
        &self,
        simd: S,
        stack: &mut Stack,
        origins: &[Vec3; TOGETHER],
        directions: &[Vec3; TOGETHER],
    ) -> [Option<Hit>; TOGETHER] {
        let mut hits = [None; TOGETHER];
        let mut rays = [Ray::new(Vec3::ZERO, Vec3::Z); TOGETHER];
        for i in 0..TOGETHER {
            rays[i] = Ray::new(origins[i], directions[i]);
        }
        let Some(beam) = Beam::new(&rays) else {
            for i in 0..TOGETHER {
                hits[i] = self.first_hit(simd, stack, origins[i], directions[i], f32::INFINITY);
            }
            return hits;
        };
        let mut nearest = Nearests::new(simd);
        // Of the ray that sees the farthest.
        let mut limit = f32::INFINITY;
        stack.used = 0;
        let mut next = self.tree.root();
        while let Some(link) = next {
            next = match link.leaf() {
                None => self.tree.nodes[link.node()].visit_beam(simd, &beam, limit, stack),
                Some(index) => {
                    self.meet_all(simd, index, &beam, &mut nearest);
                    limit = nearest.farthest();
                    None
                }
            };
            next = next.or_else(|| stack.pop_within(limit));
        }
        let (limits, [u, v]): ([f32; TOGETHER], [[f32; TOGETHER]; 2]) =
            (nearest.limits.into(), nearest.weights.map(Into::into));
        let ids: [u32; TOGETHER] = nearest.ids.into();
        for i in 0..TOGETHER {
            if ids[i] != u32::MAX {
                hits[i] = Some(self.hit(ids[i] as usize, limits[i], [u[i], v[i]]));
            }
        }
        hits
    }

    /// Note what the rays of a beam meet in a leaf.
    #[inline(always)]
    fn meet_all<S: Simd>(&self, simd: S, index: usize, beam: &Beam, nearest: &mut Nearests<S>) {
        for lane in 0..LANES {
            let id = index * LANES + lane;
            let [t, u, v] = self.leaves[index].intersect_all(simd, lane, beam.origin, &beam.directions);
            let nearer = t.simd_lt(nearest.limits);
            let level = t.simd_eq(nearest.limits) & t.simd_lt(f32x8::splat(simd, f32::INFINITY));
            let nearer = if level.any_true() {
                nearer | (level & self.listed_before(simd, id, nearest))
            } else {
                nearer
            };
            nearest.limits = nearer.select(t, nearest.limits);
            nearest.ids = nearer.select(u32x8::splat(simd, id as u32), nearest.ids);
            nearest.weights = [nearer.select(u, nearest.weights[0]), nearer.select(v, nearest.weights[1])];
        }
    }

    /// Whether a lane of the leaves is listed before what each ray has met.
    #[cold]
    #[inline(never)]
    fn listed_before<S: Simd>(
        &self,
        simd: S,
        id: usize,
        nearest: &Nearests<S>,
    ) -> <u32x8<S> as SimdBase<S>>::Mask {
        let mut first: [u32; TOGETHER] = nearest.ids.into();
        for best in &mut first {
            *best = u32::from(self.places.get(*best as usize).is_none_or(|best| self.places[id] < *best));
        }
        u32x8::simd_from(simd, first).simd_eq(u32x8::splat(simd, 1))
    }

    /// Note what a ray meets in a leaf.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, index: usize, ray: &Ray, nearest: &mut Nearest) {
        let distances = self.leaves[index].intersect(simd, ray);
        // Misses are infinite.
        let most = nearest.limit.min(f32::MAX);
        let mut met = distances.simd_le(f32x4::splat(simd, most)).to_bitmask();
        let distances: [f32; LANES] = distances.into();
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            let (id, t) = (index * LANES + lane, distances[lane]);
            let first = |best: Option<usize>| best.is_none_or(|b| self.places[id] < self.places[b]);
            if t < nearest.limit || (t == nearest.limit && first(nearest.lane)) {
                *nearest = Nearest { limit: t, lane: Some(id) };
            }
        }
    }

    /// A hit in a lane of the leaves.
    #[inline(always)]
    fn hit(&self, id: usize, distance: f32, [u, v]: [f32; 2]) -> Hit {
        let normal = self.leaves[id / LANES].normal(id % LANES);
        Hit { distance, place: self.places[id], weights: [1.0 - u - v, u, v], normal }
    }

    /// Whether anything is nearer than `limit`.
    #[inline(always)]
    pub(super) fn is_blocked<S: Simd>(
        &self,
        simd: S,
        stack: &mut Stack,
        origin: Vec3,
        direction: Vec3,
        limit: f32,
    ) -> bool {
        let ray = Ray::new(origin, direction);
        stack.used = 0;
        let mut next = self.tree.root();
        while let Some(link) = next {
            next = match link.leaf() {
                None => self.tree.nodes[link.node()].visit(simd, &ray, limit, stack),
                Some(index) => {
                    let distances = self.leaves[index].intersect(simd, &ray);
                    // Misses are infinite.
                    if distances.simd_le(f32x4::splat(simd, limit.min(f32::MAX))).any_true() {
                        return true;
                    }
                    None
                }
            };
            next = next.or_else(|| stack.pop().map(|entry| entry.link));
        }
        false
    }
}

fn positions(mesh: &Mesh, indices: [u32; 3]) -> [Vec3A; 3] {
    indices.map(|i| Vec3A::from(mesh.positions[i as usize]))
}

#[cfg(test)]
mod tests;
