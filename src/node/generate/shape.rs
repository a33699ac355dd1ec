//! What every shape node shares: its place on the torus, its edge, its outputs.

use std::ops::Range;

use crate::base::{Rows, num, sdf};
use crate::multiversion;
use crate::node::{Cx, InputSpec, Inputs, OutputSpec, Outputs};

/// The outputs of every shape.
pub(super) const OUTPUTS: &[OutputSpec] = &[
    OutputSpec::scalar(
        "mask",
        "",
        "Coverage, 1 inside and 0 outside; the edge is as wide as a texel or as `softness`, whichever is more.",
    ),
    OutputSpec::scalar("distance", "mm", "Distance to the outline, positive inside."),
];

/// The input that turns a shape.
pub(super) const ROTATION: InputSpec = InputSpec::drive(
    "rotation",
    0.0,
    (-360.0, 360.0),
    "deg",
    "Turns the shape about its centre, from u towards v (clockwise where v points down).",
);

/// A size that a map may drive, as a fraction of the tile's shorter side.
pub(super) const fn size(name: &'static str, default: f32, doc: &'static str) -> InputSpec {
    InputSpec::drive(name, default, (0.0, MAX_SIZE), "tile", doc)
}

/// Greatest size. Within it the nearest image of a shape is one of the nine around the texel.
const MAX_SIZE: f32 = 2.0;

/// One row of texels before a shape's kernel.
pub(super) struct Texels<'a> {
    /// Place relative to the nearest centre, mm.
    pub(super) x: &'a [f32],
    pub(super) y: &'a [f32],
    /// Cosine and sine of the rotation.
    pub(super) cos: &'a [f32],
    pub(super) sin: &'a [f32],
    /// First and second size, tile fractions, as the inputs have them.
    pub(super) a: &'a [f32],
    pub(super) b: &'a [f32],
    /// mm of half a tile: what a size is multiplied with to be a half size.
    pub(super) half_mm: f32,
    /// Where this image of the shape lies, mm.
    pub(super) image: [f32; 2],
    /// The shape's own settings.
    pub(super) k: [f32; 4],
}

