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
            let [first, last]: [f32x8<S>; 2] =
                beam.sides.map(|sides| self.sides[sides[axis]].simd_into(simd));
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
        let cheapest = Cheapest::new(binary);
        let parts = |i: usize| if binary.nodes[i].is_leaf() { vec![i] } else { cheapest.parts(i) };
        // A node's place, what is to be in it, and how many nodes lead there with it.
        let mut open = vec![(0, parts(0), 1)];
        tree.nodes.push(Node::EMPTY);
        while let Some((at, children, depth)) = open.pop() {
            tree.depth = tree.depth.max(depth);
            for (i, child) in children.into_iter().enumerate() {
                let index = child;
                let child = &binary.nodes[index];
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
                    open.push((tree.nodes.len(), parts(index), depth + 1));
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

/// Which binary nodes are to be nodes of the wide tree, so that rays visit the fewest: a ray meets a box as often as its
/// area says.
///
/// By dynamic programming over the number of parts that a subtree is cut into (Ylitie, Karras & Laine 2017, Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 3.1).
struct Cheapest<'a> {
    binary: &'a Bvh2,
    /// Of each node cut into up to so many parts, less one: how many the first child gets. 0: the same as with one less.
    /// With one part the node stays, and is itself cut into [`WIDTH`].
    first: Vec<[u8; WIDTH]>,
}

impl<'a> Cheapest<'a> {
    fn new(binary: &'a Bvh2) -> Self {
        // Each before its children.
        let mut order = vec![0];
        let mut next = 0;
        while let Some(&i) = order.get(next) {
            next += 1;
            if !binary.nodes[i].is_leaf() {
                order.extend(children(&binary.nodes[i]));
            }
        }
        let mut first = vec![[0; WIDTH]; binary.nodes.len()];
        // Area of all nodes below, by how many parts there may be. Leaves are visited however they hang.
        let mut areas = vec![[0.0f32; WIDTH]; binary.nodes.len()];
        for i in order.into_iter().rev().filter(|i| !binary.nodes[*i].is_leaf()) {
            let [left, right] = children(&binary.nodes[i]).map(|child| areas[child]);
            let cut = |parts: usize| {
                let of = (1..parts).map(|k| (k, left[k - 1] + right[parts - k - 1]));
                of.min_by(|a, b| a.1.total_cmp(&b.1)).expect("two parts or more")
            };
            let (k, area) = cut(WIDTH);
            first[i][0] = k as u8;
            areas[i][0] = area + binary.nodes[i].aabb().half_area();
            for parts in 2..=WIDTH {
                let (k, area) = cut(parts);
                let fewer = areas[i][parts - 2];
                (first[i][parts - 1], areas[i][parts - 1]) =
                    if area < fewer { (k as u8, area) } else { (0, fewer) };
            }
        }
        Self { binary, first }
    }

    /// What is in the wide node that this node becomes: at most [`WIDTH`] nodes.
    fn parts(&self, node: usize) -> Vec<usize> {
        let mut parts = Vec::with_capacity(WIDTH);
        let cut = |i: usize, count: usize, first: u8| {
            let [left, right] = children(&self.binary.nodes[i]);
            [(right, count - usize::from(first)), (left, usize::from(first))]
        };
        let mut open = cut(node, WIDTH, self.first[node][0]).to_vec();
        while let Some((i, count)) = open.pop() {
            if self.binary.nodes[i].is_leaf() || count == 1 {
                parts.push(i);
                continue;
            }
            match self.first[i][count - 1] {
                0 => open.push((i, count - 1)),
                first => open.extend(cut(i, count, first)),
            }
        }
        parts
    }
}

fn children(node: &Bvh2Node) -> [usize; 2] {
    let first = node.first_index as usize;
    [first, first + 1]
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::BvhBuildParams;
    use obvhs::bvh2::builder::build_bvh2_from_tris;
    use obvhs::triangle::Triangle;

    use super::*;
    use crate::base::hash;

    /// Area of all wide nodes, if each is cut as `parts` says.
    fn area(binary: &Bvh2, parts: impl Fn(usize) -> Vec<usize>) -> f32 {
        let (mut sum, mut open) = (0.0, vec![0]);
        while let Some(i) = open.pop() {
            sum += binary.nodes[i].aabb().half_area();
            let parts = parts(i);
            assert!((2..=WIDTH).contains(&parts.len()));
            open.extend(parts.into_iter().filter(|i| !binary.nodes[*i].is_leaf()));
        }
        sum
    }

    /// The usual way: the largest part is opened again and again.
    fn greedy(binary: &Bvh2, node: usize) -> Vec<usize> {
        let mut parts = children(&binary.nodes[node]).to_vec();
        while parts.len() < WIDTH {
            let inner = (0..parts.len()).filter(|i| !binary.nodes[parts[*i]].is_leaf());
            let of = |i: usize| binary.nodes[parts[i]].aabb().half_area();
            let Some(largest) = inner.max_by(|a, b| of(*a).total_cmp(&of(*b))) else { break };
            let [left, right] = children(&binary.nodes[parts[largest]]);
            parts[largest] = left;
            parts.push(right);
        }
        parts
    }

    #[test]
    fn nodes_are_cut_so_that_less_area_is_visited_than_by_opening_the_largest() {
        let coordinate = |i: u32| hash::signed(hash::pcg(i));
        let point = |i: u32| Vec3A::new(coordinate(3 * i), coordinate(3 * i + 1), coordinate(3 * i + 2));
        for count in [20, 100, 3000] {
            let corner = |i: u32, k: u32| point(i) + 0.05 * point(count + 3 * i + k);
            let triangles: Vec<_> = (0..count)
                .map(|i| Triangle { v0: corner(i, 0), v1: corner(i, 1), v2: corner(i, 2) })
                .collect();
            let settings =
                BvhBuildParams { max_prims_per_leaf: LANES as u32, ..BvhBuildParams::slow_build() };
            let binary = build_bvh2_from_tris(&triangles, settings, &mut Default::default());
            let cheapest = Cheapest::new(&binary);
            let (ours, theirs) =
                (area(&binary, |i| cheapest.parts(i)), area(&binary, |i| greedy(&binary, i)));
            assert!(ours <= theirs * 1.0001, "{count}: {ours} {theirs}");
            assert!(count < 1000 || ours < 0.97 * theirs, "{count}: {ours} {theirs}");
        }
    }
}
