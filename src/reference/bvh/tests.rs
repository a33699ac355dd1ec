//! Against a look at every triangle.

use fearless_simd::{Level, dispatch};
use glam::Vec3;

use super::{Bvh, Hit, Place};
use crate::base::hash;
use crate::scene::{Mesh, Object};

fn first_hit(bvh: &Bvh, origin: Vec3, direction: Vec3, limit: f32) -> Option<Hit> {
    dispatch!(Level::new(), simd => bvh.first_hit(simd, &mut bvh.stack(), origin, direction, limit))
}

fn is_blocked(bvh: &Bvh, origin: Vec3, direction: Vec3, limit: f32) -> bool {
    dispatch!(Level::new(), simd => bvh.is_blocked(simd, &mut bvh.stack(), origin, direction, limit))
}

/// Numbers in [-1, 1), the same in every run.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 += 1;
        hash::signed(hash::pcg(self.0))
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn object(corners: &[[Vec3; 3]]) -> Object {
    let positions: Vec<Vec3> = corners.iter().flatten().copied().collect();
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    Object { name: String::new(), mesh, material: 0 }
}

fn corners(object: &Object, triangle: usize) -> [Vec3; 3] {
    object.mesh.triangles[triangle].map(|i| object.mesh.positions[i as usize])
}

