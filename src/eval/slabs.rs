//! Running a plan slab by slab: every stage over some hundred rows, then the next rows, with what is looked back at kept.

use std::collections::BTreeMap;
use std::ops::Range;

use super::run::{Cancelled, ConstantRows, Control, Runner};
use crate::base::pages::Pages;
use crate::base::{MapKind, Rows};
use crate::plan::{LaneSource, Plan, Slabs, Stage};

/// Rows of a map that are ready.
#[derive(Debug)]
pub struct MapRows<'a> {
    /// The channels; every row from the one that was asked for to the end of the slab is there.
    pub lanes: Vec<Rows<'a>>,
}

/// Why a plan stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped<E> {
    /// The caller's flag was set.
    Cancelled(Cancelled),
    /// The caller's own reason.
    By(E),
}

/// The rows of a lane that are held: the first `held` values of `data`, which begin with row `first`; it may lie before the
/// torus' row 0. What lies behind them is room.
#[derive(Debug)]
pub(super) struct Window {
    data: Pages,
    held: usize,
    first: i64,
}

impl Window {
    pub(super) fn rows(&self, width: usize, height: usize) -> Rows<'_> {
        Rows::window(&self.data[..self.held], width, height, self.first)
    }

    /// Room for so many values, whose pages are the threads' to touch that write them.
    fn new(values: usize) -> Self {
        Self { data: Pages::new(values), held: 0, first: 0 }
    }

    /// Forget the rows before `keep`, make room for those up to `end`, and return the room for rows from `from` on, all of
    /// which is to be written.
    fn roll(&mut self, width: usize, keep: i64, from: i64, end: i64) -> &mut [f32] {
        if self.held == 0 {
            self.first = from;
        }
        let keep = keep.clamp(self.first, from);
        let gone = (keep - self.first) as usize * width;
        self.data.copy_within(gone.min(self.held)..self.held, 0);
        self.first = keep;
        self.held = (end - keep) as usize * width;
        self.data.grow(self.held);
        &mut self.data[(from - keep) as usize * width..self.held]
    }
}

/// Run a plan slab by slab on the current rayon pool. After each slab `ready` is handed the maps and the row that the
/// slab ends before; it returns the first row of each map that it wants to see again.
///
/// The values do not depend on the slabs: they are those of [`super::run()`].
///
/// # Errors
/// [`Stopped`]: the caller's flag was set, or `ready` failed.
pub fn run_slabs<E>(
    plan: &Plan,
    slabs: &Slabs,
    control: Control<'_>,
    mut ready: impl FnMut(&BTreeMap<MapKind, MapRows<'_>>, usize) -> Result<BTreeMap<MapKind, usize>, E>,
) -> Result<(), Stopped<E>> {
    let mut runner = Runner::new(plan, control);
    let (width, height) = (plan.domain.width, plan.domain.height);
    for stage in &plan.stages[..slabs.whole] {
        runner.stage(stage).map_err(Stopped::Cancelled)?;
    }
    for stage in &plan.stages[slabs.whole..] {
        runner.prepare(stage);
    }
    let constants = ConstantRows::of_sources(plan.maps.values().flat_map(|m| &m.lanes), width);
    // How far each stage is, and the first row that is still wanted of each map.
    let mut done: Vec<i64> = slabs.ahead.iter().map(|&rows| -(rows as i64)).collect();
    let mut wanted: BTreeMap<MapKind, usize> = plan.maps.keys().map(|&kind| (kind, 0)).collect();
    for first in (0..height).step_by(slabs.rows) {
        let end = (first + slabs.rows).min(height);
        for (k, stage) in plan.stages.iter().enumerate().skip(slabs.whole) {
            let to = (end + slabs.ahead[k]) as i64;
            let keep = keep(plan, k, &done, &wanted);
            let room = |lane| width * slabs.window_rows(k, lane);
            runner.slab(stage, done[k]..to, &keep, room).map_err(Stopped::Cancelled)?;
            done[k] = to;
        }
        let lanes = |sources: &[LaneSource]| {
            let rows = |source: &LaneSource| match source {
                LaneSource::Const(v) => constants.get(*v),
                LaneSource::Lane(id) => runner.read(*id),
            };
            MapRows { lanes: sources.iter().map(rows).collect() }
        };
        let maps: BTreeMap<MapKind, MapRows<'_>> =
            plan.maps.iter().map(|(&kind, map)| (kind, lanes(&map.lanes))).collect();
        wanted = ready(&maps, end).map_err(Stopped::By)?;
        runner.check().map_err(Stopped::Cancelled)?;
    }
    runner.end();
    Ok(())
}

/// The first row that is still read of each lane that stage `k` writes, before it goes on.
fn keep(plan: &Plan, k: usize, done: &[i64], wanted: &BTreeMap<MapKind, usize>) -> BTreeMap<usize, i64> {
    let mut keep: BTreeMap<usize, i64> = BTreeMap::new();
    let mut least = |lane: usize, row: i64| {
        let kept = keep.entry(lane).or_insert(row);
        *kept = row.min(*kept);
    };
    for (j, stage) in plan.stages.iter().enumerate().skip(k + 1) {
        for &s in &stage.rows {
            let step = &plan.steps[s];
            for lane in step.passes.iter().flat_map(|p| &p.inputs).filter_map(LaneSource::lane) {
                least(lane, done[j] - Slabs::reach(step.reach) as i64);
            }
        }
    }
    for (kind, map) in &plan.maps {
        for lane in map.lanes.iter().filter_map(LaneSource::lane) {
            least(lane, wanted.get(kind).map_or(0, |&row| row as i64));
        }
    }
    keep
}

impl Runner<'_> {
    /// Rows of a stage: those of the torus, or beyond its seam.
    fn slab(
        &mut self,
        stage: &Stage,
        rows: Range<i64>,
        keep: &BTreeMap<usize, i64>,
        room: impl Fn(usize) -> usize,
    ) -> Result<(), Cancelled> {
        let (width, height) = (self.plan.domain.width, self.plan.domain.height);
        let ids = self.planes_of(stage);
        let mut windows: Vec<Window> =
            ids.iter().map(|&id| self.windows[id].take().unwrap_or_else(|| Window::new(room(id)))).collect();
        let parts: Vec<&mut [f32]> = (windows.iter_mut().zip(&ids))
            .map(|(window, id)| {
                let keep = keep.get(id).copied().unwrap_or(rows.end);
                window.roll(width, keep, rows.start, rows.end)
            })
            .collect();
        let result = self.bands(
            stage,
            &ids,
            &cuts(rows, stage.band_rows, height, rayon::current_num_threads()),
            parts,
        );
        for (id, window) in ids.into_iter().zip(windows) {
            self.windows[id] = Some(window);
        }
        result
    }
}

