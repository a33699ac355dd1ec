//! The instance table: every scale's frame, once.

use super::scale_lattice::{ScaleLattice, ScaleShape};
use crate::base::{Domain, hash, num};

/// One scale or scute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// Centre around the body, mm from the mid-back.
    pub(super) x_mm: f32,
    /// Centre along the body, mm; may lie a little outside the tile.
    pub(super) y_mm: f32,
    /// Half width, mm.
    pub(super) half_width_mm: f32,
    /// Half length, mm.
    pub(super) half_length_mm: f32,
    /// Turn of its axis from the body's, as (cos, sin).
    pub(super) axis: [f32; 2],
    /// Relief, mm.
    pub(super) relief_mm: f32,
    /// Keel, mm.
    pub(super) keel_mm: f32,
    /// Random number in [0, 1).
    pub(super) random: f32,
    /// Row from the mid-back.
    pub(super) row: f32,
    /// Index along its row.
    pub(super) column: u32,
}

/// What all scales of a kind share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form {
    pub(super) shape: ScaleShape,
    pub(super) is_scute: bool,
    pub(super) apex: f32,
    pub(super) roundness: f32,
    pub(super) peak: f32,
    pub(super) dome: f32,
    pub(super) bevel_mm: f32,
    pub(super) keel_width: f32,
    pub(super) keel_length: f32,
}

/// A row of scales at equal steps along the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Index of its first scale in the table.
    pub(super) first: usize,
    /// Scales in it.
    pub(super) count: u32,
    /// Where scale 0 lies along the body before jitter, mm.
    pub(super) start_mm: f32,
    /// Step along the body, mm.
    pub(super) pitch_mm: f32,
    /// How far any of its scales reaches from its unjittered centre along the body, mm.
    pub(super) reach_mm: f32,
    /// Scutes are painted below every dorsal scale.
    pub(super) is_scute: bool,
}

/// All scales of a tile.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) scales: Vec<Scale>,
    pub(super) rows: Vec<Row>,
    pub(super) dorsal: Form,
    pub(super) ventral: Form,
}

/// Hash channels of a scale's random numbers.
const POSITION_X: u32 = 1;
const POSITION_Y: u32 = 2;
const SIZE: u32 = 3;
const ROTATION: u32 = 4;
const HEIGHT: u32 = 5;
const VALUE: u32 = 6;

impl Table {
    pub(super) fn new(lattice: &ScaleLattice, domain: &Domain, seed: u32) -> Self {
        let has_scutes = lattice.ventrals > 0 && lattice.ventral_width > 0.0;
        let ventral_share = if has_scutes { lattice.ventral_width } else { 0.0 };
        let back_mm = domain.girth_mm * (1.0 - ventral_share);
        let pitch_mm = domain.length_mm / lattice.count as f32;
        let width_pitch_mm = back_mm / lattice.rows as f32;
        let mut table = Self {
            scales: Vec::with_capacity((lattice.rows * lattice.count + lattice.ventrals) as usize),
            rows: Vec::with_capacity(lattice.rows as usize + 1),
            dorsal: Form {
                shape: lattice.shape,
                is_scute: false,
                apex: lattice.apex,
                roundness: lattice.roundness,
                peak: lattice.peak,
                dome: lattice.dome,
                bevel_mm: lattice.bevel * width_pitch_mm,
                keel_width: lattice.keel_width,
                keel_length: lattice.keel_length,
            },
            ventral: Form {
                shape: ScaleShape::Rhombus,
                is_scute: true,
                apex: 0.0,
                roundness: 0.6,
                peak: lattice.peak,
                dome: 0.05,
                bevel_mm: lattice.bevel * width_pitch_mm,
                keel_width: 1.0,
                keel_length: 0.0,
            },
        };
        if has_scutes {
            table.push_scutes(lattice, domain, seed);
        }
        table.push_dorsals(lattice, domain, seed, back_mm, pitch_mm);
        table
    }

