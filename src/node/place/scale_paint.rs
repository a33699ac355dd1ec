//! Painting the instance table into a band of rows: each scale over its bounding box, bottom to top.
//!
//! A texel looks only at scales whose box holds it; shapes are analytic, so nothing depends on resolution. Scales are
//! painted from the tail to the head, because each lies over the base of the next one tail-ward; on the torus the order
//! is taken over the copies that a band can see.

use std::ops::Range;

use super::scale_lattice::{ScaleShape, port, texel_mm};
use super::scale_table::{Form, Scale, Table};
use crate::base::{Domain, num, sdf};
use crate::multiversion;
use crate::node::Outputs;

/// A scale as a band sees it: index in the table, and the copy of the tile it comes from.
#[derive(Clone, Copy, Debug)]
struct Copy {
    scale: usize,
    /// Centre along the body in the band's unwrapped coordinates, mm.
    y_mm: f32,
    is_scute: bool,
}

/// No scale under the texel.
const SKIN: u32 = u32::MAX;

/// The painted band: per texel the topmost scale and the running results.
pub(super) struct Band {
    rows: Range<i64>,
    width: usize,
    copies: Vec<Copy>,
    top: Vec<u32>,
    height: Vec<f32>,
    edge: Vec<f32>,
    outline: Vec<f32>,
    cover: Vec<f32>,
}

impl Band {
    pub(super) fn new(domain: &Domain, rows: Range<i64>) -> Self {
        let texels = (rows.end - rows.start) as usize * domain.width;
        Self {
            rows,
            width: domain.width,
            copies: Vec::new(),
            top: vec![SKIN; texels],
            height: vec![0.0; texels],
            // Larger than any scale: the distance to a border that is not there.
            edge: vec![f32::MAX; texels],
            outline: vec![0.0; texels],
            cover: vec![0.0; texels],
        }
    }
}

/// Paint every scale that the band can see.
pub(super) fn paint(table: &Table, domain: &Domain, band: &mut Band) {
    band.copies = visible(table, domain, &band.rows);
    for i in 0..band.copies.len() {
        let copy = band.copies[i];
        let scale = &table.scales[copy.scale];
        let form = if copy.is_scute { &table.ventral } else { &table.dorsal };
        paint_one(scale, form, copy.y_mm, i as u32, domain, band);
    }
}

/// Copies of scales that may touch the rows, tail-most first: the order they are painted in.
fn visible(table: &Table, domain: &Domain, rows: &Range<i64>) -> Vec<Copy> {
    let texel = domain.texel_v_mm();
    let (top_mm, bottom_mm) = (rows.start as f32 * texel, rows.end as f32 * texel);
    let mut copies = Vec::new();
    for row in &table.rows {
        let reach = row.reach_mm + texel_mm(domain);
        let first = ((top_mm - reach - row.start_mm) / row.pitch_mm).floor() as i64;
        let last = ((bottom_mm + reach - row.start_mm) / row.pitch_mm).ceil() as i64;
        for i in first..=last {
            let column = i.rem_euclid(i64::from(row.count));
            let wraps = (i - column) / i64::from(row.count);
            let scale = row.first + column as usize;
            copies.push(Copy {
                scale,
                y_mm: table.scales[scale].y_mm + wraps as f32 * domain.length_mm,
                is_scute: row.is_scute,
            });
        }
    }
    copies.sort_by(|a, b| {
        b.is_scute
            .cmp(&a.is_scute)
            .then_with(|| b.y_mm.total_cmp(&a.y_mm))
            .then_with(|| a.scale.cmp(&b.scale))
    });
    copies
}

/// What the kernel needs to know of one scale on one row of texels.
#[derive(Clone, Copy)]
struct Pen {
    /// Offset of the first texel's centre from the scale's, around and along the body, mm.
    x_mm: f32,
    y_mm: f32,
    step_mm: f32,
    cos: f32,
    sin: f32,
    half_width: f32,
    half_length: f32,
    /// Half diagonals and cuts of the outline, and its corner radius, mm.
    hx: f32,
    hy: f32,
    cut_x: f32,
    cut_y: f32,
    radius: f32,
    relief: f32,
    dome: f32,
    peak: f32,
    bevel: f32,
    keel: f32,
    keel_width: f32,
    keel_length: f32,
    /// Width of the anti-aliasing ramp, mm.
    ramp: f32,
    copy: u32,
}

