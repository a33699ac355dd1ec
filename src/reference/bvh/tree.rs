//! A tree of boxes, eight to a node.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;
use glam::Vec3;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};

use super::triangles::LANES;
use super::{Entry, Stack, TOGETHER};

/// Boxes of a node.
const WIDTH: usize = 8;
/// Far sides are this much farther, so that rounding (three operations a side) loses no box: Ize 2013, "Robust BVH Ray
/// Traversal", theorem 2.
const ROUNDING: f32 = 1.0 + 4.0 * f32::EPSILON;
/// Directions this near to a side of a box are taken to be just so: 1/0 is infinite, and 0 times that no number.
const LEAST: f32 = 1e-24;

/// A ray, ready for boxes and triangles.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: [f32; 3],
    pub(super) direction: [f32; 3],
    /// 1/direction.
    inverse: [f32; 3],
    /// Which sides of a box it meets first and last, by axis: the high side first where it goes down.
    sides: [[usize; 3]; 2],
}

impl Ray {
    #[inline(always)]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let direction = direction.to_array();
        let inverse = direction.map(|d| 1.0 / if d.abs() < LEAST { LEAST.copysign(d) } else { d });
        let mut sides = [[0, 1, 2], [3, 4, 5]];
        for axis in 0..3 {
            let down = usize::from(inverse[axis] < 0.0);
            sides[0][axis] += 3 * down;
            sides[1][axis] -= 3 * down;
        }
        Self { origin: origin.to_array(), direction, inverse, sides }
    }
}

/// A node, or a leaf.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Link(u32);

impl Link {
    const LEAF: u32 = 1 << 31;

    /// Index of the leaf, if it is one.
    #[inline(always)]
    pub(super) fn leaf(self) -> Option<usize> {
        (self.0 & Self::LEAF != 0).then_some((self.0 & !Self::LEAF) as usize)
    }

    /// Index of the node that it else is.
    #[inline(always)]
    pub(super) fn node(self) -> usize {
        self.0 as usize
    }
}

/// Rays from one point that go down the same axes, ready for boxes and triangles.
pub(super) struct Beam {
    pub(super) origin: [f32; 3],
    /// Of the rays, by axis.
    pub(super) directions: [[f32; TOGETHER]; 3],
    /// Least and greatest 1/direction of the rays.
    inverse: [[f32; 3]; 2],
    sides: [[usize; 3]; 2],
}

impl Beam {
    /// `None` if the rays do not come from one point, or not go down the same axes.
    #[inline(always)]
    pub(super) fn new(rays: &[Ray; TOGETHER]) -> Option<Self> {
        let first = &rays[0];
        let mut inverse = [first.inverse; 2];
        let mut directions = [[0.0; TOGETHER]; 3];
        for (i, ray) in rays.iter().enumerate() {
            if ray.origin != first.origin || ray.sides != first.sides {
                return None;
            }
            for axis in 0..3 {
                directions[axis][i] = ray.direction[axis];
                inverse[0][axis] = inverse[0][axis].min(ray.inverse[axis]);
                inverse[1][axis] = inverse[1][axis].max(ray.inverse[axis]);
            }
        }
        Some(Self { origin: first.origin, directions, inverse, sides: first.sides })
    }
}

/// Eight boxes and what is in them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// First, in the line of memory that a visit waits for anyway.
    links: [Link; WIDTH],
    /// Low sides along x, y, z, then high sides. Boxes that are not there are inside out, and never met.
    sides: [[f32; WIDTH]; 6],
}

impl Node {
    const EMPTY: Self = Self {
        sides: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        links: [Link(0); WIDTH],
    };

    /// The nearest box that the ray enters before `limit`; the others are put on the stack, the nearer the higher.
    #[inline(always)]
    pub(super) fn visit<S: Simd>(&self, simd: S, ray: &Ray, limit: f32, stack: &mut Stack) -> Option<Link> {
        // Plain code: closures handed to std are not compiled for the wider instruction set.
        let mut near = f32x8::splat(simd, 0.0);
        let mut far = f32x8::splat(simd, limit);
        for axis in 0..3 {
            let [first, last]: [f32x8<S>; 2] = ray.sides.map(|sides| self.sides[sides[axis]].simd_into(simd));
            near = near.max((first - ray.origin[axis]) * ray.inverse[axis]);
            far = far.min((last - ray.origin[axis]) * ray.inverse[axis]);
        }
        self.sort(near.simd_le(far * ROUNDING).to_bitmask(), near.into(), stack)
    }