    fn push_scutes(&mut self, lattice: &ScaleLattice, domain: &Domain, seed: u32) {
        let pitch_mm = domain.length_mm / lattice.ventrals as f32;
        let half_length_mm = 0.5 * pitch_mm * (1.0 + lattice.overlap.min(0.5)) * lattice.size.max(0.9);
        let row = Row {
            first: self.scales.len(),
            count: lattice.ventrals,
            start_mm: 0.5 * pitch_mm,
            pitch_mm,
            reach_mm: half_length_mm * 1.6 + pitch_mm,
            is_scute: true,
        };
        let seed = hash::hash1(seed, 0x5c07);
        for column in 0..lattice.ventrals {
            let random = |channel| hash::signed(hash::hash2(seed, column, channel));
            self.scales.push(Scale {
                // The belly's middle is the tile's seam.
                x_mm: 0.5 * domain.girth_mm,
                y_mm: row.start_mm
                    + pitch_mm * column as f32
                    + 0.3 * lattice.jitter_position * pitch_mm * random(POSITION_Y),
                // Scutes tuck under the lowest row.
                half_width_mm: 0.5 * lattice.ventral_width * domain.girth_mm * 1.06,
                half_length_mm: half_length_mm * (1.0 + 0.5 * lattice.jitter_size * random(SIZE)),
                axis: [1.0, 0.0],
                relief_mm: lattice.ventral_relief * pitch_mm * (1.0 + lattice.jitter_height * random(HEIGHT)),
                keel_mm: 0.0,
                random: hash::unit(hash::hash2(seed, column, VALUE)),
                row: 0.5 * lattice.rows as f32 + 0.5,
                column,
            });
        }
        self.rows.push(row);
    }

    fn push_dorsals(
        &mut self,
        lattice: &ScaleLattice,
        domain: &Domain,
        seed: u32,
        back_mm: f32,
        pitch_mm: f32,
    ) {
        let widths = row_widths(lattice, back_mm);
        let slant = lattice.oblique_deg / 360.0;
        let (slant_cos, slant_sin) = (num::cos_turns(slant), num::sin_turns(slant));
        let tan = slant_sin / slant_cos;
        let half = 0.5 * (lattice.rows as f32 - 1.0);
        let mut left_mm = -0.5 * back_mm;
        for (j, &width_mm) in widths.iter().enumerate() {
            let x_mm = left_mm + 0.5 * width_mm;
            left_mm += width_mm;
            let row = j as f32 - half;
            // Rows alternate by half a pitch from the mid-back out, so that the lattice is its own mirror image.
            let parity =
                if lattice.rows % 2 == 1 { (j as i64 - half as i64).rem_euclid(2) } else { (j % 2) as i64 };
            let start_mm = pitch_mm * (0.5 + 0.5 * parity as f32) + x_mm.abs() * tan;
            let side = if x_mm > 1e-6 {
                1.0
            } else if x_mm < -1e-6 {
                -1.0
            } else {
                0.0
            };
            let keel_mm = lattice.keel * width_mm * keel_share(row.abs() / half.max(1.0), lattice.keel_rows);
            let longest =
                0.5 * pitch_mm * (1.0 + lattice.overlap) * lattice.size * (1.0 + lattice.jitter_size);
            let widest = width_mm * lattice.width * lattice.size * (1.0 + lattice.jitter_size);
            self.rows.push(Row {
                first: self.scales.len(),
                count: lattice.count,
                start_mm,
                pitch_mm,
                reach_mm: (longest * longest + widest * widest).sqrt() + (1.0 + lattice.overlap) * pitch_mm,
                is_scute: false,
            });
            let row_seed = hash::hash1(seed, j as u32);
            for column in 0..lattice.count {
                let random = |channel| hash::signed(hash::hash2(row_seed, column, channel));
                let size = lattice.size * (1.0 + lattice.jitter_size * random(SIZE));
                let turn =
                    (side * lattice.oblique_deg + lattice.jitter_rotation_deg * random(ROTATION)) / 360.0;
                let half_length_mm = 0.5 * pitch_mm * (1.0 + lattice.overlap) * size;
                self.scales.push(Scale {
                    x_mm: x_mm + lattice.jitter_position * width_mm * random(POSITION_X),
                    // The tip keeps its place when the base grows under the scale before it.
                    y_mm: start_mm + pitch_mm * column as f32 - 0.5 * pitch_mm * lattice.overlap * size
                        + lattice.jitter_position * pitch_mm * random(POSITION_Y),
                    half_width_mm: width_mm * lattice.width * size,
                    half_length_mm,
                    axis: [num::cos_turns(turn), num::sin_turns(turn)],
                    relief_mm: lattice.relief * pitch_mm * (1.0 + lattice.jitter_height * random(HEIGHT)),
                    keel_mm,
                    random: hash::unit(hash::hash2(row_seed, column, VALUE)),
                    row,
                    column,
                });
            }
        }
        let _ = domain;
    }
}