/// Where a ray meets a triangle's plane, in f64 (Moeller & Trumbore 1997): the least and greatest distance that rounding in
/// f32 allows, and whether it is inside for sure, or perhaps.
fn meet([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<([f64; 2], [bool; 2])> {
    let [a, b, c, origin, direction] = [a, b, c, origin, direction].map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let q = (origin - a).cross(ab);
    // All is over this volume, which is little for slivers and where the ray grazes.
    let volume = ab.dot(p).abs();
    let sign = ab.dot(p).signum();
    let (u, v, t) = (sign * (origin - a).dot(p), sign * direction.dot(q), sign * ac.dot(q));
    let inside = u.min(v).min(volume - u - v);
    let rounding = 1e-6;
    (t > 0.0).then_some((
        [t - rounding, t + rounding].map(|t| t / volume),
        [inside > rounding, inside > -rounding],
    ))
}

/// The nearest of all triangles that a ray meets for sure, and of those that it meets or nearly misses.
fn nearest(objects: &[Object], origin: Vec3, direction: Vec3) -> [f64; 2] {
    let triangles = objects.iter().flat_map(|o| (0..o.mesh.triangles.len()).map(|i| corners(o, i)));
    let mut nearest = [f64::INFINITY; 2];
    for ([least, most], [sure, perhaps]) in triangles.filter_map(|corners| meet(corners, origin, direction)) {
        if sure {
            nearest[0] = nearest[0].min(most);
        }
        if perhaps {
            nearest[1] = nearest[1].min(least);
        }
    }
    nearest
}

#[test]
fn the_tree_finds_what_a_look_at_every_triangle_finds() {
    let mut random = Random(1);
    let objects = [300, 5, 0, 200].map(|count| {
        let corners: Vec<[Vec3; 3]> = (0..count)
            .map(|_| {
                let at = random.vector();
                [(); 3].map(|()| at + 0.2 * random.vector())
            })
            .collect();
        object(&corners)
    });
    let bvh = Bvh::new(&objects);
    let (mut met, mut missed, mut certain) = (0, 0, 0);
    for _ in 0..4000 {
        let origin = 2.0 * random.vector();
        let direction = random.vector().normalize();
        let [sure, perhaps] = nearest(&objects, origin, direction);
        let Some(hit) = first_hit(&bvh, origin, direction, f32::INFINITY) else {
            assert_eq!(sure, f64::INFINITY, "{origin} {direction}");
            assert!(perhaps < f64::INFINITY || !is_blocked(&bvh, origin, direction, f32::INFINITY));
            missed += 1;
            continue;
        };
        met += 1;
        let t = f64::from(hit.distance);
        assert!(perhaps <= t && t <= sure, "{perhaps} {t} {sure}");
        // Edges and slivers aside.
        if perhaps < 0.9995 * t || 1.0005 * t < sure {
            continue;
        }
        certain += 1;
        // The weights and the normal are those of the triangle's place.
        let corners = corners(&objects[hit.place.object as usize], hit.place.triangle as usize);
        let place: Vec3 = (0..3).map(|i| hit.weights[i] * corners[i]).sum();
        assert!((place - (origin + hit.distance * direction)).length() < 1e-3);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        assert!((normal - hit.normal).length() < 1e-3);
        // Nothing is nearer, and a limit is kept.
        for (limit, blocked) in [(0.999 * hit.distance, false), (1.001 * hit.distance, true)] {
            assert_eq!(is_blocked(&bvh, origin, direction, limit), blocked, "{origin} {direction}");
            assert_eq!(first_hit(&bvh, origin, direction, limit).is_some(), blocked);
        }
    }
    assert!(met > 500 && missed > 500 && certain > met * 9 / 10, "{met} {missed} {certain}");
}

/// Rays of a beam meet what each meets alone: from one point or several, narrow or not, to all sides.
#[test]
fn rays_together_meet_what_each_meets_alone() {
    let mut random = Random(3);
    let corners: Vec<[Vec3; 3]> = (0..400)
        .map(|_| {
            let at = random.vector();
            [(); 3].map(|()| at + 0.2 * random.vector())
        })
        .collect();
    let bvh = Bvh::new(&[object(&corners)]);
    let (mut met, mut differ) = (0, 0);
    for round in 0..2000 {
        let origin = 2.0 * random.vector();
        let origins = [(); 8].map(|()| if round % 10 == 0 { 2.0 * random.vector() } else { origin });
        let spread = [0.0, 0.01, 0.2, 2.0][round % 4];
        // Along an axis, too, so that rays of one beam have components of both signs, and zeros.
        let main = if round % 7 == 0 { Vec3::NEG_X } else { random.vector() - origin };
        let directions = [(); 8].map(|()| (main + spread * random.vector()).normalize());
        let together = dispatch!(Level::new(), simd => {
            bvh.first_hits(simd, &mut bvh.stack(), &origins, &directions)
        });
        let alone: Vec<_> =
            (0..8).map(|i| first_hit(&bvh, origins[i], directions[i], f32::INFINITY)).collect();
        let seen = |hit: &Option<Hit>| hit.map(|h| (h.place, h.distance.to_bits(), h.weights));
        assert_eq!(together.iter().map(seen).collect::<Vec<_>>(), alone.iter().map(seen).collect::<Vec<_>>());
        met += alone.iter().flatten().count();
        differ += usize::from(alone.iter().any(|h| seen(h) != seen(&alone[0])));
    }
    assert!(met > 4000 && differ > 500, "{met} {differ}");
    let nothing = Bvh::new(&[]);
    let none = dispatch!(Level::new(), simd => {
        nothing.first_hits(simd, &mut nothing.stack(), &[Vec3::ZERO; 8], &[Vec3::Z; 8])
    });
    assert!(none.iter().all(Option::is_none));
}

/// Coincident triangles are met in the order in which they are listed, wherever they are in the tree.
#[test]
fn of_two_triangles_at_one_distance_the_first_listed_is_met() {
    let mut random = Random(7);
    let front = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let behind = |random: &mut Random| {
        let at = random.vector() - 2.0 * Vec3::Z;
        [(); 3].map(|()| at + 0.3 * random.vector())
    };
    // Alone, a sheet is met at its own place; twice, or forty times, at the first.
    for (skipped, copies) in [(0, 1), (0, 40), (33, 7), (64, 2)] {
        let others: Vec<[Vec3; 3]> = (0..skipped).map(|_| behind(&mut random)).collect();
        let mut corners = others.clone();
        corners.extend(std::iter::repeat_n(front, copies));
        let objects = [object(&others), object(&corners), object(&[front])];
        let hit = first_hit(&Bvh::new(&objects), Vec3::Z, Vec3::NEG_Z, f32::INFINITY).expect("the sheet");
        assert_eq!(hit.place, Place { object: 1, triangle: skipped }, "{copies}");
    }
}

#[test]
fn an_empty_tree_is_met_nowhere() {
    for objects in [vec![], vec![object(&[])]] {
        let bvh = Bvh::new(&objects);
        assert!(first_hit(&bvh, Vec3::ZERO, Vec3::Z, f32::INFINITY).is_none());
        assert!(!is_blocked(&bvh, Vec3::ZERO, Vec3::Z, f32::INFINITY));
    }
}