fn paint_one(scale: &Scale, form: &Form, y_mm: f32, copy: u32, domain: &Domain, band: &mut Band) {
    let (texel_u, texel_v) = (domain.texel_u_mm(), domain.texel_v_mm());
    let [cos, sin] = scale.axis;
    let (a, b) = (scale.half_width_mm, scale.half_length_mm);
    // Box of the turned outline; the margin lets a scale's outside bound the edges of those beneath.
    let margin = a.min(b) * 0.5 + 2.0 * texel_u.max(texel_v);
    let box_x = a * cos.abs() + b * sin.abs() + margin;
    let box_y = b * cos.abs() + a * sin.abs() + margin;
    let centre_x = scale.x_mm + 0.5 * domain.girth_mm;
    let mut first = ((centre_x - box_x) / texel_u - 0.5).ceil() as i64;
    let mut last = ((centre_x + box_x) / texel_u - 0.5).floor() as i64 + 1;
    if last - first > domain.width as i64 {
        // Wider than the girth: each texel once, from the side where the scale is nearest.
        first = (centre_x / texel_u) as i64 - domain.width as i64 / 2;
        last = first + domain.width as i64;
    }
    if last <= first {
        return;
    }
    let y0 = (((y_mm - box_y) / texel_v - 0.5).ceil() as i64).max(band.rows.start);
    let y1 = (((y_mm + box_y) / texel_v - 0.5).floor() as i64 + 1).min(band.rows.end);

    let flat = 1.0 - form.apex;
    let (hx, hy, cut_x, cut_y, radius) = match (form.is_scute, form.shape) {
        (true, _) => (4.0 * a, 4.0 * b, a, b, form.roundness * b),
        (_, ScaleShape::Rhombus) => {
            (a * (1.0 + 0.35 * flat), b * (1.0 + 0.2 * flat), a, b, form.roundness * 0.6 * a.min(b))
        }
        (_, ScaleShape::Hexagon) => (a * (1.7 + 1.6 * flat), b, a, b, form.roundness * 0.6 * a.min(b)),
        (_, ScaleShape::Leaf | ScaleShape::Granule) => (a, b, a, b, 0.0),
    };
    let ramp = (texel_u * texel_v).sqrt();
    // A rim or keel narrower than a texel would alias: it is as wide as the grid can hold, a keel lower by as much.
    let keel_width = form.keel_width.max((1.5 * ramp / a.max(1e-9)).min(1.0));
    for y in y0..y1 {
        let row = (y - band.rows.start) as usize * band.width;
        let mut x = first;
        // The row's span, cut where it crosses the seam.
        while x < last {
            let column = x.rem_euclid(domain.width as i64) as usize;
            let run = ((last - x) as usize).min(domain.width - column);
            let span = row + column..row + column + run;
            let pen = Pen {
                x_mm: (x as f32 + 0.5) * texel_u - centre_x,
                y_mm: (y as f32 + 0.5) * texel_v - y_mm,
                step_mm: texel_u,
                cos,
                sin,
                half_width: a,
                half_length: b,
                hx,
                hy,
                cut_x,
                cut_y,
                radius,
                relief: scale.relief_mm,
                dome: form.dome,
                peak: form.peak,
                bevel: form.bevel_mm.max(ramp),
                keel: scale.keel_mm * form.keel_width / keel_width,
                keel_width,
                keel_length: form.keel_length,
                ramp,
                copy,
            };
            let kernel = match (form.is_scute, form.shape) {
                (true, _) => paint_scute,
                (_, ScaleShape::Leaf) => paint_leaf,
                (_, ScaleShape::Granule) => paint_granule,
                (_, ScaleShape::Rhombus | ScaleShape::Hexagon) => paint_facet,
            };
            kernel(
                pen,
                &mut band.top[span.clone()],
                &mut band.height[span.clone()],
                &mut band.edge[span.clone()],
                &mut band.outline[span.clone()],
                &mut band.cover[span],
            );
            x += run as i64;
        }
    }
}

/// Height profile along the scale: a long gentle ramp to the peak, then a short fall to 0.8 at the tip.
#[inline(always)]
fn ramp_profile(t: f32, peak: f32) -> f32 {
    let up = num::saturate(t / peak);
    let down = num::saturate((t - peak) / (1.0 - peak).max(1e-3));
    up * (1.3 - 0.3 * up) * (1.0 - 0.2 * down * down)
}

/// One texel: lay the scale with signed distance `d` (negative inside) over what is there.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one texel of five planes")]
fn lay(
    pen: &Pen,
    d: f32,
    body: f32,
    top: &mut u32,
    height: &mut f32,
    edge: &mut f32,
    outline: &mut f32,
    cover: &mut f32,
) {
    let inside = d < 0.0;
    // The rim rises from what lies beneath to the scale's body within the bevel.
    let rim = num::saturate(-d / pen.bevel);
    let rim = rim * (2.0 - rim);
    let h = num::lerp(*height, body, rim);
    *height = if inside { h.max(0.0) } else { *height };
    // A border is this scale's own outline, or that of a scale laid over it later.
    *edge = if inside { -d } else { edge.min(d) };
    *outline = if inside { -d } else { *outline };
    *top = if inside { pen.copy } else { *top };
    let alpha = num::saturate(0.5 - d / pen.ramp);
    *cover = *cover + (1.0 - *cover) * alpha;
}