/// Widths of the rows, left to right, mm; they add up to the back.
fn row_widths(lattice: &ScaleLattice, back_mm: f32) -> Vec<f32> {
    let n = lattice.rows as usize;
    let half = 0.5 * (n as f32 - 1.0);
    let mut widths: Vec<f32> = (0..n)
        .map(|j| {
            let from_middle = (j as f32 - half).abs();
            let from_belly = half - from_middle;
            let growth = num::saturate(1.0 - from_belly / lattice.lowest_rows);
            let vertebral = if from_middle < 0.25 { lattice.vertebral } else { 1.0 };
            (1.0 + (lattice.lowest - 1.0) * growth) * vertebral
        })
        .collect();
    let total: f32 = widths.iter().sum();
    for width in &mut widths {
        *width *= back_mm / total;
    }
    widths
}

impl ScaleLattice {
    /// Share of the girth between the mid-back and the line `row` rows from it, at most half of the back.
    ///
    /// `row` counts from the middle of the mid-back row (or, with even counts, from the line between the two).
    pub fn row_position(&self, row: f32) -> f32 {
        let has_scutes = self.ventrals > 0 && self.ventral_width > 0.0;
        let back = 1.0 - if has_scutes { self.ventral_width } else { 0.0 };
        let widths = row_widths(self, back);
        let (mut left, mut position) = (row.max(0.0), 0.0);
        let middle = widths.len() / 2;
        // The mid-back row counts half on each side.
        let mut share = if widths.len() % 2 == 1 { 0.5 } else { 1.0 };
        for width in &widths[middle..] {
            let step = left.min(share);
            position += width * step;
            left -= step;
            share = 1.0;
        }
        position
    }
}

/// 1 on keeled rows, 0 past them, fading over the last fifth; `at` is 0 on the mid-back and 1 on the lowest row.
fn keel_share(at: f32, rows: f32) -> f32 {
    if rows >= 1.0 { 1.0 } else { 1.0 - num::smoothstep(rows - 0.2, rows, at) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_fill_the_back_and_mirror_about_the_middle() {
        let lattice = ScaleLattice { jitter_position: 0.0, oblique_deg: 20.0, ..ScaleLattice::default() };
        let domain = Domain { width: 64, height: 64, girth_mm: 53.4, length_mm: 80.0 };
        let widths = row_widths(&lattice, 36.0);
        assert!((widths.iter().sum::<f32>() - 36.0).abs() < 1e-3);
        let table = Table::new(&lattice, &domain, 7);
        let rows: Vec<&Row> = table.rows.iter().filter(|r| !r.is_scute).collect();
        for (a, b) in rows.iter().zip(rows.iter().rev()) {
            let (a, b) = (&table.scales[a.first], &table.scales[b.first]);
            assert!((a.x_mm + b.x_mm).abs() < 1e-3 && (a.y_mm - b.y_mm).abs() < 0.2, "{a:?} {b:?}");
        }
    }

    #[test]
    fn neighbouring_rows_are_offset_by_half_a_pitch() {
        let lattice = ScaleLattice::default();
        let table = Table::new(&lattice, &Domain::square(64), 7);
        let rows: Vec<&Row> = table.rows.iter().filter(|r| !r.is_scute).collect();
        for pair in rows.windows(2) {
            let step = (pair[0].start_mm - pair[1].start_mm).abs() / pair[0].pitch_mm;
            assert!((step - 0.5).abs() < 1e-4, "{step}");
        }
    }
}