/// Rows cut into bands, none of which crosses the seam: first row on the torus, and number. The last ones are smaller, so that
/// so many threads end at about the same time.
pub(super) fn cuts(rows: Range<i64>, band: usize, height: usize, threads: usize) -> Vec<(usize, usize)> {
    let mut cuts = Vec::new();
    let mut at = rows.start;
    while at < rows.end {
        let first = at.rem_euclid(height as i64) as usize;
        let left = (rows.end - at) as usize;
        let count = band.min(left.div_ceil(2 * threads.max(1))).min(height - first);
        cuts.push((first, count));
        at += count as i64;
    }
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_do_not_cross_the_seam() {
        assert_eq!(cuts(-5..9, 4, 12, 1), [(7, 4), (11, 1), (0, 4), (4, 3), (7, 1), (8, 1)]);
        assert_eq!(cuts(10..30, 16, 12, 1), [(10, 2), (0, 9), (9, 3), (0, 3), (3, 2), (5, 1)]);
        assert!(cuts(3..3, 4, 12, 2).is_empty());
        let cut = cuts(0..100, 8, 100, 2);
        assert_eq!((cut[0], cut[1], cut[cut.len() - 1]), ((0, 8), (8, 8), (99, 1)));
        assert_eq!(cut.iter().map(|(_, rows)| rows).sum::<usize>(), 100);
    }

    #[test]
    fn a_window_keeps_what_is_wanted_and_takes_what_follows() {
        let mut window = Window::new(0);
        window.roll(2, -3, -3, 2).iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
        assert_eq!(window.rows(2, 8).row(-3), [0.0, 1.0]);
        assert_eq!(window.rows(2, 8).row(9), [8.0, 9.0]);
        window.roll(2, 0, 2, 3).fill(7.0);
        assert_eq!((window.first, window.held), (0, 6));
        assert_eq!((window.rows(2, 8).row(0), window.rows(2, 8).row(2)), (&[6.0, 7.0][..], &[7.0, 7.0][..]));
        // Nothing is wanted of it: it holds the new rows only.
        window.roll(2, 9, 3, 5).fill(1.0);
        assert_eq!((window.first, window.held), (3, 4));
    }
}