/// Height of the scale's body at local (x, y), mm.
#[inline(always)]
fn body_height(pen: &Pen, x: f32, y: f32) -> f32 {
    let s = x / pen.half_width;
    let t = 0.5 + 0.5 * y / pen.half_length;
    let across = 1.0 - pen.dome * (s * s).min(1.0);
    // A roof with a rounded ridge, fading in from the base and out before its end.
    let roof = (1.0 - s.abs() / pen.keel_width).max(0.0);
    let roof = roof * (2.0 - roof) * roof;
    let along = num::saturate(t * 6.0) * num::saturate((pen.keel_length - t) * 8.0 + 1.0);
    pen.relief * ramp_profile(t, pen.peak) * across + pen.keel * roof * along
}

macro_rules! painter {
    ($(#[$doc:meta])* $name:ident, |$pen:ident, $x:ident, $y:ident| $distance:expr, $body:expr) => {
        multiversion! {
            $(#[$doc])*
            fn $name(
                pen: Pen,
                top: &mut [u32],
                height: &mut [f32],
                edge: &mut [f32],
                outline: &mut [f32],
                cover: &mut [f32],
            ) {
                let n = top.len();
                let (height, edge) = (&mut height[..n], &mut edge[..n]);
                let (outline, cover) = (&mut outline[..n], &mut cover[..n]);
                let $pen = &pen;
                for i in 0..n {
                    let dx = pen.x_mm + i as f32 * pen.step_mm;
                    let ($x, $y) = sdf::turn(dx, pen.y_mm, pen.cos, pen.sin);
                    let d = $distance;
                    let body = $body;
                    lay(&pen, d, body, &mut top[i], &mut height[i], &mut edge[i], &mut outline[i], &mut cover[i]);
                }
            }
        }
    };
}

painter! {
    /// Rhombus and hexagon.
    paint_facet, |pen, x, y|
    sdf::rounded_truncated_rhombus(x, y, pen.hx, pen.hy, pen.cut_x, pen.cut_y, pen.radius),
    body_height(pen, x, y)
}

painter! {
    /// Leaf.
    paint_leaf, |pen, x, y|
    sdf::vesica(x, y, pen.half_width, pen.half_length),
    body_height(pen, x, y)
}

painter! {
    /// Granule: a cone on a disc.
    paint_granule, |pen, x, y|
    sdf::disc(x, y, pen.half_width.min(pen.half_length)),
    {
        let r = pen.half_width.min(pen.half_length);
        let c = num::saturate(1.0 - sdf::length(x, y) / r);
        pen.relief * (c * (1.0 - 0.35 * c) / 0.65) + pen.keel * c * c * c
    }
}

painter! {
    /// Scute: a wide band whose free edge bows toward the tail.
    paint_scute, |pen, x, y|
    {
        let s = x / pen.half_width;
        let bowed = y + 0.5 * pen.half_length * (s * s).min(4.0);
        sdf::rounded_box(x, bowed, pen.half_width, pen.half_length, pen.radius)
    },
    {
        let s = x / pen.half_width;
        // The ends sink to the base, so that the lowest row can lie over them.
        let ends = 1.0 - num::smoothstep(0.8, 1.0, s.abs());
        ends * body_height(pen, x, y + 0.5 * pen.half_length * (s * s).min(4.0))
    }
}

/// Write what anybody reads of a painted band.
pub(super) fn write(table: &Table, domain: &Domain, band: &Band, outs: &mut Outputs<'_>) {
    let per_texel: [(usize, &[f32]); 3] =
        [(port::HEIGHT, &band.height), (port::COVER, &band.cover), (port::OUTLINE, &band.outline)];
    for (output, values) in per_texel {
        if let Some(out) = outs.band(output) {
            out.copy_from_slice(values);
        }
    }
    if let Some(out) = outs.band(port::EDGE) {
        for ((o, e), top) in out.iter_mut().zip(&band.edge).zip(&band.top) {
            *o = if *top == SKIN { 0.0 } else { *e };
        }
    }
    for output in port::S..port::COUNT {
        let Some(out) = outs.band(output) else { continue };
        for (y, (row, tops)) in
            band.rows.clone().zip(out.chunks_exact_mut(band.width).zip(band.top.chunks_exact(band.width)))
        {
            for (x, (o, &top)) in row.iter_mut().zip(tops).enumerate() {
                *o = match band.copies.get(top as usize) {
                    Some(copy) => property(output, copy, table, domain, x, y),
                    None => 0.0,
                };
            }
        }
    }
}

#[inline(always)]
fn property(output: usize, copy: &Copy, table: &Table, domain: &Domain, x: usize, y: i64) -> f32 {
    let scale = &table.scales[copy.scale];
    let local = || {
        let dx = domain.u(x) * domain.girth_mm - (scale.x_mm + 0.5 * domain.girth_mm);
        let dx = num::wrap_half(dx / domain.girth_mm) * domain.girth_mm;
        let dy = domain.v(y) * domain.length_mm - copy.y_mm;
        (dx, dy)
    };
    match output {
        port::S | port::T => {
            let (dx, dy) = local();
            let (lx, ly) = sdf::turn(dx, dy, scale.axis[0], scale.axis[1]);
            if output == port::S {
                (lx / scale.half_width_mm).clamp(-1.0, 1.0)
            } else {
                num::saturate(0.5 + 0.5 * ly / scale.half_length_mm)
            }
        }
        port::DU => -local().0 / domain.girth_mm,
        port::DV => -local().1 / domain.length_mm,
        port::RANDOM => scale.random,
        port::ID => (copy.scale + 1) as f32,
        port::ROW => scale.row,
        port::COLUMN => scale.column as f32,
        port::KIND => {
            if copy.is_scute {
                2.0
            } else {
                1.0
            }
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::ScaleLattice;
    use super::*;
    use crate::eval::run_node;
    use crate::node::Assets;

    fn run(lattice: &ScaleLattice, domain: &Domain, band: usize) -> Vec<crate::base::Plane> {
        run_node(lattice, domain, 5, &[], &Assets::new(), band)
    }

    #[test]
    fn a_close_set_rhomb_lattice_covers_the_back() {
        let lattice = ScaleLattice {
            apex: 1.0,
            roundness: 0.0,
            width: 1.02,
            ventrals: 0,
            rows: 20,
            lowest: 1.0,
            jitter_position: 0.0,
            jitter_size: 0.0,
            jitter_rotation_deg: 0.0,
            ..ScaleLattice::default()
        };
        let planes = run(&lattice, &Domain::square(256), 0);
        let bare = planes[port::ID].data().iter().filter(|&&id| id == 0.0).count();
        assert!(bare < 66, "{bare} of 65536 texels are bare");
    }

    #[test]
    fn bands_do_not_change_a_bit() {
        let domain = Domain { width: 97, height: 131, girth_mm: 53.0, length_mm: 71.0 };
        for shape in [ScaleShape::Leaf, ScaleShape::Hexagon, ScaleShape::Granule] {
            let lattice = ScaleLattice { shape, keel: 0.1, oblique_deg: 20.0, ..ScaleLattice::default() };
            assert_eq!(run(&lattice, &domain, 0), run(&lattice, &domain, 7), "{shape:?}");
        }
    }

    #[test]
    fn the_scale_nearer_the_head_lies_over_the_next() {
        let lattice =
            ScaleLattice { rows: 1, count: 4, ventrals: 0, jitter_position: 0.0, ..ScaleLattice::default() };
        let planes = run(&lattice, &Domain::square(64), 0);
        // Just tail-ward of a tip the next scale begins, lower than the tip it disappears under.
        let (h, id) = (&planes[port::HEIGHT], &planes[port::ID]);
        for y in 0..64 {
            if id.at(32, y) != id.at(32, y + 1) && id.at(32, y) != 0.0 && id.at(32, y + 1) != 0.0 {
                assert!(h.at(32, y - 2) > h.at(32, y + 2), "at {y}");
            }
        }
    }

    #[test]
    fn extremes_are_finite() {
        for lattice in [
            ScaleLattice {
                rows: 1,
                count: 1,
                ventrals: 1,
                overlap: 2.0,
                size: 2.0,
                width: 2.0,
                ..Default::default()
            },
            ScaleLattice { rows: 1000, count: 1000, ventrals: 0, ..Default::default() },
            ScaleLattice { size: 0.05, relief: 0.0, bevel: 0.0, ..Default::default() },
        ] {
            for domain in
                [Domain::square(1), Domain::square(33), Domain { length_mm: 1e6, ..Domain::square(16) }]
            {
                for plane in run(&lattice, &domain, 0) {
                    assert!(plane.data().iter().all(|v| v.is_finite() && v.abs() < 1e9));
                }
            }
        }
    }
}
