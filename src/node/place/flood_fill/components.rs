//! Connected areas of a mask on the torus, by runs of texels and a union-find that knows who lies behind which seam.

use crate::base::{Rows, hash, num};

/// Texels `start .. end` of one row, all inside.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: u32,
    end: u32,
    parent: u32,
    /// Tiles from the parent's frame to this run's, in u and v.
    offset: [i32; 2],
    /// The area that the run's root stands for goes round the tile in u, v.
    winds: [bool; 2],
}

/// All runs, row by row.
pub(super) struct Runs {
    runs: Vec<Run>,
    /// First run of each row, and one past the last.
    rows: Vec<usize>,
}

/// One connected area.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Area {
    /// Least corner of the box around it, tile fractions; the area is unwrapped over the seams.
    pub(super) corner: [f64; 2],
    /// Size of the box; 1 where the area goes round the tile.
    pub(super) size: [f64; 2],
    /// Centre of mass, in [0, 1).
    pub(super) center: [f64; 2],
    /// Texels.
    pub(super) texels: u64,
    /// Random number in (0, 1].
    pub(super) id: f32,
    /// Whether it goes round the tile in u, v.
    pub(super) winds: [bool; 2],
}

impl Runs {
    /// The runs of texels of at least `threshold`, joined with their neighbours.
    pub(super) fn new(mask: Rows<'_>, height: usize, threshold: f32, diagonal: bool) -> Self {
        let mut found = Self { runs: Vec::new(), rows: vec![0] };
        for y in 0..height {
            found.scan(mask.row(y as i64), threshold);
        }
        let width = mask.width() as u32;
        for y in 0..height {
            found.join(y, (y + 1) % height, width, diagonal);
        }
        found
    }

    /// Runs of row `y`, by number.
    pub(super) fn row(&self, y: usize) -> std::ops::Range<usize> {
        self.rows[y]..self.rows[y + 1]
    }

    /// Texels of run `i`.
    pub(super) fn span(&self, i: usize) -> std::ops::Range<usize> {
        self.runs[i].start as usize..self.runs[i].end as usize
    }

    fn scan(&mut self, row: &[f32], threshold: f32) {
        let mut start = None;
        for (x, value) in row.iter().chain([&f32::MIN]).enumerate() {
            match (start, *value >= threshold && x < row.len()) {
                (None, true) => start = Some(x as u32),
                (Some(first), false) => {
                    let parent = self.runs.len() as u32;
                    let run = Run { start: first, end: x as u32, parent, offset: [0; 2], winds: [false; 2] };
                    self.runs.push(run);
                    start = None;
                }
                _ => {}
            }
        }
        self.rows.push(self.runs.len());
    }

    /// Join what touches within row `y`, over its seam, and with row `below`.
    fn join(&mut self, y: usize, below: usize, width: u32, diagonal: bool) {
        let (upper, lower) = (self.row(y), self.row(below));
        let down = i32::from(below <= y);
        let reach = u32::from(diagonal);
        if let (Some(first), Some(last)) = (upper.clone().next(), upper.clone().next_back())
            && self.runs[first].start == 0
            && self.runs[last].end == width
        {
            self.unite(last, first, [1, 0]);
        }
        let (mut a, mut b) = (upper.start, lower.start);
        while a < upper.end && b < lower.end {
            let (p, q) = (self.runs[a], self.runs[b]);
            if p.start < q.end + reach && q.start < p.end + reach {
                self.unite(a, b, [0, down]);
            }
            if p.end < q.end { a += 1 } else { b += 1 }
        }
        // Diagonal neighbours over the seam.
        if diagonal && !upper.is_empty() && !lower.is_empty() {
            if self.runs[upper.end - 1].end == width && self.runs[lower.start].start == 0 {
                self.unite(upper.end - 1, lower.start, [1, down]);
            }
            if self.runs[upper.start].start == 0 && self.runs[lower.end - 1].end == width {
                self.unite(upper.start, lower.end - 1, [-1, down]);
            }
        }
    }

    /// The root of a run and the tiles from the root's frame to the run's.
    fn find(&mut self, mut i: usize) -> (usize, [i32; 2]) {
        let mut total = [0, 0];
        loop {
            let parent = self.runs[i].parent as usize;
            if parent == i {
                return (i, total);
            }
            // Halve the path. A root's own offset is 0.
            let above = self.runs[parent];
            let run = &mut self.runs[i];
            run.parent = above.parent;
            run.offset = add(run.offset, above.offset);
            total = add(total, run.offset);
            i = run.parent as usize;
        }
    }

    /// `b` touches `a` and lies `step` tiles further than the grid says.
    fn unite(&mut self, a: usize, b: usize, step: [i32; 2]) {
        let ((root_a, at_a), (root_b, at_b)) = (self.find(a), self.find(b));
        let between = sub(add(at_a, step), at_b);
        if root_a == root_b {
            // Two ways to the same run that differ by tiles: the area goes round.
            for axis in 0..2 {
                self.runs[root_a].winds[axis] |= between[axis] != 0;
            }
            return;
        }
        // The earlier run is the root, whatever the order of the calls.
        let (root, child, offset) =
            if root_a < root_b { (root_a, root_b, between) } else { (root_b, root_a, sub([0; 2], between)) };
        self.runs[child].parent = root as u32;
        self.runs[child].offset = offset;
        let winds = self.runs[child].winds;
        for (mine, new) in self.runs[root].winds.iter_mut().zip(winds) {
            *mine |= new;
        }
    }