    /// The nearest box that any ray of a beam may enter before `limit`.
    #[inline(always)]
    pub(super) fn visit_beam<S: Simd>(
        &self,
        simd: S,
        beam: &Beam,
        limit: f32,
        stack: &mut Stack,
    ) -> Option<Link> {
        let mut near = f32x8::splat(simd, 0.0);
        let mut far = f32x8::splat(simd, limit);
        for axis in 0..3 {
            let [first, last]: [f32x8<S>; 2] = beam.sides.map(|sides| self.sides[sides[axis]].simd_into(simd));
            let (first, last) = (first - beam.origin[axis], last - beam.origin[axis]);
            let [low, high] = beam.inverse.map(|inverse| inverse[axis]);
            near = near.max((first * low).min(first * high));
            far = far.min((last * low).max(last * high));
        }
        self.sort(near.simd_le(far * ROUNDING).to_bitmask(), near.into(), stack)
    }

    /// The nearest of the boxes that are met; the others are put on the stack, the nearer the higher.
    #[inline(always)]
    fn sort(&self, met: u64, near: [f32; WIDTH], stack: &mut Stack) -> Option<Link> {
        let mut met = met;
        let mut take = || {
            let i = met.trailing_zeros() as usize;
            met &= met.wrapping_sub(1);
            (i < WIDTH).then(|| Entry { near: near[i & (WIDTH - 1)], link: self.links[i & (WIDTH - 1)] })
        };
        let mut nearest = take()?;
        let start = stack.used;
        while let Some(mut other) = take() {
            if other.near < nearest.near {
                std::mem::swap(&mut other, &mut nearest);
            }
            stack.push(other);
            // Few are met at once: insertion sorts them.
            let mut i = stack.used - 1;
            while i > start && stack.entries[i - 1].near < other.near {
                stack.entries.swap(i - 1, i);
                i -= 1;
            }
        }
        Some(nearest.link)
    }
}

/// A tree of boxes.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    /// Nodes on the longest way down.
    depth: usize,
}

impl Tree {
    /// Widen a binary tree. Also which triangles each leaf has; lanes that are left over have `u32::MAX`.
    pub(super) fn new(binary: &Bvh2) -> (Self, Vec<[u32; LANES]>) {
        let mut tree = Self::default();
        let mut leaves = Vec::new();
        let root = &binary.nodes[0];
        let root: Vec<&Bvh2Node> = if root.is_leaf() { vec![root] } else { widen(binary, root) };
        // A node's place, what is to be in it, and how many nodes lead there with it.
        let mut open = vec![(0, root, 1)];
        tree.nodes.push(Node::EMPTY);
        while let Some((at, children, depth)) = open.pop() {
            tree.depth = tree.depth.max(depth);
            for (i, child) in children.into_iter().enumerate() {
                let (low, high) = (child.aabb().min.to_array(), child.aabb().max.to_array());
                for axis in 0..3 {
                    tree.nodes[at].sides[axis][i] = low[axis];
                    tree.nodes[at].sides[axis + 3][i] = high[axis];
                }
                tree.nodes[at].links[i] = if child.is_leaf() {
                    let range = child.first_index as usize..(child.first_index + child.prim_count) as usize;
                    let mut lanes = [u32::MAX; LANES];
                    lanes.iter_mut().zip(&binary.primitive_indices[range]).for_each(|(l, i)| *l = *i);
                    leaves.push(lanes);
                    Link(Link::LEAF | (leaves.len() - 1) as u32)
                } else {
                    open.push((tree.nodes.len(), widen(binary, child), depth + 1));
                    tree.nodes.push(Node::EMPTY);
                    Link((tree.nodes.len() - 1) as u32)
                };
            }
        }
        (tree, leaves)
    }

    /// Where to begin.
    #[inline(always)]
    pub(super) fn root(&self) -> Option<Link> {
        (!self.nodes.is_empty()).then_some(Link(0))
    }

    /// How many parts can wait at once: of each node on the way down all but one.
    pub(super) fn most_open(&self) -> usize {
        self.depth * (WIDTH - 1)
    }
}

/// Up to eight parts of a node: the largest is opened again and again.
fn widen<'a>(binary: &'a Bvh2, node: &'a Bvh2Node) -> Vec<&'a Bvh2Node> {
    let children = |node: &Bvh2Node| {
        let first = node.first_index as usize;
        [&binary.nodes[first], &binary.nodes[first + 1]]
    };
    let mut parts = children(node).to_vec();
    while parts.len() < WIDTH {
        let area = |i: &usize| parts[*i].aabb().half_area();
        let inner = (0..parts.len()).filter(|i| !parts[*i].is_leaf());
        let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
        let [left, right] = children(parts[largest]);
        parts[largest] = left;
        parts.push(right);
    }
    parts
}
