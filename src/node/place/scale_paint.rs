//! Painting the instance table into a band of rows: each scale over its bounding box, bottom to top.
//!
//! A texel looks only at scales whose box holds it; shapes are analytic, so nothing depends on resolution. Scales are
//! painted from the tail to the head, because each lies over the base of the next one tail-ward; on the torus the order
//! is taken over the copies that a band can see.

use std::ops::Range;

use super::scale_lattice::{ScaleShape, texel_mm};
use super::scale_lay::{LANES, Pen, Run, lay_facet, lay_granule, lay_leaf, lay_scute};
use super::scale_table::{Form, Scale, Table};
use crate::base::Domain;

/// A scale as a band sees it: index in the table, and the copy of the tile it comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Copy {
    pub(super) scale: usize,
    /// Centre along the body in the band's unwrapped coordinates, mm.
    pub(super) y_mm: f32,
    pub(super) is_scute: bool,
    extent: Extent,
}

/// The texels of a scale's box.
#[derive(Clone, Copy, Debug)]
struct Extent {
    /// Columns in unwrapped coordinates, at most one turn around the body.
    columns: [i64; 2],
    /// Rows, all of them in the band.
    rows: [i64; 2],
}

/// No scale under the texel.
pub(super) const SKIN: u32 = u32::MAX;

/// The painted band: per texel the topmost scale and the running results.
pub(super) struct Band {
    pub(super) rows: Range<i64>,
    pub(super) width: usize,
    /// Texels from a row to the next: kernels may pass over the end of a row by less than [`LANES`].
    pub(super) stride: usize,
    pub(super) copies: Vec<Copy>,
    pub(super) top: Vec<u32>,
    pub(super) height: Vec<f32>,
    pub(super) edge: Vec<f32>,
    pub(super) outline: Vec<f32>,
    pub(super) cover: Vec<f32>,
}

impl Band {
    pub(super) fn stride(domain: &Domain) -> usize {
        domain.width.next_multiple_of(LANES) + LANES
    }

    /// Bytes of a band of `rows` rows.
    pub(super) fn bytes(domain: &Domain, rows: usize) -> u64 {
        (5 * 4 * Self::stride(domain) * rows) as u64
    }

    /// Room for bands of this domain.
    pub(super) fn new(domain: &Domain) -> Self {
        Self {
            rows: 0..0,
            width: domain.width,
            stride: Self::stride(domain),
            copies: Vec::new(),
            top: Vec::new(),
            height: Vec::new(),
            edge: Vec::new(),
            outline: Vec::new(),
            cover: Vec::new(),
        }
    }

    /// Bare skin on these rows.
    fn clear(&mut self, rows: Range<i64>) {
        let texels = (rows.end - rows.start) as usize * self.stride;
        self.rows = rows;
        let fill = |plane: &mut Vec<f32>, value| {
            plane.resize(texels, value);
            plane.fill(value);
        };
        self.top.resize(texels, SKIN);
        self.top.fill(SKIN);
        fill(&mut self.height, 0.0);
        // Larger than any scale: the distance to a border that is not there.
        fill(&mut self.edge, f32::MAX);
        fill(&mut self.outline, 0.0);
        fill(&mut self.cover, 0.0);
    }

    /// Where row `y` stands in the band's planes.
    pub(super) fn row(&self, y: i64) -> Range<usize> {
        let start = (y - self.rows.start) as usize * self.stride;
        start..start + self.width
    }
}

/// Paint every scale that these rows can see.
pub(super) fn paint(table: &Table, domain: &Domain, rows: Range<i64>, band: &mut Band) {
    band.clear(rows);
    visible(table, domain, &band.rows, &mut band.copies);
    for i in 0..band.copies.len() {
        let copy = band.copies[i];
        let form = if copy.is_scute { &table.ventral } else { &table.dorsal };
        paint_one(&table.scales[copy.scale], form, &copy, i as u32, domain, band);
    }
}

/// Copies of scales whose boxes hold texels of the rows, tail-most first: the order they are painted in.
fn visible(table: &Table, domain: &Domain, rows: &Range<i64>, copies: &mut Vec<Copy>) {
    let texel = domain.texel_v_mm();
    let (top_mm, bottom_mm) = (rows.start as f32 * texel, rows.end as f32 * texel);
    copies.clear();
    for row in &table.rows {
        let reach = row.reach_mm + texel_mm(domain);
        let first = ((top_mm - reach - row.start_mm) / row.pitch_mm).floor() as i64;
        let last = ((bottom_mm + reach - row.start_mm) / row.pitch_mm).ceil() as i64;
        for i in first..=last {
            let column = i.rem_euclid(i64::from(row.count));
            let wraps = (i - column) / i64::from(row.count);
            let scale = row.first + column as usize;
            let y_mm = table.scales[scale].y_mm + wraps as f32 * domain.length_mm;
            if let Some(extent) = extent(&table.scales[scale], y_mm, domain, rows) {
                copies.push(Copy { scale, y_mm, is_scute: row.is_scute, extent });
            }
        }
    }
    // No two are equal: they differ in the scale, or by a tile's length.
    copies.sort_unstable_by(|a, b| {
        b.is_scute
            .cmp(&a.is_scute)
            .then_with(|| b.y_mm.total_cmp(&a.y_mm))
            .then_with(|| a.scale.cmp(&b.scale))
    });
}