    /// The areas in order, for every run the number of its area, and the run's tiles in that area's frame.
    pub(super) fn areas(
        &mut self,
        width: usize,
        height: usize,
        seed: u32,
    ) -> (Vec<Area>, Vec<(u32, [i32; 2])>) {
        let places: Vec<(usize, [i32; 2])> = (0..self.runs.len()).map(|i| self.find(i)).collect();
        let mut number = vec![u32::MAX; self.runs.len()];
        let mut sums: Vec<Sum> = Vec::new();
        let mut owners = Vec::with_capacity(places.len());
        let waves = [Waves::new(width), Waves::new(height)];
        for y in 0..height {
            for i in self.row(y) {
                let (root, tiles) = places[i];
                if number[root] == u32::MAX {
                    number[root] = sums.len() as u32;
                    sums.push(Sum::new(self.runs[root].winds));
                }
                sums[number[root] as usize].add(&self.runs[i], y, tiles, width, height, &waves);
                owners.push((number[root], tiles));
            }
        }
        let mut areas: Vec<(usize, Area)> = sums.iter().map(|s| s.area(width, height)).enumerate().collect();

        // Order by place, coarsely, so that the grid's size does not shuffle neighbours of one row.
        areas.sort_by(|(i, a), (j, b)| {
            let key = |a: &Area| (coarse(a.center[1], step(a)), a.center[0], a.center[1]);
            key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal).then(i.cmp(j))
        });
        let mut place = vec![0; areas.len()];
        for (new, (old, _)) in areas.iter().enumerate() {
            place[*old] = new as u32;
        }
        for owner in &mut owners {
            owner.0 = place[owner.0 as usize];
        }
        let mut areas: Vec<Area> = areas.into_iter().map(|(_, area)| area).collect();
        name(&mut areas, seed);
        (areas, owners)
    }
}

fn add(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Half the area's typical size, as a power of two: coarser than what the grid's size changes, finer than the
/// distance to another area of that size.
fn step(area: &Area) -> f64 {
    let side = area.size[0].max(area.size[1]).max(1e-6);
    let mut step = 1.0;
    while step > 0.5 * side {
        step *= 0.5;
    }
    step
}

/// `x` on a grid of `step`. The grid starts off centre: regular patterns would lie on its borders otherwise.
fn coarse(x: f64, step: f64) -> f64 {
    ((x / step + 0.37).floor() - 0.37) * step
}

/// Random numbers from the areas' coarse places and sizes; equal ones are told apart by order.
fn name(areas: &mut [Area], seed: u32) {
    let mut taken = std::collections::BTreeMap::new();
    for area in areas {
        let step = step(area);
        let [u, v] = area.center.map(|c| (c / step + 0.37).floor() as u32);
        let place = hash::hash2(hash::hash1(seed, (1.0 / step) as u32), u, v);
        let again = taken.entry(place).and_modify(|n| *n += 1).or_insert(0u32);
        area.id = ((hash::hash1(place, *again) >> 8) + 1) as f32 / 16_777_216.0;
    }
}

/// Cosine and sine of every texel's place in one direction.
struct Waves(Vec<[f64; 2]>);

impl Waves {
    fn new(n: usize) -> Self {
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        Self((0..n).map(|i| [num::cos_turns(at(i)).into(), num::sin_turns(at(i)).into()]).collect())
    }
}

/// Sums over an area's texels.
struct Sum {
    texels: u64,
    min: [i64; 2],
    max: [i64; 2],
    first: [f64; 2],
    /// Of cosine and sine of the place, for directions in which the area goes round.
    wave: [[f64; 2]; 2],
    winds: [bool; 2],
}

impl Sum {
    fn new(winds: [bool; 2]) -> Self {
        let (min, max) = ([i64::MAX; 2], [i64::MIN; 2]);
        Self { texels: 0, min, max, first: [0.0; 2], wave: [[0.0; 2]; 2], winds }
    }

    fn add(&mut self, run: &Run, y: usize, tiles: [i32; 2], width: usize, height: usize, waves: &[Waves; 2]) {
        let n = u64::from(run.end - run.start);
        let left = i64::from(run.start) + i64::from(tiles[0]) * width as i64;
        let top = y as i64 + i64::from(tiles[1]) * height as i64;
        self.texels += n;
        self.min = [self.min[0].min(left), self.min[1].min(top)];
        self.max = [self.max[0].max(left + n as i64), self.max[1].max(top + 1)];
        self.first[0] += (left as f64 + 0.5 * n as f64) * n as f64;
        self.first[1] += (top as f64 + 0.5) * n as f64;
        if self.winds[0] {
            for [cos, sin] in &waves[0].0[run.start as usize..run.end as usize] {
                self.wave[0][0] += cos;
                self.wave[0][1] += sin;
            }
        }
        if self.winds[1] {
            let [cos, sin] = waves[1].0[y];
            self.wave[1][0] += cos * n as f64;
            self.wave[1][1] += sin * n as f64;
        }
    }

    fn area(&self, width: usize, height: usize) -> Area {
        let sides = [width as f64, height as f64];
        let n = self.texels as f64;
        let (mut corner, mut size, mut center) = ([0.0; 2], [1.0; 2], [0.0; 2]);
        for axis in 0..2 {
            if self.winds[axis] {
                let [cos, sin] = self.wave[axis].map(|w| w / n);
                // An even ring has no middle; the tile's own is as good as any.
                let even = cos * cos + sin * sin < 1e-6;
                let turns = num::atan2_turns(sin as f32, cos as f32);
                center[axis] = if even { 0.5 } else { f64::from(turns).rem_euclid(1.0) };
                corner[axis] = center[axis] - 0.5;
            } else {
                corner[axis] = self.min[axis] as f64 / sides[axis];
                size[axis] = (self.max[axis] - self.min[axis]) as f64 / sides[axis];
                center[axis] = (self.first[axis] / n / sides[axis]).rem_euclid(1.0);
            }
        }
        Area { corner, size, center, texels: self.texels, id: 0.0, winds: self.winds }
    }
}
