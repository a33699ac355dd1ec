//! What a painted band says of its texels, written to the outputs.

use super::scale_lattice::port;
use super::scale_lay::LANES;
use super::scale_paint::{Band, SKIN};
use super::scale_table::{Scale, Table};
use crate::base::{Domain, num, sdf};
use crate::multiversion;
use crate::node::Outputs;
use crate::node::generate::columns;

/// One row of each output that a scale tells: [`port::S`] and what follows. It runs over by less than [`LANES`].
pub(super) struct Line {
    values: [Vec<f32>; port::COUNT],
    /// u of the columns.
    us: Vec<f32>,
}

impl Line {
    pub(super) fn new(domain: &Domain) -> Self {
        let stride = Band::stride(domain);
        Self { values: std::array::from_fn(|_| vec![0.0; stride]), us: columns(domain, stride) }
    }
}

/// A run of texels under one scale.
struct Run<'a> {
    scale: &'a Scale,
    first: usize,
    len: usize,
    /// From the scale's centre to the row, along the body, mm.
    dy_mm: f32,
    girth_mm: f32,
    length_mm: f32,
}

/// Write what anybody reads of a painted band.
pub(super) fn write(table: &Table, domain: &Domain, band: &Band, line: &mut Line, outs: &mut Outputs<'_>) {
    let wanted: Vec<usize> = (port::S..port::COUNT).filter(|&output| outs.wants(output)).collect();
    let wants_local = wanted.iter().any(|&output| output <= port::DV);
    for y in band.rows.clone() {
        let span = band.row(y);
        let top = &band.top[span.clone()];
        let per_texel: [(usize, &[f32]); 3] =
            [(port::HEIGHT, &band.height), (port::COVER, &band.cover), (port::OUTLINE, &band.outline)];
        for (output, values) in per_texel {
            if let Some(out) = outs.row(output, y) {
                out.copy_from_slice(&values[span.clone()]);
            }
        }
        if let Some(out) = outs.row(port::EDGE, y) {
            edges(&band.edge[span], top, out);
        }
        if wanted.is_empty() {
            continue;
        }
        let v_mm = domain.v(y) * domain.length_mm;
        let mut first = 0;
        while first < top.len() {
            let number = top[first];
            let len = 1 + top[first + 1..].iter().take_while(|&&t| t == number).count();
            match band.copies.get(number as usize) {
                Some(copy) => {
                    let scale = &table.scales[copy.scale];
                    if wants_local {
                        let run = Run {
                            scale,
                            first,
                            len,
                            dy_mm: v_mm - copy.y_mm,
                            girth_mm: domain.girth_mm,
                            length_mm: domain.length_mm,
                        };
                        local(&run, line);
                    }
                    for &output in &wanted {
                        let value = match output {
                            port::RANDOM => scale.random,
                            port::ID => (copy.scale + 1) as f32,
                            port::ROW => scale.row,
                            port::COLUMN => scale.column as f32,
                            port::KIND if copy.is_scute => 2.0,
                            port::KIND => 1.0,
                            _ => continue,
                        };
                        line.values[output][first..first + len].fill(value);
                    }
                }
                None => {
                    for &output in &wanted {
                        line.values[output][first..first + len].fill(0.0);
                    }
                }
            }
            first += len;
        }
        for &output in &wanted {
            if let Some(out) = outs.row(output, y) {
                out.copy_from_slice(&line.values[output][..band.width]);
            }
        }
    }
}

multiversion! {
    fn edges(edge: &[f32], top: &[u32], out: &mut [f32]) {
        for ((o, e), top) in out.iter_mut().zip(edge).zip(top) { *o = if *top == SKIN { 0.0 } else { *e }; }
    }
}

multiversion! {
    /// Where the texels of a run lie in their scale. Whole blocks of lanes: what it writes past the run, the next run
    /// writes again.
    fn local(run: &Run<'_>, line: &mut Line) {
        let scale = run.scale;
        let span = run.first..run.first + run.len.next_multiple_of(LANES);
        let places = line.values.get_disjoint_mut([port::S, port::T, port::DU, port::DV]);
        let Ok([s, t, du, dv]) = places else { return };
        let (us, _) = line.us[span.clone()].as_chunks::<LANES>();
        let (s, _) = s[span.clone()].as_chunks_mut::<LANES>();
        let (t, _) = t[span.clone()].as_chunks_mut::<LANES>();
        let (du, _) = du[span.clone()].as_chunks_mut::<LANES>();
        let (dv, _) = dv[span].as_chunks_mut::<LANES>();
        let centre_mm = scale.x_mm + 0.5 * run.girth_mm;
        let dy = run.dy_mm;
        for c in 0..us.len() {
            for l in 0..LANES {
                let dx = us[c][l] * run.girth_mm - centre_mm;
                let dx = num::wrap_half(dx / run.girth_mm) * run.girth_mm;
                let (x, y) = sdf::turn(dx, dy, scale.axis[0], scale.axis[1]);
                s[c][l] = (x / scale.half_width_mm).clamp(-1.0, 1.0);
                t[c][l] = num::saturate(0.5 + 0.5 * y / scale.half_length_mm);
                du[c][l] = -dx / run.girth_mm;
                dv[c][l] = -dy / run.length_mm;
            }
        }
    }
}
