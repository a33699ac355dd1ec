//! Which triangle a ray meets first, over all objects of a scene.
//!
//! The crate `obvhs` sorts the triangles into a binary tree; [`tree`] widens it to eight boxes a node and [`triangles`]
//! packs four triangles a leaf, so that one node and one leaf are each one vector's work. No operation of
//! these lanes rounds otherwise than the same on numbers, so every instruction set gives the same.

mod tree;
mod triangles;

use fearless_simd::Simd;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use self::tree::{Beam, Link, Ray, Tree};
use self::triangles::{LANES, Leaf};
use crate::scene::{Mesh, Object};

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
        self.hit(&ray, nearest)
    }

    /// [`Bvh::first_hit`] of several rays: of those from one point in the fewer steps, the less they spread.
    #[inline(always)]
    pub(super) fn first_hits<S: Simd, const N: usize>(
        &self,
        simd: S,
        stack: &mut Stack,
        origins: &[Vec3; N],
        directions: &[Vec3; N],
    ) -> [Option<Hit>; N] {
        let mut hits = [None; N];
        let mut rays = [Ray::new(Vec3::ZERO, Vec3::Z); N];
        for i in 0..N {
            rays[i] = Ray::new(origins[i], directions[i]);
        }
        let Some(beam) = Beam::new(&rays) else {
            for i in 0..N {
                hits[i] = self.first_hit(simd, stack, origins[i], directions[i], f32::INFINITY);
            }
            return hits;
        };
        let mut nearest = [Nearest { limit: f32::INFINITY, lane: None }; N];
        // Of the ray that sees the farthest.
        let mut limit = f32::INFINITY;
        stack.used = 0;
        let mut next = self.tree.root();
        while let Some(link) = next {
            next = match link.leaf() {
                None => self.tree.nodes[link.node()].visit_beam(simd, &beam, limit, stack),
                Some(index) => {
                    limit = 0.0;
                    for i in 0..N {
                        self.meet(simd, index, &rays[i], &mut nearest[i]);
                        limit = limit.max(nearest[i].limit);
                    }
                    None
                }
            };
            next = next.or_else(|| stack.pop_within(limit));
        }
        for i in 0..N {
            hits[i] = self.hit(&rays[i], nearest[i]);
        }
        hits
    }

    /// Note what a ray meets in a leaf.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, index: usize, ray: &Ray, nearest: &mut Nearest) {
        let distances = self.leaves[index].intersect(simd, ray);
        for (lane, &t) in distances.iter().enumerate() {
            let id = index * LANES + lane;
            // Misses are infinite.
            let first = |best: Option<usize>| best.is_none_or(|b| self.places[id] < self.places[b]);
            if t < nearest.limit || (t == nearest.limit && t < f32::INFINITY && first(nearest.lane)) {
                *nearest = Nearest { limit: t, lane: Some(id) };
            }
        }
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, Nearest { limit, lane }: Nearest) -> Option<Hit> {
        let id = lane?;
        let (weights, normal) = self.leaves[id / LANES].look(id % LANES, ray);
        Some(Hit { distance: limit, place: self.places[id], weights, normal })
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
                    if distances.iter().any(|t| *t <= limit && *t < f32::INFINITY) {
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