/// Lowers `d` to the distance (mm, negative inside) of one image of the shape.
pub(super) type Kernel = fn(&Texels<'_>, &mut [f32]);

/// A half size in mm from what an input says.
#[inline(always)]
pub(super) fn half(size: f32, half_mm: f32) -> f32 {
    size.max(0.0).min(MAX_SIZE) * half_mm
}

/// Make a [`Kernel`] from a distance: `kernel!(name, |x, y, a, b, k| distance)`, where `a` and `b` are half sizes in mm.
macro_rules! kernel {
    ($name:ident, |$x:ident, $y:ident, $a:ident, $b:ident, $k:ident| $distance:expr) => {
        $crate::multiversion! {
            fn $name(t: &$crate::node::generate::shape::Texels<'_>, d: &mut [f32]) {
                let n = d.len();
                let (xs, ys, cos, sin) = (&t.x[..n], &t.y[..n], &t.cos[..n], &t.sin[..n]);
                let (a, b, $k) = (&t.a[..n], &t.b[..n], t.k);
                for i in 0..n {
                    let (x, y) = (xs[i] + t.image[0], ys[i] + t.image[1]);
                    let ($x, $y) = $crate::base::sdf::turn(x, y, cos[i], sin[i]);
                    let ($a, $b) = (
                        $crate::node::generate::shape::half(a[i], t.half_mm),
                        $crate::node::generate::shape::half(b[i], t.half_mm),
                    );
                    d[i] = d[i].min($distance);
                }
            }
        }
    };
}
pub(super) use kernel;

/// A shape to paint.
pub(super) struct Shape {
    pub(super) center_u: f32,
    pub(super) center_v: f32,
    pub(super) softness: f32,
    /// Index of the input with the first and the second size (the same where there is one).
    pub(super) sizes: [usize; 2],
    /// Index of the rotation, if it turns.
    pub(super) rotation: Option<usize>,
    /// Index of `du`; `dv` follows.
    pub(super) offsets: usize,
    pub(super) kernel: Kernel,
    pub(super) k: [f32; 4],
}

impl Shape {
    /// Write the mask and the distance of the union of all images of the shape.
    pub(super) fn paint(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let domain = &cx.domain;
        let n = domain.width;
        let (girth, length, shorter) = (domain.girth_mm, domain.length_mm, domain.shorter_mm());
        let edge = domain.texel_mm().max(self.softness * shorter);
        let no_turn = [0.0];
        let rotation = self.rotation.map_or(Rows::broadcast(&no_turn), |i| ins.scalar(i));
        let mut buffers: [Vec<f32>; 5] = std::array::from_fn(|_| vec![0.0; n]);
        let [x, y, cos, sin, d] = &mut buffers;
        if let Some(degrees) = rotation.constant() {
            turns(&vec![degrees; n], cos, sin);
        }
        let (du, dv) = (self.offsets, self.offsets + 1);
        for row in rows {
            place(ins.row(du, row), 0.0, 1.0 / n as f32, self.center_u, girth, x);
            place(ins.row(dv, row), domain.v(row), 0.0, self.center_v, length, y);
            if rotation.constant().is_none() {
                turns(rotation.row(row), cos, sin);
            }
            let (a, b) = (ins.row(self.sizes[0], row), ins.row(self.sizes[1], row));
            // Without the distance, images that cannot touch the row are skipped.
            let near = if outs.wants(1) {
                f32::MAX
            } else {
                let half_mm = 0.5 * shorter;
                let greatest = |sizes: &[f32]| half(sizes.iter().copied().fold(0.0, f32::max), half_mm);
                sdf::length(greatest(a), greatest(b)) + edge
            };
            let touches = |p: &[f32], offset: f32| p.iter().any(|p| (p + offset).abs() <= near);
            d.fill(f32::MAX);
            for image_y in [-length, 0.0, length].into_iter().filter(|&o| touches(y, o)) {
                for image_x in [-girth, 0.0, girth].into_iter().filter(|&o| touches(x, o)) {
                    let texels = Texels {
                        x,
                        y,
                        cos,
                        sin,
                        a,
                        b,
                        half_mm: 0.5 * shorter,
                        image: [image_x, image_y],
                        k: self.k,
                    };
                    (self.kernel)(&texels, d);
                }
            }
            if let Some(mask) = outs.row(0, row) {
                cover(d, edge, mask);
            }
            if let Some(distance) = outs.row(1, row) {
                for (out, d) in distance.iter_mut().zip(d.iter()) {
                    *out = -d;
                }
            }
        }
    }
}

multiversion! {
    /// Place relative to the nearest image of `center`, mm: texel i stands at `first + (i + 0.5) step + offset`.
    pub(super) fn place(offset: &[f32], first: f32, step: f32, center: f32, side: f32, out: &mut [f32]) {
        for (i, (out, offset)) in out.iter_mut().zip(offset).enumerate() {
            *out = num::wrap_half(first + (i as f32 + 0.5) * step - center + offset) * side;
        }
    }
}

multiversion! {
    fn turns(degrees: &[f32], cos: &mut [f32], sin: &mut [f32]) {
        for ((cos, sin), degrees) in cos.iter_mut().zip(sin).zip(degrees) {
            let t = num::wrap_half(degrees * (1.0 / 360.0));
            (*cos, *sin) = (num::cos_turns(t), num::sin_turns(t));
        }
    }
}

multiversion! {
    fn cover(d: &[f32], edge: f32, out: &mut [f32]) {
        for (out, d) in out.iter_mut().zip(d) {
            *out = sdf::coverage(*d, edge);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Disc, Ellipse, Hexagon, Leaf, Polygon, Rectangle, Rhombus, Ring};
    use crate::base::{Domain, Plane, num};
    use crate::eval::{Input, run_node};
    use crate::node::{Assets, Node};

    const TILE: Domain = Domain { width: 200, height: 400, girth_mm: 50.0, length_mm: 100.0 };

    fn run(node: &dyn Node, domain: &Domain, ins: &[f32]) -> [Plane; 2] {
        let ins: Vec<Input<'_>> = ins.iter().map(|&v| Input::Value(v)).collect();
        let out = run_node(node, domain, 1, &ins, &Assets::new(), 64);
        [out[0].clone(), out[1].clone()]
    }

    fn difference(a: &Plane, b: &Plane) -> f32 {
        a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    /// Every shape with its sizes and the area in units of the squared shorter side.
    fn cases() -> Vec<(Box<dyn Node>, Vec<f32>, f64)> {
        let pi = std::f64::consts::PI;
        let fifth = (pi / 5.0).sin() * (pi / 5.0).cos();
        // Circles through the tips of a leaf 0.3 by 0.5: radius 0.34/1.2, half width 0.15.
        let (r, c) = (0.085 / 0.3, 0.04 / 0.3);
        vec![
            (Box::new(Rectangle::default()), vec![0.4, 0.3], 0.12),
            (Box::new(Rectangle { rounding: 1.0, ..Rectangle::default() }), vec![0.4, 0.4], pi * 0.04),
            (Box::new(Disc::default()), vec![0.6], pi * 0.09),
            (Box::new(Ellipse::default()), vec![0.6, 0.2], pi * 0.03),
            (Box::new(Ring::default()), vec![0.6, 0.1], pi * (0.09 - 0.04)),
            (Box::new(Leaf::default()), vec![0.3, 0.5], 2.0 * (r * r * (0.25f64 / r).asin() - 0.25 * c)),
            (Box::new(Rhombus::default()), vec![0.3, 0.6], 0.09),
            (Box::new(Hexagon::default()), vec![0.3, 0.6], 0.3 * 0.3 + 0.3 * 0.15),
            (Box::new(Hexagon { shoulder: 0.0, ..Hexagon::default() }), vec![0.3, 0.6], 0.09),
            (Box::new(Polygon::default()), vec![0.6], 5.0 * 0.09 * fifth),
        ]
    }

    #[test]
    fn areas_are_those_of_the_closed_forms_at_any_turn_and_on_a_tile_that_is_not_square() {
        for (node, sizes, area) in cases() {
            for turn in [0.0, 30.0, 77.0] {
                let mut ins = sizes.clone();
                if node.spec().input("rotation").is_some() {
                    ins.push(turn);
                }
                let mean = num::mean(run(&*node, &TILE, &ins)[0].data());
                assert!((2.0 * mean - area).abs() < 2e-4, "{} {turn}: {mean}, {area}", node.spec().name);
            }
        }
    }

    #[test]
    fn gradients_of_the_distance_have_length_one() {
        for (node, sizes, _) in cases() {
            let mut ins = sizes.clone();
            if node.spec().input("rotation").is_some() {
                ins.push(20.0);
            }
            let d = &run(&*node, &TILE, &ins)[1];
            let (mut good, mut all) = (0, 0);
            for y in 0..400 {
                for x in 0..200 {
                    let gx = (d.at(x + 1, y) - d.at(x - 1, y)) / (2.0 * TILE.texel_u_mm());
                    let gy = (d.at(x, y + 1) - d.at(x, y - 1)) / (2.0 * TILE.texel_v_mm());
                    all += 1;
                    good += usize::from(((gx * gx + gy * gy).sqrt() - 1.0).abs() < 0.01);
                }
            }
            // What is left are medial axes: between images, and inside.
            assert!(good * 100 > all * 92, "{}: {good} of {all}", node.spec().name);
        }
    }

    #[test]
    fn a_shape_goes_on_behind_the_seams() {
        let middle = Rectangle::default();
        let corner = Rectangle { center_u: 0.0, center_v: 0.0, ..Rectangle::default() };
        let ins = [0.9, 0.3, 33.0];
        let [a, da] = run(&middle, &TILE, &ins);
        let [b, db] = run(&corner, &TILE, &ins);
        assert!(difference(&a.shifted(100, 200), &b) < 1e-4);
        assert!(difference(&da.shifted(100, 200), &db) < 1e-4);
        // Offsets move it as the centre does.
        let [c, _] = run(&middle, &TILE, &[0.9, 0.3, 33.0, 0.5, -0.5]);
        assert!(difference(&b, &c) < 1e-4);
        assert!(difference(&a, &b) > 0.9);
    }

    #[test]
    fn distances_are_in_mm_and_positive_inside() {
        let [mask, d] = run(&Disc::default(), &TILE, &[0.5]);
        // Centre of the tile: half a texel's diagonal from the disc's centre, radius 12.5 mm.
        assert!((d.at(100, 200) - (12.5 - 0.125 * 2f32.sqrt())).abs() < 1e-4);
        // Half the length away, the next image is as near.
        assert!((d.at(100, 0) + 37.5).abs() < 0.2);
        assert_eq!((mask.at(100, 200), mask.at(0, 0)), (1.0, 0.0));
    }

    #[test]
    fn softness_is_the_width_of_the_edge() {
        let soft = Disc { softness: 0.2, ..Disc::default() };
        let [mask, d] = run(&soft, &TILE, &[0.5]);
        for (m, d) in mask.data().iter().zip(d.data()) {
            assert!((m - num::saturate(0.5 + d / 10.0)).abs() < 1e-5);
        }
    }

    #[test]
    fn the_mask_is_the_same_whether_or_not_the_distance_is_wanted() {
        use crate::node::{Cx, Inputs, Operation, Outputs};
        let node = Leaf { center_u: 0.05, center_v: 0.9, ..Leaf::default() };
        let sizes = [1.2, 1.9, 50.0];
        let [mask, _] = run(&node, &TILE, &sizes);
        let rows: Vec<Vec<f32>> = [1.2, 1.9, 50.0, 0.0, 0.0].map(|v| vec![v; 200]).to_vec();
        let lanes: Vec<_> = rows.iter().map(|r| crate::base::Rows::broadcast(r)).collect();
        let ins = Inputs::new(&[0, 1, 2, 3, 4, 5], &lanes);
        let mut only = vec![0.0; 200 * 400];
        let mut outs = Outputs::new(&[0, 1, 2], [Some(&mut only[..]), None].into_iter().collect(), 200, 0);
        let assets = Assets::new();
        let cx = Cx { domain: TILE, seed: 1, assets: &assets, prepared: None };
        Operation::eval(&node, &cx, 0..400, &ins, &mut outs);
        drop(outs);
        assert_eq!(only, mask.data());
    }

    #[test]
    fn one_texel_no_size_and_absurd_inputs_are_finite() {
        for (node, _, _) in cases() {
            for value in [0.0, 1e30, -1e30, 1e-40, f32::MAX] {
                for domain in
                    [Domain::square(1), Domain { width: 1, height: 7, girth_mm: 1e-3, length_mm: 1e6 }]
                {
                    let ins = vec![value; node.spec().inputs.len()];
                    for plane in run(&*node, &domain, &ins) {
                        assert!(plane.data().iter().all(|v| v.is_finite()), "{} {value}", node.spec().name);
                    }
                }
            }
        }
    }
}