/// The box of the turned outline, cut by the rows; `None` where nothing is left.
fn extent(scale: &Scale, y_mm: f32, domain: &Domain, rows: &Range<i64>) -> Option<Extent> {
    let (texel_u, texel_v) = (domain.texel_u_mm(), domain.texel_v_mm());
    let [cos, sin] = scale.axis;
    let (a, b) = (scale.half_width_mm, scale.half_length_mm);
    // The margin lets a scale's outside bound the edges of those beneath.
    let margin = a.min(b) * 0.5 + 2.0 * texel_u.max(texel_v);
    let box_x = a * cos.abs() + b * sin.abs() + margin;
    let box_y = b * cos.abs() + a * sin.abs() + margin;
    let y0 = (((y_mm - box_y) / texel_v - 0.5).ceil() as i64).max(rows.start);
    let y1 = (((y_mm + box_y) / texel_v - 0.5).floor() as i64 + 1).min(rows.end);
    let centre_x = scale.x_mm + 0.5 * domain.girth_mm;
    let mut first = ((centre_x - box_x) / texel_u - 0.5).ceil() as i64;
    let mut last = ((centre_x + box_x) / texel_u - 0.5).floor() as i64 + 1;
    if last - first > domain.width as i64 {
        // Wider than the girth: each texel once, from the side where the scale is nearest.
        first = (centre_x / texel_u) as i64 - domain.width as i64 / 2;
        last = first + domain.width as i64;
    }
    (first < last && y0 < y1).then_some(Extent { columns: [first, last], rows: [y0, y1] })
}

fn paint_one(scale: &Scale, form: &Form, copy: &Copy, number: u32, domain: &Domain, band: &mut Band) {
    let (texel_u, texel_v) = (domain.texel_u_mm(), domain.texel_v_mm());
    let (a, b) = (scale.half_width_mm, scale.half_length_mm);
    let flat = 1.0 - form.apex;
    let (hx, hy, radius) = match (form.is_scute, form.shape) {
        (true, _) => (a, b, form.roundness * b),
        (_, ScaleShape::Rhombus) => {
            (a * (1.0 + 0.35 * flat), b * (1.0 + 0.2 * flat), form.roundness * 0.6 * a.min(b))
        }
        (_, ScaleShape::Hexagon) => (a * (1.7 + 1.6 * flat), b, form.roundness * 0.6 * a.min(b)),
        (_, ScaleShape::Leaf | ScaleShape::Granule) => (a, b, 0.0),
    };
    let ramp = (texel_u * texel_v).sqrt();
    // A rim or keel narrower than a texel would alias: it is as wide as the grid can hold, a keel lower by as much.
    let keel_width = form.keel_width.max((1.5 * ramp / a.max(1e-9)).min(1.0));
    let pen = Pen {
        cos: scale.axis[0],
        sin: scale.axis[1],
        half_width: a,
        half_length: b,
        hx,
        hy,
        radius,
        relief: scale.relief_mm,
        dome: form.dome,
        peak: form.peak,
        bevel: form.bevel_mm.max(ramp),
        keel: scale.keel_mm * form.keel_width / keel_width,
        keel_width,
        keel_length: form.keel_length,
        ramp,
        number,
        step_mm: texel_u,
    };
    let lay = match (form.is_scute, form.shape) {
        (true, _) => lay_scute,
        (_, ScaleShape::Leaf) => lay_leaf,
        (_, ScaleShape::Granule) => lay_granule,
        (_, ScaleShape::Rhombus | ScaleShape::Hexagon) => lay_facet,
    };
    let centre_x = scale.x_mm + 0.5 * domain.girth_mm;
    let Extent { columns: [mut x, last], rows } = copy.extent;
    // The box's columns, cut where they cross the seam.
    while x < last {
        let column = x.rem_euclid(domain.width as i64) as usize;
        let len = ((last - x) as usize).min(domain.width - column);
        let run =
            Run { column, len, x_mm: (x as f32 + 0.5) * texel_u - centre_x, y_mm: copy.y_mm, texel_v, rows };
        lay(&pen, &run, band);
        x += len as i64;
    }
}

#[cfg(test)]
mod tests {
    use super::super::ScaleLattice;
    use super::super::scale_lattice::port;
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
