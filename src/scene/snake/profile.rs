//! Along the body: how wide and how high it is.

/// Half width and half height along the body.
#[derive(Debug)]
pub(super) struct Profile {
    length: f64,
    /// At each knot: angle w, where s = length (1 - cos w)/2; the half axes; and their slopes by w.
    knots: Vec<(f64, [f64; 2], [f64; 2])>,
}

/// Distance from the snout in diameters; half width; half height.
const HEAD: [(f64, f64, f64); 9] = [
    (0.0, 0.0, 0.0),
    (0.03, 0.080, 0.060),
    (0.12, 0.150, 0.110),
    (0.35, 0.230, 0.165),
    (0.65, 0.310, 0.210),
    (0.95, 0.370, 0.240),
    (1.15, 0.365, 0.250),
    (1.55, 0.300, 0.260),
    (2.0, 0.280, 0.270),
];
/// Share of the length; radius.
const BODY: [(f64, f64); 7] =
    [(0.16, 0.35), (0.30, 0.46), (0.42, 0.5), (0.55, 0.5), (0.70, 0.44), (0.83, 0.31), (0.92, 0.19)];
/// Distance from the tip of the tail in diameters; radius.
const TAIL: [(f64, f64); 5] = [(0.6, 0.085), (0.2, 0.055), (0.06, 0.040), (0.015, 0.023), (0.0, 0.0)];

impl Profile {
    pub(super) fn new(length: f64) -> Self {
        let head = HEAD.into_iter();
        let body = BODY.into_iter().map(|(share, r)| (share * length, r, r));
        let tail = TAIL.into_iter().map(|(rest, r)| (length - rest, r, r));
        let knots: Vec<(f64, [f64; 2])> = head
            .chain(body)
            .chain(tail)
            .map(|(s, a, b)| (libm::acos((1.0 - 2.0 * s / length).max(-1.0).min(1.0)), [a, b]))
            .collect();
        let slopes: Vec<[f64; 2]> =
            (0..knots.len()).map(|i| [0, 1].map(|axis| monotone_slope(&knots, i, axis))).collect();
        let knots = knots.into_iter().zip(slopes).map(|((w, r), slope)| (w, r, slope)).collect();
        Self { length, knots }
    }

    /// Half axes, and their derivatives by the distance from the snout: huge at the very ends.
    pub(super) fn at(&self, s: f64) -> ([f64; 2], [f64; 2]) {
        let cos = (1.0 - 2.0 * s / self.length).max(-1.0).min(1.0);
        let w = libm::acos(cos);
        let after = self.knots.partition_point(|knot| knot.0 <= w).max(1).min(self.knots.len() - 1);
        let (&(w0, p, m), &(w1, q, n)) = (&self.knots[after - 1], &self.knots[after]);
        let width = w1 - w0;
        let t = (w - w0) / width;
        // ds/dw = length sin(w)/2.
        let pace = (0.5 * self.length * libm::sin(w)).max(1e-9);
        let of = |k: usize| {
            let (m, n, rest) = (m[k] * width, n[k] * width, q[k] - p[k]);
            let (b, c) = (3.0 * rest - 2.0 * m - n, m + n - 2.0 * rest);
            (p[k] + (m + (b + c * t) * t) * t, (m + (2.0 * b + 3.0 * c * t) * t) / (width * pace))
        };
        let (a, b) = (of(0), of(1));
        ([a.0.max(0.0), b.0.max(0.0)], [a.1, b.1])
    }
}

/// Slope of a cubic Hermite curve that has no extremum between knots (Fritsch & Butland 1984); at the ends the chord's.
fn monotone_slope(knots: &[(f64, [f64; 2])], i: usize, axis: usize) -> f64 {
    let chord = |j: usize| (knots[j + 1].1[axis] - knots[j].1[axis]) / (knots[j + 1].0 - knots[j].0);
    if i == 0 || i + 1 == knots.len() {
        return chord(if i == 0 { 0 } else { i - 1 });
    }
    let (before, after) = (chord(i - 1), chord(i));
    if before * after <= 0.0 {
        return 0.0;
    }
    let (h0, h1) = (knots[i].0 - knots[i - 1].0, knots[i + 1].0 - knots[i].0);
    let share = (h0 + 2.0 * h1) / (3.0 * (h0 + h1));
    before * after / (share * after + (1.0 - share) * before)
}
